"""The readers of attitudes, receiver, airspeed and the vehicle's state."""

from math import isfinite, nan
from typing import Final

from attest_mav.algebra import is_finite, q_unit
from attest_mav.logs.ulog.reader import COMPONENT, SAMPLE_TIME, SYSTEM, TIME, TopicReader
from attest_mav.mavlink.constants import (
    ESTIMATOR_ACCEL_ERROR,
    ESTIMATOR_ATTITUDE,
    ESTIMATOR_GPS_GLITCH,
    GPS_FIX_TYPE_3D_FIX,
    MAV_AUTOPILOT_PX4,
    MAV_STATE_ACTIVE,
    MAV_STATE_STANDBY,
    UINT8_MAX,
    UINT16_MAX,
)
from attest_mav.mavlink.decode.attitude_readers import is_attitude
from attest_mav.mavlink.decode.motion_readers import receiver_sigma
from attest_mav.mavlink.decode.self_report_readers import RATIO_LIMIT
from attest_mav.mavlink.decode.vehicle_kinds import vehicle_kind
from attest_mav.samples import AirDataSample, AttitudeSample, PositionSample, Sample, VelocitySample
from attest_mav.types import AirspeedSource, AttitudeForm, AttitudeRole, Quat, Vec3, VelocityOrigin
from attest_mav.vehicle_reports import ClockSample, EstimatorStatusSample, HeartbeatSample, LandedSample

ARMED: Final = 2.0
"""Value of vehicle_status.arming_state."""


class AttitudeReader(TopicReader):
    """vehicle_attitude and its like: a quaternion at the time of the sample that it was computed from."""

    def __init__(self, source: str, role: AttitudeRole) -> None:
        quaternion = [f"q[{index}]" for index in range(4)]
        super().__init__([SAMPLE_TIME, *quaternion, "rollspeed", "pitchspeed", "yawspeed"])
        self._source: Final = source
        self._role: Final = role

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """One AttitudeSample."""
        q: Quat = (numbers[1], numbers[2], numbers[3], numbers[4])
        if not is_attitude(q):
            return []
        rates: Vec3 = (numbers[5], numbers[6], numbers[7])
        told = rates if is_finite(rates) else None
        form = AttitudeForm.QUATERNION
        return [AttitudeSample(self._source, SYSTEM, COMPONENT, t_ns, t_ns, q_unit(q), told, self._role, form)]


class ReceiverReader(TopicReader):
    """vehicle_gps_position, or sensor_gps, with a 3-D fix."""

    def __init__(self, source: str) -> None:
        velocity = ["vel_n_m_s", "vel_e_m_s", "vel_d_m_s", "vel_ned_valid"]
        quality = ["fix_type", "s_variance_m_s", "hdop", "satellites_used"]
        place = ["latitude_deg", "longitude_deg", "altitude_msl_m", "lat", "lon", "alt"]
        super().__init__([TIME, *velocity, *quality, *place, "time_utc_usec"])
        self._source: Final = source
        self._has_dated = False

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """A VelocitySample and a PositionSample; before the first ones a ClockSample with the date."""
        if not numbers[5] >= GPS_FIX_TYPE_3D_FIX:
            return []
        samples: list[Sample] = []
        if numbers[15] > 0.0 and not self._has_dated:
            self._has_dated = True
            samples.append(ClockSample(self._source, SYSTEM, COMPONENT, t_ns, t_ns, int(numbers[15])))
        v_ned: Vec3 = (numbers[1], numbers[2], numbers[3])
        if numbers[4] != 0.0 and is_finite(v_ned):
            origin, sigma = VelocityOrigin.RECEIVER, self._sigma(numbers[6], numbers[7], numbers[8])
            samples.append(VelocitySample(self._source, SYSTEM, COMPONENT, t_ns, t_ns, v_ned, True, origin, sigma))
        latitude, longitude, altitude = numbers[9], numbers[10], numbers[11]
        if not isfinite(latitude + longitude):
            latitude, longitude, altitude = 1e-7 * numbers[12], 1e-7 * numbers[13], 1e-3 * numbers[14]
        if isfinite(latitude + longitude + altitude):
            place = (latitude, longitude, altitude)
            satellites = int(numbers[8]) if isfinite(numbers[8]) else None
            dilution = numbers[7] if numbers[7] > 0.0 else None
            samples.append(PositionSample(self._source, SYSTEM, COMPONENT, t_ns, t_ns, *place, satellites, dilution))
        return samples

    @staticmethod
    def _sigma(reported: float, hdop: float, satellites: float) -> float | None:
        """As that of GPS_RAW_INT."""
        eph = min(int(100.0 * hdop), UINT16_MAX - 1) if isfinite(hdop) and hdop >= 0.0 else UINT16_MAX
        count = int(satellites) if isfinite(satellites) else UINT8_MAX
        return receiver_sigma(reported if isfinite(reported) else 0.0, eph, count)


