"""A series in constant memory: the smallest and the largest value of each bucket of time.

The buckets begin narrower than any interval of samples, so a short series is kept whole. Whenever there are too many,
their width doubles and neighbours join: no peak is ever lost.
"""

from math import floor, isfinite
from typing import Final

MOST_BUCKETS: Final = 2000
"""Buckets of one series; each gives two points at most."""
FINEST_S: Final = 0.001
"""Width of the first buckets, s."""


class Bucket:
    """The extremes of one stretch of time."""

    __slots__ = ("high", "high_s", "index", "low", "low_s")

    def __init__(self, index: int, t_s: float, value: float) -> None:
        self.index = index
        self.low = self.high = value
        self.low_s = self.high_s = t_s

    def add(self, t_s: float, value: float) -> None:
        """Take one more value."""
        if value < self.low:
            self.low, self.low_s = value, t_s
        if value > self.high:
            self.high, self.high_s = value, t_s

    def join(self, other: "Bucket") -> None:
        """Take over the extremes of a later bucket."""
        self.add(other.low_s, other.low)
        self.add(other.high_s, other.high)

    @property
    def points(self) -> list[tuple[float, float]]:
        """The extremes in order of time; one point where they are one."""
        low, high = (self.low_s, self.low), (self.high_s, self.high)
        if low == high:
            return [low]
        return [low, high] if self.low_s <= self.high_s else [high, low]


class Envelope:
    """One series. most: buckets at most."""

    def __init__(self, most: int = MOST_BUCKETS) -> None:
        self._most: Final = most
        self._width_s = FINEST_S
        self._buckets: list[Bucket] = []

    def add(self, t_s: float, value: float) -> None:
        """Take the next value. One that is not finite, or from before the newest bucket, is left out."""
        if not (isfinite(value) and isfinite(t_s)):
            return
        index = floor(t_s / self._width_s)
        if not self._buckets or index > self._buckets[-1].index:
            self._buckets.append(Bucket(index, t_s, value))
            while len(self._buckets) > self._most:
                self._widen()
        elif index == self._buckets[-1].index:
            self._buckets[-1].add(t_s, value)

    @property
    def points(self) -> list[tuple[float, float]]:
        """Times (s) and values, in order of time."""
        return [point for bucket in self._buckets for point in bucket.points]

    def _widen(self) -> None:
        """Double the width of the buckets."""
        self._width_s *= 2.0
        joined: list[Bucket] = []
        for bucket in self._buckets:
            bucket.index //= 2
            if joined and joined[-1].index == bucket.index:
                joined[-1].join(bucket)
            else:
                joined.append(bucket)
        self._buckets = joined
