"""Log time and the regularity of the inertial samples."""

from array import array
from math import fsum
from typing import Final

from attest_mav.replay.reference_track import CLOCK_BACK_NS

GAP_S: Final = 0.1
"""A pause of this length or less is no gap, at any rate."""
GAP_INTERVALS: Final = 2.5
"""A pause of at most this many median intervals is no gap: at 4 Hz every interval is longer than ``GAP_S``."""


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
        """The time at a stamp near the last inertial sample's, s."""
        return (t_ns - self._base_ns) * 1e-9


class Regularity:
    """Rate and gaps of a stream of samples; 4 bytes a sample."""

    def __init__(self) -> None:
        self.samples = 0
        self._last_ns = -1
        self._intervals_s = array("f")

    def add(self, t_ns: int) -> None:
        """Take the stamp of the next sample. Repeats count as samples, but not as intervals."""
        self.samples += 1
        if 0 <= self._last_ns < t_ns:
            self._intervals_s.append((t_ns - self._last_ns) * 1e-9)
        self._last_ns = t_ns

    def rate_and_gaps(self) -> tuple[float | None, int]:
        """Samples a second outside of gaps (None with fewer than two), and the number of gaps."""
        intervals = sorted(self._intervals_s)
        if not intervals:
            return (None, 0)
        limit = max(GAP_S, GAP_INTERVALS * intervals[len(intervals) // 2])
        usual = [interval for interval in intervals if interval <= limit]
        return (len(usual) / fsum(usual), len(intervals) - len(usual))
