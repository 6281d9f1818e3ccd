"""Linear regression of the hard iron of a magnetometer, from readings over many attitudes of its body.

The readings u, shares of the first strength, are the field f of the place and the iron b of the body. With attitudes C
they are linear in both:

    C u = f + C b.

Of W = sum w, S_C = sum w C, S_u = sum w u and S_e = sum w C u, with the turns w as weights, f is eliminated:

    (W I - S_C^T S_C / W) b = S_u - S_C^T S_e / W.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, dot, mat_vec, scale, square, sub
from attest_mav.matrices import add_diagonal, inverse, mat_add, mat_mul, mat_scale, mat_t_vec, quadratic, transpose
from attest_mav.record import Record
from attest_mav.types import Mat3, Vec3

PRIOR: Final = 0.1
"""Share of the field. 1-sigma of the iron on each axis of a magnetometer that may not be calibrated."""
FIELD_NOISE: Final = 0.03
"""Share of the field. 1-sigma of each component from place to place indoors, at least; 0.015 to 0.03 were seen."""
ALIKE_TURN: Final = 0.5
"""rad. Readings within this turn are alike and count once."""
MEMORY_TURN: Final = 30.0
"""rad. After turning so far readings are forgotten."""
LONGEST_S: Final = 0.5
"""s. Of a longer time between two readings nobody knows how far the body turned in it."""
TURNING_RATE: Final = 0.1
"""rad/s: a body that turns more slowly shows nothing new of the iron."""
EQUATIONS: Final = 3.0
"""1. Of one reading with its attitude."""
SIGNIFICANT: Final = 16.0
"""1. Squared distance, in sigmas, from the supposed iron beyond which the fitted one takes the estimate's place."""
LARGEST_UNEXPLAINED: Final = 0.25
"""1. Of the readings' variance an iron leaves no more. One that comes or goes leaves most of it, and so does a magnet
that the body moves about."""


@mypyc_attr(acyclic=True)
class Regression(Record):
    """Normal equations of the iron."""

    def __init__(self, weight: float, scatter: Mat3, slope: Vec3, spread: float) -> None:
        self.weight: Final = weight
        """Sum of the weights of all equations, rad: of each reading its turn, for each of its equations."""
        self.scatter: Final = scatter
        """Matrix of the normal equations."""
        self.slope: Final = slope
        """Their right side."""
        self.spread: Final = spread
        """Weighted sum of the squares that no iron leaves."""

    def and_of(self, other: "Regression") -> "Regression":
        """That of both, whose fields are independent."""
        return Regression(
            self.weight + other.weight,
            mat_add(self.scatter, other.scatter),
            add(self.slope, other.slope),
            self.spread + other.spread,
        )

    def faded(self, keep: float) -> "Regression":
        """The same with less weight."""
        return Regression(
            keep * self.weight, mat_scale(self.scatter, keep), scale(self.slope, keep), keep * self.spread
        )

    def left(self, iron: Vec3) -> float:
        """Weighted sum of the squares that this iron leaves."""
        return self.spread - 2.0 * dot(iron, self.slope) + quadratic(self.scatter, iron)


@mypyc_attr(acyclic=True)
class VectorMoments(Record):
    """Weighted moments of readings with their attitudes."""

    def __init__(self, turned: float, sum_u: Vec3, sum_e: Vec3, sum_c: Mat3, sum_square: float) -> None:
        self.turned: Final = turned
        """Weight of all readings: the angle through which the body turned, rad."""
        self.sum_u: Final = sum_u
        """Integral of u."""
        self.sum_e: Final = sum_e
        """The same of C u."""
        self.sum_c: Final = sum_c
        """The same of C."""
        self.sum_square: Final = sum_square
        """The same of |u|^2."""

    def with_reading(self, u: Vec3, attitude: Mat3, turn: float, keep: float) -> "VectorMoments":
        """The moments with one more reading; keep: share that the earlier ones keep."""
        return VectorMoments(
            keep * self.turned + turn,
            add(scale(self.sum_u, keep), scale(u, turn)),
            add(scale(self.sum_e, keep), scale(mat_vec(attitude, u), turn)),
            mat_add(mat_scale(self.sum_c, keep), mat_scale(attitude, turn)),
            keep * self.sum_square + turn * dot(u, u),
        )

    def regression(self) -> Regression:
        """The normal equations of the iron, without the field."""
        weight = max(self.turned, 1e-9)
        sum_c_t = transpose(self.sum_c)
        scatter = add_diagonal(mat_scale(mat_mul(sum_c_t, self.sum_c), -1.0 / weight), self.turned)
        slope = sub(self.sum_u, scale(mat_t_vec(self.sum_c, self.sum_e), 1.0 / weight))
        spread = self.sum_square - dot(self.sum_e, self.sum_e) / weight
        return Regression(EQUATIONS * self.turned, scatter, slope, spread)

    def field(self, iron: Vec3) -> Vec3:
        """The field beside this iron."""
        return scale(sub(self.sum_e, mat_vec(self.sum_c, iron)), 1.0 / max(self.turned, 1e-9))


@mypyc_attr(acyclic=True)
class FittedIron(Record):
    """The iron by a regression, as shares of its unit."""

    def __init__(self, iron: Vec3, covariance: Mat3) -> None:
        self.iron: Final = iron
        self.covariance: Final = covariance

    def is_news(self, regression: Regression, supposed: Vec3, calibrated: Vec3, prior: float) -> bool:
        """Whether it is far beyond the supposed iron, and explains the readings of its regression.

        calibrated: the iron that was supposed first, of this 1-sigma an axis.
        """
        known = add_diagonal(self.covariance, square(prior))
        is_far = quadratic(inverse(known), sub(self.iron, supposed)) > SIGNIFICANT
        left = regression.left(self.iron)
        is_usual = left < square(FIELD_NOISE) * regression.weight
        left_before = max(regression.left(supposed), regression.left(calibrated) if is_usual else 0.0)
        return is_far and left < LARGEST_UNEXPLAINED * left_before


def no_moments() -> VectorMoments:
    """Before the first reading."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    return VectorMoments(0.0, zero, zero, (zero, zero, zero), 0.0)


def fitted(regression: Regression, least_noise: float) -> FittedIron:
    """The iron by the normal equations. It is fitted twice, for the noise is what the first iron leaves, at least this.

    least_noise: 1-sigma of a reading, share of the field.
    """
    least = square(least_noise)
    first = mat_vec(_covariance(regression, least), scale(regression.slope, 1.0 / (least * ALIKE_TURN)))
    variance = max(least, regression.left(first) / max(regression.weight, 1e-9))
    covariance = _covariance(regression, variance)
    return FittedIron(mat_vec(covariance, scale(regression.slope, 1.0 / (variance * ALIKE_TURN))), covariance)


def _covariance(regression: Regression, variance: float) -> Mat3:
    """Of the iron with the prior, for readings of this variance."""
    return inverse(add_diagonal(mat_scale(regression.scatter, 1.0 / (variance * ALIKE_TURN)), 1.0 / square(PRIOR)))
