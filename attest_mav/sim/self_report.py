"""What the fake autopilot says of itself: the health of its sensors, and the state of its estimator.

It knows what its drivers notice and how long a lane has been inconsistent, and nothing of the true error.
"""

from typing import Final

from attest_mav.mavlink import constants as mavlink
from attest_mav.sim.lanes import Lanes

USUAL_RATIO: Final = 0.1
"""Innovation test ratio of an estimator in good order."""
SENSOR_BITS: Final = (
    (mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO, mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL),
    (mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO2, mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL2),
)
"""Gyro and accelerometer of each inertial sensor."""
OTHER_BITS: Final = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG2
    | mavlink.MAV_SYS_STATUS_SENSOR_GPS
    | mavlink.MAV_SYS_STATUS_AHRS
)


def sys_status(lanes: Lanes) -> tuple[int, int, int]:
    """The first three fields of SYS_STATUS: parts present, enabled and healthy."""
    present = OTHER_BITS
    bad = 0 if lanes.gps.has_fix else mavlink.MAV_SYS_STATUS_SENSOR_GPS
    for lane, (gyro, accel) in zip(lanes.lanes, SENSOR_BITS, strict=True):
        present |= gyro | accel
        bad |= (gyro if lane.imu.gyro.stopped else 0) | (accel if lane.imu.accel.stopped else 0)
    if lanes.lanes[lanes.selected].has_failed:
        bad |= mavlink.MAV_SYS_STATUS_AHRS
    return (present, present, present & ~bad)


def ekf_status_report(lanes: Lanes) -> tuple[float, ...]:
    """Variances of velocity, position, height and compass, and the flags, of EKF_STATUS_REPORT."""
    return (*_ratios(lanes), mavlink.EKF_ATTITUDE)


def estimator_status(lanes: Lanes) -> tuple[float, ...]:
    """The same four ratios and the flags of ESTIMATOR_STATUS."""
    return (*_ratios(lanes), mavlink.ESTIMATOR_ATTITUDE)


def _ratios(lanes: Lanes) -> tuple[float, ...]:
    """That of the velocity reaches 1 when the autopilot leaves the lane."""
    velocity = max(USUAL_RATIO, lanes.lanes[lanes.selected].strain)
    return (velocity, USUAL_RATIO, USUAL_RATIO, USUAL_RATIO)
