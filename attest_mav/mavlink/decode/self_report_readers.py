"""The readers of an autopilot's words about itself: EKF_STATUS_REPORT, ESTIMATOR_STATUS, SYS_STATUS."""

from typing import Final

from attest_mav.mavlink.constants import (
    EKF_ATTITUDE,
    EKF_GPS_GLITCHING,
    ESTIMATOR_ACCEL_ERROR,
    ESTIMATOR_ATTITUDE,
    ESTIMATOR_GPS_GLITCH,
    MAV_SYS_STATUS_AHRS,
    MAV_SYS_STATUS_SENSOR_3D_ACCEL,
    MAV_SYS_STATUS_SENSOR_3D_ACCEL2,
    MAV_SYS_STATUS_SENSOR_3D_GYRO,
    MAV_SYS_STATUS_SENSOR_3D_GYRO2,
    MAV_SYS_STATUS_SENSOR_3D_MAG,
    MAV_SYS_STATUS_SENSOR_3D_MAG2,
    MAV_SYS_STATUS_SENSOR_GPS,
)
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample
from attest_mav.vehicle_reports import EstimatorStatusSample, SensorHealthSample

ARDUPILOT_LIMIT: Final = 0.8
"""Usual value of FS_EKF_THRESH, above which ArduPilot itself takes a variance for bad."""
RATIO_LIMIT: Final = 1.0
"""Above this an innovation is rejected."""

PARTS: Final = (
    (MAV_SYS_STATUS_SENSOR_3D_GYRO, "gyro"),
    (MAV_SYS_STATUS_SENSOR_3D_ACCEL, "accelerometer"),
    (MAV_SYS_STATUS_SENSOR_3D_MAG, "magnetometer"),
    (MAV_SYS_STATUS_SENSOR_GPS, "GPS"),
    (MAV_SYS_STATUS_SENSOR_3D_GYRO2, "second gyro"),
    (MAV_SYS_STATUS_SENSOR_3D_ACCEL2, "second accelerometer"),
    (MAV_SYS_STATUS_SENSOR_3D_MAG2, "second magnetometer"),
    (MAV_SYS_STATUS_AHRS, "AHRS"),
)
"""The bits of SYS_STATUS that concern an attitude, with their names."""


class EkfStatusReader(Reader):
    """EKF_STATUS_REPORT of ArduPilot; its "variances" are the square roots of innovation test ratios."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("EKF_STATUS_REPORT")
        self._fields: Final = dialect.layout(self.name).pick(
            "velocity_variance", "pos_horiz_variance", "pos_vert_variance", "compass_variance", "flags",
            "airspeed_variance",
        )  # fmt: skip

    def read(self, frame: Frame) -> list[Sample]:
        """One EstimatorStatusSample."""
        velocity, position, height, compass, flags, airspeed = self._fields.unpack(frame.payload)
        return [
            EstimatorStatusSample(
                self.name,
                frame.system,
                frame.component,
                frame.rx_ns,
                flags & EKF_ATTITUDE != 0,
                flags & EKF_GPS_GLITCHING != 0,
                False,
                velocity,
                position,
                height,
                compass,
                airspeed,
                ARDUPILOT_LIMIT,
            )
        ]


class EstimatorStatusReader(Reader):
    """ESTIMATOR_STATUS, PX4's form of the same."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("ESTIMATOR_STATUS")
        self._fields: Final = dialect.layout(self.name).pick(
            "vel_ratio", "pos_horiz_ratio", "pos_vert_ratio", "mag_ratio", "tas_ratio", "flags"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """One EstimatorStatusSample."""
        velocity, position, height, compass, airspeed, flags = self._fields.unpack(frame.payload)
        return [
            EstimatorStatusSample(
                self.name,
                frame.system,
                frame.component,
                frame.rx_ns,
                flags & ESTIMATOR_ATTITUDE != 0,
                flags & ESTIMATOR_GPS_GLITCH != 0,
                flags & ESTIMATOR_ACCEL_ERROR != 0,
                velocity,
                position,
                height,
                compass,
                airspeed,
                RATIO_LIMIT,
            )
        ]


class SensorHealthReader(Reader):
    """SYS_STATUS: a part is unhealthy where it is present and enabled, and its health bit is not set."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("SYS_STATUS")
        self._fields: Final = dialect.layout(self.name).pick(
            "onboard_control_sensors_present", "onboard_control_sensors_enabled", "onboard_control_sensors_health"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """One SensorHealthSample."""
        present, enabled, health = self._fields.unpack(frame.payload)
        bad = present & enabled & ~health
        unhealthy = tuple([name for bit, name in PARTS if bad & bit])
        return [SensorHealthSample(self.name, frame.system, frame.component, frame.rx_ns, unhealthy)]
