"""The charter: units, frames, time, and the value types every layer shares.

Units
    SI and radians everywhere inside the package; degrees only where a person reads or writes.
    Magnetic fields are in gauss (the Earth's is 0.25 to 0.65 gauss). Standard gravity is ``G_MPS2``.

Frames
    Body ``b`` is FRD (forward, right, down). World ``n`` is NED (north, east, down).
    ``q_nb`` is a unit Hamilton quaternion (w, x, y, z) that turns body vectors into NED:
    ``v_n = q_nb * v_b * conj(q_nb)``. It is exactly what MAVLink's ATTITUDE_QUATERNION carries.
    The accelerometer measures specific force: (0, 0, -g) when level and at rest.

Time
    Instants are integer nanoseconds, intervals are float seconds. ``t_ns`` is the sensor's clock, the
    time that the message itself carries; ``rx_ns`` is the host's clock at reception. Filters use
    ``t_ns`` only. ``NO_TIME`` marks messages that carry none.

North
    ``North`` says what a heading refers to. Magnetic and true north differ by the declination
    (positive east): true = magnetic + declination.

Records made once a sample are plain classes, set once and never changed afterwards: compiled, they are
made in some 30 ns, where a frozen dataclass takes 550.
"""

from enum import IntEnum
from math import nan
from typing import Final

Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]
Mat3 = tuple[Vec3, Vec3, Vec3]
"""Three rows."""

G_MPS2: Final = 9.80665
"""Standard gravity; MAVLink's milli-g are thousandths of it."""

NO_TIME: Final = -1
"""``t_ns`` of a message that carries no timestamp (SIM_STATE, SIMSTATE, AHRS2)."""


class North(IntEnum):
    """What a heading is measured from."""

    RELATIVE = 0
    """Nothing: the heading at the start was taken as zero, or has drifted since the field was lost."""
    MAGNETIC = 1
    TRUE = 2


class Setting(IntEnum):
    """A setting of the vehicle that a filter makes use of and the autopilot can tell."""

    LOW_PASS_HZ = 0
    """Corner of the low-pass that gyro and accelerometer have passed, Hz; 0 for none."""
    FIX_DELAY_S = 1
    """Age of the receiver's velocity at the time that GPS_RAW_INT names, s."""


class EarthField:
    """The direction of the Earth's magnetic field where the vehicle is; rad, NaN where it is not known.

    declination: east of true north. inclination: below the horizontal.
    """

    def __init__(self, declination: float = nan, inclination: float = nan) -> None:
        self.declination: Final = declination
        self.inclination: Final = inclination


class Sample:
    """Base of everything a decoder makes out of one message.

    ``source`` is the MAVLink message name, ``system`` and ``component`` who sent it.
    """

    def __init__(self, source: str, system: int, component: int, t_ns: int, rx_ns: int) -> None:
        self.source: Final = source
        self.system: Final = system
        self.component: Final = component
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns


class ImuSample(Sample):
    """One reading of one inertial sensor, in SI units, body frame.

    gyro: angular rate, rad/s. accel: specific force, m/s^2. mag: field, gauss; None when the message carries
    none or a field of zeros. saturated: a gyro or accelerometer component is at 99 % of its range or more.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        gyro: Vec3,
        accel: Vec3,
        mag: Vec3 | None,
        saturated: bool = False,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.mag: Final = mag
        self.saturated: Final = saturated

    def with_readings(self, gyro: Vec3, accel: Vec3, mag: Vec3 | None) -> "ImuSample":
        """The same sample with other readings; units as above."""
        return ImuSample(
            self.source, self.system, self.component, self.t_ns, self.rx_ns, gyro, accel, mag, self.saturated
        )


class AttitudeSample(Sample):
    """An attitude someone else reports: the autopilot (ATTITUDE, ATTITUDE_QUATERNION, AHRS2) or a simulator's truth.

    q_nb: body to NED, true north. rates: body angular rate, rad/s, or None where the message has none.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        q_nb: Quat,
        rates: Vec3 | None,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.q_nb: Final = q_nb
        self.rates: Final = rates


