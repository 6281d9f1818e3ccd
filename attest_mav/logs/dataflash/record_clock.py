"""The time of a log's records.

Firmware before 3.1 writes the time with the receiver's record alone, some five times a second. The inertial records
between then pace the clock: the first pass measures their mean interval, and in the second the clock goes on by it
with each of them, a little quicker or slower so that it follows the receiver's time. It never goes back by that.
"""

from math import isfinite
from typing import Final

LATEST_NS: Final = 9.0e18
"""A later time since boot (286 years) is none; this also keeps nanoseconds within 64 bits."""
CLOCK_BACK_NS: Final = 1_000_000_000
"""A time further back than this is a restarted clock; one less far back is out of order."""
LONGEST_PACED_NS: Final = 2_000_000_000
"""A longer time between two records with a time tells nothing of the interval of those between."""
FOLLOWED: Final = 0.25
"""Share of the clock's error that is made up for until the next time."""
LARGEST_SHARE: Final = 0.5
"""The interval is changed by no more than this share."""


class RecordClock:
    """The time of the newest record, which records without a time get, ns. pace_ns: goes on by it at each tick."""

    def __init__(self, pace_ns: float = 0.0) -> None:
        self.now_ns = 0
        self.span_ns = 0
        """Time from the first record to the newest one. A restart of the clock adds none."""
        self._pace_ns: Final = pace_ns
        self._step_ns = pace_ns
        self._latest_ns = -1
        self._ticks = 0
        self._paced_ticks = 0
        self._paced_ns = 0

    def at(self, t_ns: float) -> int:
        """The time of a record with this one, or with none (NaN)."""
        if not (isfinite(t_ns) and 0.0 <= t_ns < LATEST_NS):
            return self.now_ns
        told_ns = int(t_ns)
        self._follow(told_ns)
        if self._pace_ns <= 0.0 or abs(told_ns - self.now_ns) > CLOCK_BACK_NS:
            self.now_ns = told_ns
        return told_ns

    def tick(self) -> None:
        """An inertial record without a time has come."""
        self._ticks += 1
        self.now_ns += int(self._step_ns)

    def mean_pace_ns(self) -> float:
        """The mean interval between two ticks, ns; 0 if there is none."""
        return self._paced_ns / self._paced_ticks if self._paced_ticks else 0.0

    def _follow(self, told_ns: int) -> None:
        ahead_ns = told_ns - self._latest_ns
        if self._latest_ns >= 0 and ahead_ns > 0:
            self.span_ns += ahead_ns
            if self._ticks and ahead_ns < LONGEST_PACED_NS:
                self._paced_ns += ahead_ns
                self._paced_ticks += self._ticks
                self._change_step(told_ns)
        if ahead_ns > 0 or ahead_ns < -CLOCK_BACK_NS:
            self._latest_ns = told_ns
            self._ticks = 0

    def _change_step(self, told_ns: int) -> None:
        """The step that makes up for a part of the error until the next time, if that comes after as many ticks."""
        error_ns = told_ns - self.now_ns
        most_ns = LARGEST_SHARE * self._pace_ns
        self._step_ns = self._pace_ns + min(max(FOLLOWED * error_ns / self._ticks, -most_ns), most_ns)
