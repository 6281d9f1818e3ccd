"""The messages that are read besides the inertial ones."""

from typing import Final

from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4

OTHER_MESSAGES: Final = (
    "ATTITUDE",
    "ATTITUDE_QUATERNION",
    "GPS_RAW_INT",
    "VFR_HUD",
    "SYSTEM_TIME",
    "EXTENDED_SYS_STATE",
    "PARAM_VALUE",
    "AUTOPILOT_VERSION",
    "STATUSTEXT",
    "EKF_STATUS_REPORT",
    "ESTIMATOR_STATUS",
    "SYS_STATUS",
    "AHRS2",
    "AHRS3",
)
SELF_REPORTS: Final = {
    MAV_AUTOPILOT_ARDUPILOTMEGA: ("EKF_STATUS_REPORT", "SYS_STATUS", "AHRS2"),
    MAV_AUTOPILOT_PX4: ("ESTIMATOR_STATUS", "SYS_STATUS"),
}
"""The requested messages in which an autopilot tells of itself."""