class VelocitySample(Sample):
    """Velocity over ground in NED, m/s (GPS_RAW_INT, GLOBAL_POSITION_INT, LOCAL_POSITION_NED).

    ``vertical_known`` is False where the message has no vertical velocity (its z is then 0).
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        v_ned: Vec3,
        vertical_known: bool,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.v_ned: Final = v_ned
        self.vertical_known: Final = vertical_known


class PositionSample(Sample):
    """A position good enough to look up the declination: GPS_RAW_INT with a 3-D fix.

    Latitude and longitude in degrees (people's units: they are only ever shown or looked up), altitude in m.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        t_ns: int,
        rx_ns: int,
        latitude_deg: float,
        longitude_deg: float,
        altitude_m: float,
    ) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.latitude_deg: Final = latitude_deg
        self.longitude_deg: Final = longitude_deg
        self.altitude_m: Final = altitude_m


class AirDataSample(Sample):
    """VFR_HUD: airspeed and groundspeed in m/s, climb in m/s upward. VFR_HUD carries no time."""

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        airspeed: float,
        groundspeed: float,
        climb: float,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.airspeed: Final = airspeed
        self.groundspeed: Final = groundspeed
        self.climb: Final = climb


class HeartbeatSample(Sample):
    """HEARTBEAT: who is there. ``vehicle_type`` is MAV_TYPE, ``autopilot`` MAV_AUTOPILOT, ``status`` MAV_STATE."""

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        vehicle_type: int,
        autopilot: int,
        armed: bool,
        status: int,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.vehicle_type: Final = vehicle_type
        self.autopilot: Final = autopilot
        self.armed: Final = armed
        self.status: Final = status


class ClockSample(Sample):
    """SYSTEM_TIME: ``t_ns`` is time since boot, ``unix_us`` the wall clock in microseconds (0 when unknown)."""

    def __init__(self, source: str, system: int, component: int, t_ns: int, rx_ns: int, unix_us: int) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.unix_us: Final = unix_us


class ParameterSample(Sample):
    """PARAM_VALUE of a parameter that tells a setting. ``name`` is the autopilot's; PARAM_VALUE carries no time.

    value: in the unit of the setting, NaN where the autopilot leaves the setting to a default that it does not tell.
    """

    def __init__(
        self, source: str, system: int, component: int, rx_ns: int, name: str, setting: Setting, value: float
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.name: Final = name
        self.setting: Final = setting
        self.value: Final = value


class Estimate:
    """What one lane's filter says about one IMU sample.

    lane: the IMU message. filter_name: the filter. q_nb: body to NED, sign-continuous. rates: bias-corrected body
    angular rate, rad/s. north: what the heading refers to. tilt_sigma, heading_sigma: 1-sigma, rad, NaN where the
    filter has no covariance. dt_s: the step that led here, s. delay_s: how much later than usual the sample came, s.
    velocity_nis, field_nis: normalised innovation squared of the velocity and of the magnetometer in this step, mean of
    the axes; NaN where the step had none. aided: a velocity over ground tells acceleration from tilt.
    """

    def __init__(
        self,
        lane: str,
        filter_name: str,
        t_ns: int,
        rx_ns: int,
        q_nb: Quat,
        rates: Vec3,
        north: North,
        tilt_sigma: float,
        heading_sigma: float,
        dt_s: float,
        delay_s: float = 0.0,
        velocity_nis: float = nan,
        field_nis: float = nan,
        aided: bool = False,
    ) -> None:
        self.lane: Final = lane
        self.filter_name: Final = filter_name
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns
        self.q_nb: Final = q_nb
        self.rates: Final = rates
        self.north: Final = north
        self.tilt_sigma: Final = tilt_sigma
        self.heading_sigma: Final = heading_sigma
        self.dt_s: Final = dt_s
        self.delay_s: Final = delay_s
        self.velocity_nis: Final = velocity_nis
        self.field_nis: Final = field_nis
        self.aided: Final = aided
