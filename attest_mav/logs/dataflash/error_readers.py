"""The reader of errors: ERR, in words."""

from math import isfinite
from typing import Final

from attest_mav.logs.dataflash.reader import COMPONENT, SYSTEM, RecordReader
from attest_mav.logs.dataflash.units import Column
from attest_mav.samples import Sample
from attest_mav.vehicle_reports import EstimatorNews, EstimatorNewsSample, TextSample

ESTIMATOR_ERRORS: Final = {
    (16, 2): (EstimatorNews.VARIANCE, "EKF check: bad variance"),
    (17, 1): (EstimatorNews.VARIANCE, "EKF failsafe"),
}
"""Subsystem and code of ERR that concern the estimator (AP_Logger.h, LogErrorSubsystem), with words for people."""

SUBSYSTEMS: Final = {
    1: "main loop",
    2: "radio",
    3: "compass",
    4: "optical flow",
    5: "radio failsafe",
    6: "battery failsafe",
    7: "GPS failsafe",
    8: "ground station failsafe",
    9: "fence failsafe",
    10: "flight mode",
    11: "GPS",
    12: "crash check",
    13: "flip",
    14: "autotune",
    15: "parachute",
    16: "EKF check",
    17: "EKF failsafe",
    18: "barometer",
    19: "processor load",
    20: "ADSB failsafe",
    21: "terrain",
    22: "navigation",
    23: "terrain failsafe",
    24: "EKF primary",
    25: "thrust loss",
    26: "sensor failsafe",
    27: "leak failsafe",
    28: "pilot input",
    29: "vibration failsafe",
    30: "internal error",
    31: "dead reckoning failsafe",
}
"""Subsystems of ERR (AP_Logger.h, LogErrorSubsystem)."""


class ErrorReader(RecordReader):
    """ERR: an error of a subsystem, or its end."""

    def __init__(self) -> None:
        super().__init__([Column("Subsys"), Column("ECode")])

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One EstimatorNewsSample, or a TextSample of another subsystem."""
        if not isfinite(numbers[1] + numbers[2]):
            return []
        subsystem, code = int(numbers[1]), int(numbers[2])
        found = ESTIMATOR_ERRORS.get((subsystem, code))
        if found is not None:
            return [EstimatorNewsSample("ERR", SYSTEM, COMPONENT, t_ns, found[0], found[1])]
        return [TextSample("ERR", SYSTEM, COMPONENT, t_ns, error_text(subsystem, code))]


def error_text(subsystem: int, code: int) -> str:
    """An error in words; code 0 is its end."""
    name = SUBSYSTEMS.get(subsystem, f"subsystem {subsystem}")
    return f"Error: {name}, code {code}" if code else f"Error resolved: {name}"
