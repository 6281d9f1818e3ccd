"""What an autopilot says of its firmware and its estimator in texts: version, estimator in use, lanes, failures."""

import re
from typing import Final

from attest_mav.mavlink.constants import (
    MAV_TYPE_ANTENNA_TRACKER,
    MAV_TYPE_FIXED_WING,
    MAV_TYPE_GENERIC,
    MAV_TYPE_GROUND_ROVER,
    MAV_TYPE_QUADROTOR,
)
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample
from attest_mav.types import Version
from attest_mav.vehicle_reports import EstimatorNews, EstimatorNewsSample, EstimatorSample, FirmwareSample, TextSample
from attest_mav.vehicle_settings import Estimator

BANNER: Final = re.compile(
    r"(Ardu(?:Copter|Plane|Rover|Sub)|APM:\w+|APMrover2|Rover|Blimp|AntennaTracker) V(\d+)\.(\d+)(?:\.(\d+))?"
)
"""The first words of ArduPilot: "ArduCopter V4.1.1 (0a1b2c3d)"."""

TYPES: Final = (
    ("copter", MAV_TYPE_QUADROTOR),
    ("plane", MAV_TYPE_FIXED_WING),
    ("rover", MAV_TYPE_GROUND_ROVER),
    ("tracker", MAV_TYPE_ANTENNA_TRACKER),
)
"""Parts of these words, with a MAV_TYPE that moves as the vehicle does."""

ESTIMATOR_TEXTS: Final = {
    "AHRS: DCM active": Estimator.DCM,
    "AHRS: EKF2 active": Estimator.EKF2,
    "AHRS: EKF3 active": Estimator.EKF3,
    "AHRS: SIM active": Estimator.SIMULATOR,
    "AHRS: External active": Estimator.EXTERNAL,
}
"""ArduPilot's words when it goes over to another estimator."""


NEWS: Final = (
    (re.compile(r"EKF\d? ?lane switch \d|EKF primary changed|AHRS: DCM active"), EstimatorNews.LANE_SWITCH),
    (re.compile(r"EKF\d? ?variance|EKF Failsafe"), EstimatorNews.VARIANCE),
    (re.compile(r"EKF\d? IMU\d? ?(?:has )?stopped aiding"), EstimatorNews.AIDING_LOST),
    (re.compile(r"EKF\d? IMU\d (?:emergency yaw reset|ground mag anomaly)"), EstimatorNews.RESET),
    (re.compile(r"(?:accel|gyro|mag)\w* ?#\d+ fail", re.IGNORECASE), EstimatorNews.SENSOR_FAILED),
)
"""The beginnings of texts about the estimator. The last row is PX4's, "Gyro #0 fail:  STALE!"; the others ArduPilot's,
"EKF3 lane switch 1", "EKF primary changed:1", "EKF variance", "EKF3 IMU0 stopped aiding"."""


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
    """STATUSTEXT."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("STATUSTEXT")
        self._fields: Final = dialect.layout(self.name).pick("text")

    def read(self, frame: Frame) -> list[Sample]:
        """The samples of ``text_samples``."""
        (raw,) = self._fields.unpack(frame.payload)
        text = raw.split(b"\0", 1)[0].decode("ascii", "replace").strip()
        return text_samples(self.name, frame.system, frame.component, frame.rx_ns, text)


def text_samples(source: str, system: int, component: int, rx_ns: int, text: str) -> list[Sample]:
    """A text about estimator or firmware as such; all others, but empty ones, as a TextSample for people."""
    samples: list[Sample] = []
    estimator = ESTIMATOR_TEXTS.get(text)
    if estimator is not None:
        samples.append(EstimatorSample(source, system, component, rx_ns, estimator))
    news = news_of(text)
    if news is not None:
        samples.append(EstimatorNewsSample(source, system, component, rx_ns, news, text))
    version = banner_version(text)
    if version is not None:
        samples.append(FirmwareSample(source, system, component, rx_ns, version))
    if text and news is None and version is None:
        samples.append(TextSample(source, system, component, rx_ns, text))
    return samples


def news_of(text: str) -> EstimatorNews | None:
    """What the text tells of the estimator, None for other texts."""
    return next((news for pattern, news in NEWS if pattern.match(text)), None)


def banner_version(text: str) -> Version | None:
    """The version that ArduPilot's first words name, None for other words."""
    found = BANNER.match(text)
    if found is None:
        return None
    _, major, minor, patch = found.groups()
    return (int(major), int(minor), int(patch or 0))


def banner_type(text: str) -> int | None:
    """A MAV_TYPE that moves as the vehicle of ArduPilot's first words, GENERIC for others; None for other words."""
    found = BANNER.match(text)
    if found is None:
        return None
    name = found[1].lower()
    return next((kind for part, kind in TYPES if part in name), MAV_TYPE_GENERIC)