class AirspeedReader(TopicReader):
    """airspeed: the sensor's, through the air as it is and not as at sea level."""

    def __init__(self) -> None:
        super().__init__([TIME, "true_airspeed_m_s|indicated_airspeed_m_s"])

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """One AirDataSample."""
        if not isfinite(numbers[1]):
            return []
        return [AirDataSample("airspeed", SYSTEM, COMPONENT, t_ns, numbers[1], nan, nan, AirspeedSource.SENSOR)]


class StatusReader(TopicReader):
    """vehicle_status: the kind of vehicle, whether it is armed, its mode."""

    def __init__(self) -> None:
        super().__init__([TIME, "system_type", "arming_state", "nav_state"])
        self._last: list[float] = []

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """One HeartbeatSample where something has changed."""
        told = numbers[1:]
        if told == self._last or not isfinite(told[0] + told[1] + told[2]):
            return []
        self._last = told
        vehicle_type, armed, mode = int(told[0]), told[1] == ARMED, int(told[2])
        state = MAV_STATE_ACTIVE if armed else MAV_STATE_STANDBY
        kind = vehicle_kind(vehicle_type)
        source, autopilot = "vehicle_status", MAV_AUTOPILOT_PX4
        return [HeartbeatSample(source, SYSTEM, COMPONENT, t_ns, vehicle_type, autopilot, armed, state, kind, mode)]


class LandedReader(TopicReader):
    """vehicle_land_detected."""

    def __init__(self) -> None:
        super().__init__([TIME, "landed"])
        self._landed = nan

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """One LandedSample at a change."""
        landed = numbers[1]
        if not isfinite(landed) or landed == self._landed:
            return []
        self._landed = landed
        return [LandedSample("vehicle_land_detected", SYSTEM, COMPONENT, t_ns, landed != 0.0)]


class EstimatorReader(TopicReader):
    """estimator_status: the estimator on itself. Its numbers are those of ESTIMATOR_STATUS."""

    def __init__(self) -> None:
        ratios = [f"{name}_test_ratio" for name in ("vel", "pos", "hgt", "mag", "tas")]
        super().__init__([TIME, "solution_status_flags", *ratios])

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """One EstimatorStatusSample."""
        if not isfinite(numbers[1]):
            return []
        flags = int(numbers[1])
        is_valid, is_glitch, is_wrong = [
            flags & bit != 0 for bit in (ESTIMATOR_ATTITUDE, ESTIMATOR_GPS_GLITCH, ESTIMATOR_ACCEL_ERROR)
        ]
        ratios, source = numbers[2:], "estimator_status"
        return [
            EstimatorStatusSample(
                source,
                SYSTEM,
                COMPONENT,
                t_ns,
                is_valid,
                is_glitch,
                is_wrong,
                ratios[0],
                ratios[1],
                ratios[2],
                ratios[3],
                ratios[4],
                RATIO_LIMIT,
            )
        ]
