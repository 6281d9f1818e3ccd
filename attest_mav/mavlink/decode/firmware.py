"""What an autopilot says of its firmware: its version, and the estimator that makes the attitude at present."""

import re
from typing import Final

from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample
from attest_mav.types import Version
from attest_mav.vehicle_reports import EstimatorSample, FirmwareSample
from attest_mav.vehicle_settings import Estimator

BANNER: Final = re.compile(
    r"(?:Ardu(?:Copter|Plane|Rover|Sub)|APM:\w+|Rover|Blimp|AntennaTracker) V(\d+)\.(\d+)(?:\.(\d+))?"
)
"""The first words of ArduPilot: "ArduCopter V4.1.1 (0a1b2c3d)"."""

ESTIMATOR_TEXTS: Final = {
    "AHRS: DCM active": Estimator.DCM,
    "AHRS: EKF2 active": Estimator.EKF2,
    "AHRS: EKF3 active": Estimator.EKF3,
    "AHRS: SIM active": Estimator.SIMULATOR,
    "AHRS: External active": Estimator.EXTERNAL,
}
"""ArduPilot's words when it goes over to another estimator."""


class AutopilotVersionReader(Reader):
    """AUTOPILOT_VERSION: the version of the firmware; a zero is none."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("AUTOPILOT_VERSION")
        self._fields: Final = dialect.layout(self.name).pick("flight_sw_version")

    def read(self, frame: Frame) -> list[Sample]:
        """One FirmwareSample. The lowest of the four bytes is the kind of release."""
        (number,) = self._fields.unpack(frame.payload)
        if number == 0:
            return []
        version = (number >> 24, (number >> 16) & 0xFF, (number >> 8) & 0xFF)
        return [FirmwareSample(self.name, frame.system, frame.component, frame.rx_ns, version)]


class StatusTextReader(Reader):
    """STATUSTEXT of the two kinds above; all others give nothing."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("STATUSTEXT")
        self._fields: Final = dialect.layout(self.name).pick("text")

    def read(self, frame: Frame) -> list[Sample]:
        """A FirmwareSample or an EstimatorSample."""
        (raw,) = self._fields.unpack(frame.payload)
        text = raw.split(b"\0", 1)[0].decode("ascii", "replace")
        estimator = ESTIMATOR_TEXTS.get(text.strip())
        if estimator is not None:
            return [EstimatorSample(self.name, frame.system, frame.component, frame.rx_ns, estimator)]
        version = banner_version(text)
        if version is None:
            return []
        return [FirmwareSample(self.name, frame.system, frame.component, frame.rx_ns, version)]


def banner_version(text: str) -> Version | None:
    """The version that ArduPilot's first words name, None for other words."""
    found = BANNER.match(text)
    if found is None:
        return None
    major, minor, patch = found.groups()
    return (int(major), int(minor), int(patch or 0))
