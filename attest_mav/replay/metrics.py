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


class ErrorColumns:
    """Tilt and heading errors (rad) of one attitude against the reference; 17 bytes a sample.

    The heading has fewer entries than the tilt if it did not always refer to a north. Each tilt error has a mark that
    says whether its filter was sure of it.
    """

    def __init__(self) -> None:
        self._tilt = array("d")
        self._heading = array("d")
        self._sure = array("b")

    def add(self, tilt: float, heading: float | None, sure: bool = False) -> None:
        """Take the errors of one sample, rad; ``heading`` is None for a heading that refers to no north."""
        self._tilt.append(tilt)
        self._sure.append(sure)
        if heading is not None:
            self._heading.append(heading)

    @property
    def samples(self) -> int:
        """Samples whose tilt was compared."""
        return len(self._tilt)

    @property
    def heading_samples(self) -> int:
        """Samples whose heading was compared."""
        return len(self._heading)

    def tilt(self) -> Spread | None:
        """Figures of the tilt error; None without samples."""
        return spread(self._tilt)

    @property
    def sure_samples(self) -> int:
        """Samples with a tilt that the filter was sure of."""
        return sum(self._sure)

    def sure_tilt(self) -> Spread | None:
        """Figures of the tilt error of the samples that the filter was sure of; None without such samples."""
        return spread([error for error, sure in zip(self._tilt, self._sure, strict=True) if sure])

    def heading(self) -> Spread | None:
        """Figures of the heading error; None without samples."""
        return spread(self._heading)


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
