"""The heading's own step: a turn about the vertical, by which the magnetometer cannot touch the tilt.

Like the gradient step it goes at a fixed rate, however large the error: half of the readings decide, as with a median,
and a strong disturbance moves the heading no faster than a weak one.
"""

from math import atan2, nan, sqrt
from typing import Final

from attest_mav.algebra import clamp, norm, q_heading, q_mul, rotate
from attest_mav.plausible import MIN_HORIZONTAL_FIELD
from attest_mav.types import Quat, Vec3

SETTLING_S: Final = 1.0
"""An error smaller than the step of so long is approached with this time constant: a fixed rate would chatter."""


def heading_error(q: Quat, mag: Vec3) -> float:
    """Heading of q minus that of the field, rad in [-pi, pi]; NaN where the field shows none."""
    north, east, _ = rotate(q, mag)
    if not sqrt(north * north + east * east) > MIN_HORIZONTAL_FIELD * norm(mag):
        return nan
    return atan2(east, north)


def heading_corrected(q: Quat, error: float, rate: float, dt_s: float) -> Quat:
    """q turned about the vertical so as to lessen the error (rad), at most at ``rate`` (rad/s)."""
    return q_mul(q_heading(-dt_s * clamp(error / SETTLING_S, -rate, rate)), q)
