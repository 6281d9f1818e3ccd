"""Payloads: what the vehicle knows, in the units and with the resolution of each message.

The units are the firmware's: integers are cut toward zero as a C cast does, which leaves a bias of half a unit.
"""

from collections.abc import Callable
from functools import partial
from math import atan2, degrees, hypot, isnan
from typing import Final

from attest_mav.algebra import q_to_euler, sub
from attest_mav.mavlink import constants as mavlink
from attest_mav.mavlink.dialect import Dialect, Picked
from attest_mav.sim.earth import Earth
from attest_mav.sim.motion import Motion
from attest_mav.sim.parameters import ParameterTable
from attest_mav.sim.personality import Personality
from attest_mav.sim.report import AttitudeReport
from attest_mav.sim.self_report import ekf_status_report, estimator_status, sys_status
from attest_mav.sim.sensors import SensorSuite
from attest_mav.sim.settings import SimSettings
from attest_mav.sim.trajectory import STILL_S, Trajectory
from attest_mav.sim.trim import trimmed_angles, trimmed_matrix, trimmed_quaternion
from attest_mav.types import G_MPS2, Vec3

UNIX_EPOCH_US: Final = 1_750_000_000_000_000
"""Wall-clock time at the start of every simulation: June 2025, when the default field holds."""

AXES: Final = ("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro", "xmag", "ymag", "zmag")
TURN: Final = ("rollspeed", "pitchspeed", "yawspeed")

FIELDS: Final = {
    "HEARTBEAT": ("custom_mode", "type", "autopilot", "base_mode", "system_status", "mavlink_version"),
    "RAW_IMU": ("time_usec", *AXES),
    "SCALED_IMU": ("time_boot_ms", *AXES),
    "SCALED_IMU2": ("time_boot_ms", *AXES),
    "SCALED_IMU3": ("time_boot_ms", *AXES),
    "HIGHRES_IMU": ("time_usec", *AXES, "fields_updated"),
    "ATTITUDE": ("time_boot_ms", "roll", "pitch", "yaw", *TURN),
    "ATTITUDE_QUATERNION": ("time_boot_ms", "q1", "q2", "q3", "q4", *TURN),
    "SIM_STATE": (
        *("q1", "q2", "q3", "q4", "roll", "pitch", "yaw"),
        *("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro", "lat", "lon", "alt", "vn", "ve", "vd"),
        *("lat_int", "lon_int"),
    ),
    "GPS_RAW_INT": (
        *("time_usec", "lat", "lon", "alt", "eph", "epv", "vel", "cog"),
        *("fix_type", "satellites_visible", "vel_acc"),
    ),
    "GLOBAL_POSITION_INT": ("time_boot_ms", "lat", "lon", "alt", "relative_alt", "vx", "vy", "vz", "hdg"),
    "VFR_HUD": ("airspeed", "groundspeed", "alt", "climb", "heading", "throttle"),
    "SYSTEM_TIME": ("time_unix_usec", "time_boot_ms"),
    "EKF_STATUS_REPORT": (
        *("velocity_variance", "pos_horiz_variance", "pos_vert_variance", "compass_variance"),
        "flags",
    ),
    "ESTIMATOR_STATUS": ("vel_ratio", "pos_horiz_ratio", "pos_vert_ratio", "mag_ratio", "flags"),
    "SYS_STATUS": (
        "onboard_control_sensors_present",
        "onboard_control_sensors_enabled",
        "onboard_control_sensors_health",
    ),
    "AHRS2": ("roll", "pitch", "yaw"),
    "AUTOPILOT_VERSION": ("flight_sw_version",),
}
"""The fields that are filled, in wire order; all others are zero."""


def int16(value: float) -> int:
    """The value cut toward zero and held within int16; NaN becomes 0."""
    if -32769.0 < value < 32768.0:
        return int(value)
    return 0 if isnan(value) else 32767 if value > 0.0 else -32768


