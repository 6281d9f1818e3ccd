"""The reference attitude as a function of time, over the last few seconds of a log.

Between two samples the reference is bridged as far as its motion allows it. The path is the integral of the rates known
between them, and the turn from the one to the other closes it: the reference's own rates first, and where these change
too much the gyro readings between the samples as well. How much a rate may have moved aside unseen shows in its change
from one reading to the next and in the turn that the integral misses; that bounds the error, and not a length of time.
"""

from bisect import bisect_left, bisect_right
from enum import IntEnum
from math import radians
from typing import Final

from attest_mav.replay.bridge import Knot, RatePath, RateReading, error_bound, interpolate
from attest_mav.types import Quat, Vec3

MAX_ERROR: Final = radians(1.0)
"""The reference is not bridged where it may err by more, rad."""
STAMP_NS: Final = 1_000_000
"""References have stamps of whole milliseconds, cut off: a stamp stands for any instant of its millisecond."""
MEMORY_NS: Final = 4_000_000_000
"""Older samples are forgotten. No attitude to be compared is further away from the newest sample."""
CLOCK_BACK_NS: Final = 1_000_000_000
"""A stamp further back than this is a restarted clock; one less far back is out of order."""


class Lack(IntEnum):
    """The reason why there is no attitude of the reference at a time."""

    OUTSIDE = 0
    """The time is before the first sample or after the last one."""
    UNEVEN = 1
    """The reference moves too unevenly between its samples there to be bridged."""


class ReferenceTrack:
    """Takes the samples of the reference in order, and gives its attitude at times near the newest one."""

    def __init__(self) -> None:
        self._knots: list[Knot] = []
        self._times: list[int] = []
        self._rates: list[RateReading] = []
        self._rate_times: list[int] = []
        self._path: RatePath | None = None

    def add(self, t_ns: int, q_nb: Quat, rates: Vec3 | None) -> None:
        """Take the next sample. One out of order is dropped; after a restart of the clock all earlier ones are."""
        if self._times and t_ns <= self._times[-1]:
            if t_ns >= self._times[-1] - CLOCK_BACK_NS:
                return
            self._forget(len(self._times))
        self._times.append(t_ns)
        self._knots.append(Knot(t_ns, q_nb, rates))
        if t_ns - self._times[0] > 2 * MEMORY_NS:
            self._forget(bisect_right(self._times, t_ns - MEMORY_NS))

    def add_rates(self, t_ns: int, rates: Vec3) -> None:
        """Take the next reading of the gyro, rad/s; out of order and after a restart of the clock as in ``add``."""
        times = self._rate_times
        if times and t_ns <= times[-1]:
            if t_ns >= times[-1] - CLOCK_BACK_NS:
                return
            self._forget_rates(len(times))
        times.append(t_ns)
        self._rates.append(RateReading(t_ns, rates))
        if t_ns - times[0] > 2 * MEMORY_NS:
            self._forget_rates(bisect_right(times, t_ns - MEMORY_NS))

    def _forget_rates(self, count: int) -> None:
        del self._rate_times[:count]
        del self._rates[:count]

    def _forget(self, count: int) -> None:
        """Drop the oldest samples: seldom and many at once, so that the cost per sample is small."""
        del self._times[:count]
        del self._knots[:count]

    def reaches(self, t_ns: int) -> bool:
        """True if further samples cannot change ``at`` for this time."""
        return bool(self._times) and t_ns < self._times[-1] + STAMP_NS

    def at(self, t_ns: int) -> Knot | None:
        """The reference then, or the sample that holds then; None where ``lack`` has a reason."""
        above = self._count_until(t_ns)
        if above == 0:
            return None
        before = self._knots[above - 1]
        if t_ns < before.t_ns + STAMP_NS:
            return before
        if above == len(self._times):
            return None
        after = self._knots[above]
        if error_bound(before, after, t_ns) <= MAX_ERROR:
            return Knot(t_ns, interpolate(before, after, t_ns), None)
        path = self._path_between(before, after)
        return Knot(t_ns, path.at(t_ns), None) if path is not None and path.error_bound(t_ns) <= MAX_ERROR else None

    def _count_until(self, t_ns: int) -> int:
        """Number of samples until then: nearly all of them, as the track has mostly just passed that time."""
        times = self._times
        count = len(times)
        while count > 0 and times[count - 1] > t_ns:
            count -= 1
        return count

    def lack(self, t_ns: int) -> Lack:
        """The reason why ``at`` gives nothing."""
        inside = bool(self._times) and self._times[0] <= t_ns < self._times[-1]
        return Lack.UNEVEN if inside else Lack.OUTSIDE

    def _path_between(self, before: Knot, after: Knot) -> RatePath | None:
        """The path by the gyro between two samples; None without a reading inside."""
        path = self._path
        if path is not None and path.a is before and path.b is after:
            return path
        begin = bisect_right(self._rate_times, before.t_ns)
        inside = self._rates[begin : bisect_left(self._rate_times, after.t_ns)]
        self._path = RatePath(before, after, inside) if inside else None
        return self._path
