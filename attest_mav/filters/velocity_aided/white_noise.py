"""White noise of a sensor in flight, by how its second differences d follow each other.

White noise of variance s^2 gives, on each axis, E[d_k d_k-1] = -4 s^2 and E[d_k d_k-2] = s^2. Motion that the samples
show well makes the first product positive, and vibration up to three eighths of the samples' rate gives one of them the
other sign: the smaller of the two estimates of s^2 is taken. Vibration above counts as noise. (Autocovariance of a
moving average: Box, Jenkins, Reinsel, Time Series Analysis, section 3.3.)
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import dot
from attest_mav.record import Record
from attest_mav.types import Vec3

MEMORY_S: Final = 15.0
"""s. Time constant of the mean products."""
MEMORY_SAMPLES: Final = 100.0
"""1. The time constant is at least so many samples long: fewer say little of a mean product."""
AXES: Final = 3.0


@mypyc_attr(acyclic=True)
class WhiteNoise(Record):
    """Mean products of the second differences of late."""

    def __init__(
        self, newest: Vec3, earlier: Vec3, by_one: float, by_two: float, memory_s: float, changing_s: float
    ) -> None:
        self.newest: Final = newest
        """The last second difference, in the sensor's unit."""
        self.earlier: Final = earlier
        """The one before."""
        self.by_one: Final = by_one
        """Estimate of the variance by neighbours, -E[d_k . d_k-1] / 12, unit^2."""
        self.by_two: Final = by_two
        """Estimate of the variance by the next but one, E[d_k . d_k-2] / 3, unit^2."""
        self.memory_s: Final = memory_s
        self.changing_s: Final = changing_s
        """Time in which the readings have changed, s: a sensor at rest in a simulator shows no noise at all."""
        """Time over which these are means, s."""

    @property
    def variance(self) -> float:
        """Variance of the white noise of each axis, unit^2; 0 where motion hides it."""
        return max(0.0, min(self.by_one, self.by_two))


def no_white_noise() -> WhiteNoise:
    """Before the first second difference."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    return WhiteNoise(zero, zero, 0.0, 0.0, 0.0, 0.0)


def observed(before: WhiteNoise, difference: Vec3, dt_s: float) -> WhiteNoise:
    """The estimate after one second difference more, of readings that are ``dt_s`` apart."""
    memory_s = min(before.memory_s + dt_s, max(MEMORY_S, MEMORY_SAMPLES * dt_s))
    weight = dt_s / memory_s
    by_one = dot(difference, before.newest) / (-4.0 * AXES)
    by_two = dot(difference, before.earlier) / AXES
    return WhiteNoise(
        difference,
        before.newest,
        before.by_one + weight * (by_one - before.by_one),
        before.by_two + weight * (by_two - before.by_two),
        memory_s,
        before.changing_s + (dt_s if dot(difference, difference) > 0.0 else 0.0),
    )
