"""Columns of attitude errors, and the figures made of them."""

from array import array
from collections.abc import Sequence
from math import degrees, floor, fsum, radians, sqrt
from typing import Final

from attest_mav.record import Record

P95: Final = 0.95
SURE: Final = radians(1.0)
"""A filter is called sure of its tilt while its tilt sigma is below this, rad."""


class Spread(Record):
    """Figures of one kind of error, degrees."""

    def __init__(self, rms: float, p95: float, max: float) -> None:  # noqa: A002 - a key of the contract
        self.rms: Final = rms
        """Root mean square."""
        self.p95: Final = p95
        """95th percentile of the absolute values."""
        self.max: Final = max
        """Largest absolute value."""


class ErrorColumn:
    """One kind of error, rad; 8 bytes a sample."""

    def __init__(self) -> None:
        self.values: Final = array("d")
        self._spread: Spread | None = None
        self._spread_samples = 0

    def spread(self) -> Spread | None:
        """The figures, made anew where errors have come since; None without samples."""
        if self._spread_samples < len(self.values):
            self._spread_samples = len(self.values)
            self._spread = spread(self.values)
        return self._spread


class ErrorColumns:
    """Tilt and heading errors (rad) of one attitude against the reference; 16 bytes a sample.

    The heading has fewer entries than the tilt if it did not always refer to a north. The places in the tilt column
    are kept at which a filter became sure of its tilt, or stopped to be.
    """

    def __init__(self) -> None:
        self._tilt: Final = ErrorColumn()
        self._heading: Final = ErrorColumn()
        self._turns = array("q")
        """Places in the column of the tilt: it begins unsure, and each of these begins the other kind."""
        self._is_sure = False

    def add(self, tilt: float, heading: float | None, sure: bool = False) -> None:
        """Take the errors of one sample, rad; ``heading`` is None for a heading that refers to no north."""
        if sure != self._is_sure:
            self._is_sure = sure
            self._turns.append(self.samples)
        self._tilt.values.append(tilt)
        if heading is not None:
            self._heading.values.append(heading)

    @property
    def samples(self) -> int:
        """Samples whose tilt was compared."""
        return len(self._tilt.values)

    @property
    def heading_samples(self) -> int:
        """Samples whose heading was compared."""
        return len(self._heading.values)

    def tilt(self) -> Spread | None:
        """Figures of the tilt error; None without samples."""
        return self._tilt.spread()

    @property
    def sure_samples(self) -> int:
        """Samples with a tilt that the filter was sure of."""
        return sum([end - begin for begin, end in self._sure_stretches()])

    def sure_tilt(self) -> Spread | None:
        """Figures of the tilt error of the samples that the filter was sure of; None without such samples."""
        if self.sure_samples == self.samples:
            return self.tilt()
        sure = array("d")
        for begin, end in self._sure_stretches():
            sure += self._tilt.values[begin:end]
        return spread(sure)

    def heading(self) -> Spread | None:
        """Figures of the heading error; None without samples."""
        return self._heading.spread()

    def _sure_stretches(self) -> list[tuple[int, int]]:
        """Begin and end of each stretch of the tilt column in which the filter was sure."""
        ends = [*self._turns[1::2], self.samples]
        return list(zip(self._turns[0::2], ends, strict=False))


def spread(errors: Sequence[float]) -> Spread | None:
    """Figures of a column of errors in rad; None when it is empty."""
    if not errors:
        return None
    ordered = sorted(map(abs, errors))
    rms = sqrt(fsum([error * error for error in ordered]) / len(ordered))
    return Spread(degrees(rms), degrees(percentile(ordered, P95)), degrees(ordered[-1]))


def percentile(ordered: list[float], share: float) -> float:
    """The value below which ``share`` of the ordered values lie, between neighbours by linear interpolation."""
    position = share * (len(ordered) - 1)
    below = floor(position)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (position - below) * (ordered[above] - ordered[below])
