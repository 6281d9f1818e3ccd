"""The part of a tilt error that stays the same in the body: the kind that a trim between two bodies makes."""

from array import array
from math import asin, degrees, hypot
from typing import Final

from attest_mav.algebra import down_in_body, median
from attest_mav.types import Quat

SMALLEST_DEG: Final = 0.7
"""A smaller offset is an error of sensors."""
LARGEST_SPREAD: Final = 0.4
"""An offset is steady if half of the errors are no further from it than this share of it."""


class SteadyTilt:
    """Collects differences between two directions of gravity in the body; 8 bytes a sample."""

    def __init__(self) -> None:
        self._forward = array("f")
        self._right = array("f")

    def add(self, q_nb: Quat, reference: Quat) -> None:
        """Take an attitude and the reference at its time."""
        ours, theirs = down_in_body(q_nb), down_in_body(reference)
        self._forward.append(ours[0] - theirs[0])
        self._right.append(ours[1] - theirs[1])

    def offset_deg(self) -> float | None:
        """Size of the offset, degrees; None if there is none that is steady."""
        if not self._forward:
            return None
        forward, right = median(self._forward), median(self._right)
        size = hypot(forward, right)
        offset_deg = degrees(asin(min(size, 1.0)))
        if offset_deg < SMALLEST_DEG:
            return None
        apart = [hypot(x - forward, y - right) for x, y in zip(self._forward, self._right, strict=True)]
        return offset_deg if median(apart) <= LARGEST_SPREAD * size else None
