"""The uses of DataFlash records in a recorded flight."""

from typing import Final

from attest_mav.estimation.body_frames import CORE_QUATERNIONS, CORES
from attest_mav.logs.dataflash.streams import SENSORS
from attest_mav.logs.source import MessageRoles

DATAFLASH_ROLES: Final = MessageRoles(
    inertial=SENSORS["IMU"],
    truth=("SIM",),
    reference=("SIM", "ATT"),
    named_reference=("SIM", "ATT", *CORE_QUATERNIONS, *CORES, "AHR2", "DCM"),
    autopilot=("ATT",),
    untimed=(),
    other_sensors={name: tuple([other for other in SENSORS["IMU"] if other != name]) for name in SENSORS["IMU"]},
)
"""A simulator's truth precedes the autopilot's attitude."""
