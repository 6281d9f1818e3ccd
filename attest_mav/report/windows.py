"""Sums of readings over windows of fixed length: the mean, the spread, the total."""

from collections.abc import Sequence
from math import floor, sqrt
from typing import Final


class Window:
    """The readings of one window. Each reading is a vector."""

    def __init__(self, index: int, middle_s: float, first: Sequence[float]) -> None:
        self.index: Final = index
        self.middle_s: Final = middle_s
        """Log time, s."""
        self._count = 0
        self._origin: Final = tuple(first)  # sums of differences from it keep their digits
        self._sums = [0.0] * len(first)
        self._squares = [0.0] * len(first)

    def add(self, reading: Sequence[float]) -> None:
        """Take one reading."""
        self._count += 1
        for axis, (value, origin) in enumerate(zip(reading, self._origin, strict=True)):
            self._sums[axis] += value - origin
            self._squares[axis] += (value - origin) ** 2

    @property
    def spread(self) -> float:
        """Root of the sum of the variances of all axes."""
        n = self._count
        parts = zip(self._sums, self._squares, strict=True)
        return sqrt(max(0.0, sum(square / n - (total / n) ** 2 for total, square in parts)))

    @property
    def mean(self) -> float:
        """Mean of the first axis."""
        return self._origin[0] + self._sums[0] / self._count

    @property
    def total(self) -> float:
        """Sum of the first axis."""
        return self._origin[0] * self._count + self._sums[0]


class Windows:
    """Cuts the readings of one source into windows. length_s: of each, s."""

    def __init__(self, length_s: float) -> None:
        self._length_s: Final = length_s
        self._open: Window | None = None

    def add(self, t_s: float, reading: Sequence[float]) -> Window | None:
        """Take the next reading; the window that it ended, if it did."""
        index = floor(t_s / self._length_s)
        window = self._open
        if window is not None and window.index == index:
            window.add(reading)
            return None
        self._open = Window(index, (index + 0.5) * self._length_s, reading)
        self._open.add(reading)
        return window

    def finish(self) -> Window | None:
        """The window that is still open."""
        ended, self._open = self._open, None
        return ended