class Messages:
    """Builds payloads. ``begin`` says for which time; then any number of ``payload`` calls."""

    def __init__(
        self,
        settings: SimSettings,
        personality: Personality,
        dialect: Dialect,
        trajectory: Trajectory,
        sensors: SensorSuite,
        report: AttitudeReport,
        parameters: ParameterTable,
    ) -> None:
        self.settings = settings
        self.personality = personality
        self.trajectory = trajectory
        self.sensors = sensors
        self.report = report
        self.parameters = parameters
        self.earth: Earth = settings.earth
        self.picked: dict[str, Picked] = {name: dialect.layout(name).pick(*names) for name, names in FIELDS.items()}
        self.mag_count_sent = 0
        self.t_s = 0.0
        self.t_ns = 0
        self.boot_us = 0
        self.motion: Motion = trajectory.at(0.0)
        self.builders: dict[str, Callable[[], tuple[float, ...]]] = {
            "HEARTBEAT": self.heartbeat,
            "RAW_IMU": self.raw_imu,
            "SCALED_IMU": partial(self.scaled_imu, 0),
            "SCALED_IMU2": partial(self.scaled_imu, 1),
            "SCALED_IMU3": self.scaled_imu3,
            "HIGHRES_IMU": self.highres_imu,
            "ATTITUDE": self.attitude,
            "ATTITUDE_QUATERNION": self.attitude_quaternion,
            "SIM_STATE": self.sim_state,
            "GPS_RAW_INT": self.gps_raw_int,
            "GLOBAL_POSITION_INT": self.global_position_int,
            "VFR_HUD": self.vfr_hud,
            "SYSTEM_TIME": self.system_time,
            "AHRS2": self.ahrs2,
            "AUTOPILOT_VERSION": self.autopilot_version,
            "EKF_STATUS_REPORT": partial(ekf_status_report, report.lanes),
            "ESTIMATOR_STATUS": partial(estimator_status, report.lanes),
            "SYS_STATUS": partial(sys_status, report.lanes),
        }

    def begin(self, t_ns: int, boot_ns: int, motion: Motion) -> None:
        """From now on payloads are for this time of the simulation, with a clock that started at ``boot_ns``."""
        self.t_ns = t_ns
        self.t_s = t_ns * 1e-9
        self.boot_us = (t_ns - boot_ns) // 1000
        self.motion = motion

    def payload(self, name: str) -> bytes:
        """The payload of a message, trailing zeros not yet cut."""
        return self.picked[name].pack(*self.builders[name]())

    def heartbeat(self) -> tuple[int, ...]:
        """Armed from shortly before a vehicle moves."""
        armed = self.trajectory.flies and self.t_s >= STILL_S - 1.0
        mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0)
        state = mavlink.MAV_STATE_ACTIVE if armed else mavlink.MAV_STATE_STANDBY
        return (0, self.trajectory.vehicle_type, self.personality.autopilot, mode, state, mavlink.MAVLINK_VERSION)

    # --- inertial ----------------------------------------------------------------------------------------------

    def raw_imu(self) -> tuple[int, ...]:
        """ArduPilot's: calibrated, filtered, milli-units, and the time of sending in microseconds."""
        return (self.boot_us, *self._milli(0, self.sensors.mags[0].held))

    def scaled_imu(self, unit: int) -> tuple[int, ...]:
        """ArduPilot: as RAW_IMU, of either unit. PX4: with the magnetometer as the chip gives it."""
        held = self.sensors.mags[unit].held
        mag = held if self.personality.takes_groups else self._uncalibrated(held)
        return (self.boot_us // 1000, *self._milli(unit, mag))

    def scaled_imu3(self) -> tuple[int, ...]:
        """There is no third unit: ArduPilot then sends a magnetometer and no accelerometer or gyro."""
        mag = self.sensors.mags[0].held
        return (self.boot_us // 1000, 0, 0, 0, 0, 0, 0, *(int16(m * 1000.0) for m in mag))

    def highres_imu(self) -> tuple[float, ...]:
        """PX4's selected unit: its bias estimates, here perfect ones, are subtracted."""
        selected = self.report.lanes.selected
        imu, mag = self.sensors.imus[selected], self.sensors.mags[selected]
        accel, gyro = sub(imu.accel.reading, imu.accel.bias), sub(imu.gyro.reading, imu.gyro.bias)
        updated = mavlink.HIGHRES_IMU_UPDATED_ACCEL | mavlink.HIGHRES_IMU_UPDATED_GYRO
        if mag.count != self.mag_count_sent:
            updated |= mavlink.HIGHRES_IMU_UPDATED_MAG
        self.mag_count_sent = mag.count
        return (self.boot_us, *accel, *gyro, *mag.held, updated)

    def _milli(self, unit: int, mag: Vec3) -> tuple[int, ...]:
        """mG, mrad/s and mgauss."""
        imu = self.sensors.imus[unit]
        accel, gyro = imu.accel.reading, imu.gyro.reading
        milli_g = 1000.0 / G_MPS2
        return (
            *(int16(value * milli_g) for value in accel),
            *(int16(value * 1000.0) for value in (*gyro, *mag)),
        )

    def _uncalibrated(self, mag: Vec3) -> Vec3:
        """In the axes of a compass mounted upside down (rolled by 180 degrees), the vehicle's own field included."""
        offset = self.settings.mag_offset
        return (mag[0] + offset[0], -mag[1] + offset[1], -mag[2] + offset[2])

    # --- attitude ----------------------------------------------------------------------------------------------

    def attitude(self) -> tuple[float, ...]:
        """The reported attitude, trimmed; the rates are the body's."""
        q, rates = self.report.at(self.t_s, self.motion)
        return (self.boot_us // 1000, *trimmed_angles(q, self.parameters.trim), *rates)

    def attitude_quaternion(self) -> tuple[float, ...]:
        """The reported attitude, trimmed."""
        q, rates = self.report.at(self.t_s, self.motion)
        return (self.boot_us // 1000, *trimmed_quaternion(q, self.parameters.trim), *rates)

    def ahrs2(self) -> tuple[float, ...]:
        """The attitude of the secondary estimator, which here agrees with the first."""
        q, _ = self.report.at(self.t_s, self.motion)
        return q_to_euler(trimmed_matrix(q, self.parameters.trim))

    def autopilot_version(self) -> tuple[int, ...]:
        """The firmware's version."""
        return (self.personality.version,)

    def sim_state(self) -> tuple[float, ...]:
        """The truth. Latitude and longitude also as floats of 1e-7 degrees, as ArduPilot has them."""
        motion = self.motion
        lat, lon, alt = self.earth.geodetic(self.trajectory.position(self.t_s))
        e7 = (round(lat * 1e7), round(lon * 1e7))
        euler = q_to_euler(motion.q_nb)
        return (*motion.q_nb, *euler, *motion.specific_force(), *motion.rates, *e7, alt, *motion.v_ned, *e7)

    # --- navigation --------------------------------------------------------------------------------------------

    def gps_raw_int(self) -> tuple[int, ...]:
        """The latest fix and its time; the horizontal velocity as speed and course."""
        gps = self.sensors.gps
        if not gps.has_fix:
            return (*(0,) * 4, *(mavlink.UINT16_MAX,) * 4, mavlink.GPS_FIX_TYPE_NO_FIX, 0, 0)
        lat, lon, alt = self.earth.geodetic(gps.position)
        speed = hypot(gps.velocity[0], gps.velocity[1])
        course = degrees(atan2(gps.velocity[1], gps.velocity[0])) % 360.0
        fix_us = max(gps.fix_ns // 1000 - (self.t_ns // 1000 - self.boot_us), 0)
        return (
            *(fix_us, round(lat * 1e7), round(lon * 1e7), round(alt * 1e3)),
            *(80, 120, int(speed * 100.0), int(course * 100.0), mavlink.GPS_FIX_TYPE_3D_FIX, 14),
            round(gps.accuracy * 1e3),
        )

    def global_position_int(self) -> tuple[int, ...]:
        """The autopilot's filtered position; nothing but zeros before the first fix."""
        heading = int(self._heading_deg() * 100.0)
        if not self.sensors.gps.fix_ns:
            return (self.boot_us // 1000, 0, 0, 0, 0, 0, 0, 0, heading)
        position, v = self.trajectory.position(self.t_s), self.motion.v_ned
        lat, lon, alt = self.earth.geodetic(position)
        return (
            *(self.boot_us // 1000, round(lat * 1e7), round(lon * 1e7), round(alt * 1e3), round(-position[2] * 1e3)),
            *(int16(v[0] * 100.0), int16(v[1] * 100.0), int16(v[2] * 100.0), heading),
        )

    def vfr_hud(self) -> tuple[float, ...]:
        """There is no wind: airspeed is groundspeed, and zero for a copter, which has no sensor for it."""
        v = self.motion.v_ned
        speed = hypot(v[0], v[1])
        airspeed = hypot(speed, v[2]) if self.trajectory.is_plane else 0.0
        _, _, altitude = self.earth.geodetic(self.trajectory.position(self.t_s))
        return (airspeed, speed, altitude, -v[2], int(self._heading_deg()), 0)

    def _heading_deg(self) -> float:
        """Heading of the reported attitude, degrees in [0, 360)."""
        q, _ = self.report.at(self.t_s, self.motion)
        return degrees(q_to_euler(q)[2]) % 360.0

    def system_time(self) -> tuple[int, ...]:
        """The wall clock is known from the first fix on."""
        unix_us = UNIX_EPOCH_US + self.t_ns // 1000 if self.sensors.gps.fix_ns else 0
        return (unix_us, self.boot_us // 1000)
