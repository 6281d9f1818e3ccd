"""Log time, and the regularity and motion of the inertial samples."""

from array import array
from math import fsum
from typing import Final

from attest_mav.algebra import norm, sub
from attest_mav.estimation.timebase import WRAP_NS
from attest_mav.replay.reference_track import CLOCK_BACK_NS
from attest_mav.types import Vec3

GAP_S: Final = 0.1
"""A pause of this length or less is no gap, at any rate."""
GAP_INTERVALS: Final = 2.5
"""A pause of at most this many median intervals is no gap: at 4 Hz every interval is longer than ``GAP_S``."""
STILL_RATE: Final = 0.1
"""rad/s: a gyro that reads less is still, its bias included."""
STILL_SHARE: Final = 0.99
"""A vehicle stands if its gyro is still in this share of the samples."""
UNSEEN_TURN: Final = 0.14
"""rad (8 deg): change of the rates from one sample to the next times the time between them; an eighth of it, 1 deg, is
the turn that the rates at the ends do not show."""
UNSEEN_SHARE: Final = 0.05
"""Share of samples with more from which on a flight is undersampled."""
LONGEST_STEP_S: Final = 3.0
"""A longer step is a gap, and tells nothing of the sampling."""


class LogTime:
    """Seconds since the first inertial sample on the sensor's clock. A restart of that clock adds no time."""

    def __init__(self) -> None:
        self._base_ns = 0
        self._last_ns = -1

    def advance(self, t_ns: int) -> float:
        """The time at the next inertial sample, s."""
        if self._last_ns < 0:
            self._base_ns = t_ns
        elif t_ns < self._last_ns - CLOCK_BACK_NS:
            self._base_ns -= self._last_ns - t_ns
        elif t_ns < self._last_ns:
            return self.at(t_ns)
        self._last_ns = t_ns
        return self.at(t_ns)

    def at(self, t_ns: int) -> float:
        """The time at a stamp near the last inertial sample's, s; of two clocks one may wrap and the other not."""
        ahead_ns = (t_ns - self._last_ns + WRAP_NS // 2) % WRAP_NS - WRAP_NS // 2
        return (self._last_ns + ahead_ns - self._base_ns) * 1e-9


class Regularity:
    """Rate and gaps of a stream of samples; 4 bytes a sample."""

    def __init__(self) -> None:
        self.samples = 0
        self._last_ns = -1
        self._intervals_s: Final = array("f")
        self._figures: tuple[float | None, int] = (None, 0)
        self._figures_of = 0

    def add(self, t_ns: int) -> None:
        """Take the stamp of the next sample. Repeats count as samples, but not as intervals."""
        self.samples += 1
        if 0 <= self._last_ns < t_ns:
            self._intervals_s.append((t_ns - self._last_ns) * 1e-9)
        self._last_ns = t_ns

    def rate_and_gaps(self) -> tuple[float | None, int]:
        """Samples a second outside of gaps (None with fewer than two), and the number of gaps."""
        if self._figures_of < len(self._intervals_s):
            self._figures_of = len(self._intervals_s)
            self._figures = _rate_and_gaps(sorted(self._intervals_s))
        return self._figures


def _rate_and_gaps(intervals_s: list[float]) -> tuple[float | None, int]:
    """The same for these intervals, in order of size."""
    limit = max(GAP_S, GAP_INTERVALS * intervals_s[len(intervals_s) // 2])
    usual = [interval for interval in intervals_s if interval <= limit]
    return (len(usual) / fsum(usual), len(intervals_s) - len(usual))


class Motion:
    """Whether the vehicle turned, and whether it did so between the samples."""

    def __init__(self) -> None:
        self._samples = 0
        self._still = 0
        self._unseen = 0
        self._last_ns = -1
        self._rates: Vec3 = (0.0, 0.0, 0.0)

    def add(self, t_ns: int, gyro: Vec3) -> None:
        """Take the next sample. gyro: rad/s."""
        self._samples += 1
        if norm(gyro) < STILL_RATE:
            self._still += 1
        dt_s = (t_ns - self._last_ns) * 1e-9
        if self._last_ns >= 0 and 0.0 < dt_s < LONGEST_STEP_S and norm(sub(gyro, self._rates)) * dt_s > UNSEEN_TURN:
            self._unseen += 1
        self._last_ns = t_ns
        self._rates = gyro

    @property
    def stands(self) -> bool:
        """True if the vehicle stood through nearly all of the samples."""
        return self._still >= STILL_SHARE * self._samples

    @property
    def is_undersampled(self) -> bool:
        """True if the rates changed much from one sample to the next through a part of the flight."""
        return self._unseen > UNSEEN_SHARE * self._samples
