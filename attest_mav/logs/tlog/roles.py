"""The uses of MAVLink messages in a recorded flight."""

from typing import Final

from attest_mav.logs.source import MessageRoles
from attest_mav.mavlink.component.imu_choice import preferred_messages
from attest_mav.mavlink.constants import INERTIAL_MESSAGES, OTHER_SENSORS
from attest_mav.mavlink.decode.units import unit_row

TLOG_ROLES: Final = MessageRoles(
    inertial=INERTIAL_MESSAGES,
    truth=("SIM_STATE", "SIMSTATE"),
    reference=("SIM_STATE", "SIMSTATE", "ATTITUDE_QUATERNION", "ATTITUDE"),
    named_reference=("SIM_STATE", "SIMSTATE", "ATTITUDE_QUATERNION", "ATTITUDE", "AHRS2"),
    autopilot=("ATTITUDE", "ATTITUDE_QUATERNION"),
    untimed=("SIM_STATE", "SIMSTATE", "AHRS2"),
    other_sensors=OTHER_SENSORS,
)
"""A simulator's truth precedes the autopilot's attitude. ATTITUDE and ATTITUDE_QUATERNION carry the same attitude."""

AIDING: Final = ("HEARTBEAT", "VFR_HUD", "GPS_RAW_INT", "SYSTEM_TIME")
"""Messages that aid a filter or give the time of one that does."""

FRAME: Final = ("PARAM_VALUE", "STATUSTEXT")
"""Messages that tell a change of the rotation between the autopilot's attitude and the inertial messages."""

SELF_REPORTS: Final = ("EKF_STATUS_REPORT", "ESTIMATOR_STATUS", "SYS_STATUS", "AHRS2", "AHRS3")
"""Messages in which the autopilot tells of itself; STATUSTEXT is one too."""

GROUND_SYSTEM: Final = 255
"""System id of ground stations."""


def inertial_by_preference(autopilot: int | None) -> tuple[str, ...]:
    """All inertial messages, best first; those whose units are unknown on this MAV_AUTOPILOT last."""
    known = TLOG_ROLES.inertial
    if autopilot is None:
        return known
    preferred = preferred_messages(autopilot)
    ordered = [*preferred, *(name for name in known if name not in preferred)]
    return tuple(sorted(ordered, key=lambda name: unit_row(name, autopilot, None) is None))
