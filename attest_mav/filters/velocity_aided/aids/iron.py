"""Hard iron in place: the strength of the field over all directions of the body tells it apart from the field.

Without a velocity nothing but the magnetometer shows the heading, so its calibration is not taken for granted. The
readings u of a body that turns lie on a sphere about the iron b, whatever its attitude: with |u - b| constant,

    (|u|^2 - 1) / 2 = u . b + c,   u and b as shares of the first strength,

which is linear in b and c. A weighted regression with a prior gives b and its covariance; only turning adds to it. The
covariance is part of the heading's sigma, and an iron far beyond what calibration leaves takes the place of the
estimated one. (Ellipsoid fitting: Gebre-Egziabher et al., Journal of Aerospace Engineering 19, 2006.)
"""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, dot, hypotenuse, mat_vec, norm, scale, square, sub
from attest_mav.filters.velocity_aided.aids.field import LevelledField
from attest_mav.filters.velocity_aided.aids.magnetometer import Magnetometer
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock, decoupled
from attest_mav.filters.velocity_aided.lags import mag_lag_variance, nominal_mag_lag_s
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import add_diagonal, inverse, mat_scale, minus_outer, quadratic
from attest_mav.record import Record
from attest_mav.types import Mat3, Vec3

PRIOR: Final = 0.1
"""Share of the field. 1-sigma of the iron on each axis of a magnetometer that may not be calibrated."""
FIELD_NOISE: Final = 0.05
"""Share of the field. 1-sigma of its strength from place to place indoors, at least."""
ALIKE_TURN: Final = 0.5
"""rad. Readings within this turn are alike and count once."""
MEMORY_TURN: Final = 30.0
"""rad. After turning so far readings are forgotten."""
LONGEST_S: Final = 0.5
"""s. Of a longer time between two readings nobody knows how far the body turned in it."""
TURNING_RATE: Final = 0.1
"""rad/s: a body that turns more slowly shows nothing new of the iron."""
SIGNIFICANT: Final = 16.0
"""1. Squared distance, in sigmas, from the estimated iron beyond which the fitted one takes its place."""
LARGEST_UNEXPLAINED: Final = 0.25
"""1. Of the strength's variance an iron leaves no more. One that comes or goes leaves most of it, and so does a magnet
that the body moves about."""
LOST_HEADING: Final = 0.35
"""rad. 1-sigma of a heading that a wrong iron has made."""
STRENGTH_MARGIN: Final = 0.07
"""Share of the field. A first reading that fits better by less proves nothing: two strengths, each with its noise."""
LEAST_LEVEL: Final = 0.05
"""Share of the field. A smaller horizontal part shows no heading."""


@mypyc_attr(acyclic=True)
class IronFit(Record):
    """Weighted moments of the readings while the body turned, and what follows from them."""

    def __init__(
        self,
        first: Vec3,
        turned: float,
        sum_u: Vec3,
        sum_y: float,
        sum_uu: Mat3,
        sum_uy: Vec3,
        sum_yy: float,
        heading_sigma: float,
        has_replaced: bool,
    ) -> None:
        self.first: Final = first
        """The first reading, gauss; its length is the unit of u."""
        self.turned: Final = turned
        """Weight of all readings: the angle through which the body turned, rad."""
        self.sum_u: Final = sum_u
        """Integral of u."""
        self.sum_y: Final = sum_y
        """The same of y = (|u|^2 - 1) / 2."""
        self.sum_uu: Final = sum_uu
        """The same of u u^T."""
        self.sum_uy: Final = sum_uy
        """The same of u y."""
        self.sum_yy: Final = sum_yy
        """The same of y^2."""
        self.heading_sigma: Final = heading_sigma
        """1-sigma of the heading for an iron that turning has not shown, rad."""
        self.has_replaced: Final = has_replaced
        """Whether the fitted iron has taken the place of the estimated one before."""

    @property
    def strength(self) -> float:
        """Of the first reading, gauss."""
        return norm(self.first)

    def judged(self, heading_sigma: float, has_replaced: bool) -> "IronFit":
        """The same moments with what follows from them."""
        return IronFit(
            self.first,
            self.turned,
            self.sum_u,
            self.sum_y,
            self.sum_uu,
            self.sum_uy,
            self.sum_yy,
            heading_sigma,
            has_replaced,
        )

    def with_reading(self, field: Vec3, turn: float) -> "IronFit":
        """The moments with one more reading of a body that turns, gauss; turn: since the one before, rad."""
        u = scale(field, 1.0 / self.strength)
        y = 0.5 * (dot(u, u) - 1.0)
        keep = 1.0 - min(1.0, turn / MEMORY_TURN) if self.turned > MEMORY_TURN - turn else 1.0
        return IronFit(
            self.first,
            keep * self.turned + turn,
            add(scale(self.sum_u, keep), scale(u, turn)),
            keep * self.sum_y + turn * y,
            minus_outer(mat_scale(self.sum_uu, keep), scale(u, -turn), u),
            add(scale(self.sum_uy, keep), scale(u, turn * y)),
            keep * self.sum_yy + turn * y * y,
            self.heading_sigma,
            self.has_replaced,
        )


@mypyc_attr(acyclic=True)
class FittedIron(Record):
    """The iron by a fit, as shares of its unit."""

    def __init__(self, iron: Vec3, covariance: Mat3, strength: float, unexplained: float) -> None:
        self.iron: Final = iron
        self.covariance: Final = covariance
        self.strength: Final = strength
        """Of the field without the iron."""
        self.unexplained: Final = unexplained
        """The variance of the strength that it leaves, as a share of that which the iron so far leaves."""


def new_fit(field: Vec3) -> IronFit:
    """The fit before the first turn. field: a reading, gauss."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    return IronFit(field, 0.0, zero, 0.0, (zero, zero, zero), zero, 0.0, 0.0, has_replaced=False)


def fitted(fit: IronFit, so_far: Vec3) -> FittedIron:
    """The iron by the fit, beside the one so far (a share of its unit).

    It is fitted twice, for the noise is what the first iron leaves.
    """
    weight = max(fit.turned, 1e-9)
    mean_u, mean_y = scale(fit.sum_u, 1.0 / weight), fit.sum_y / weight
    scatter = minus_outer(fit.sum_uu, mean_u, fit.sum_u)
    slope = sub(fit.sum_uy, scale(fit.sum_u, mean_y))
    spread = fit.sum_yy - fit.sum_y * mean_y
    first = mat_vec(_covariance(scatter, square(FIELD_NOISE)), scale(slope, 1.0 / (square(FIELD_NOISE) * ALIKE_TURN)))
    left = _left(spread, slope, scatter, first)
    variance = max(square(FIELD_NOISE), left / weight)
    covariance = _covariance(scatter, variance)
    iron = mat_vec(covariance, scale(slope, 1.0 / (variance * ALIKE_TURN)))
    # c = (F^2 - 1 - |b|^2) / 2, with the strength F.
    strength_square = 1.0 + dot(iron, iron) + 2.0 * (mean_y - dot(mean_u, iron))
    left_so_far = _left(spread, slope, scatter, so_far)
    unexplained = left / left_so_far if left_so_far > 0.0 else 1.0
    return FittedIron(iron, covariance, sqrt(max(strength_square, 0.0)), unexplained)


def _left(spread: float, slope: Vec3, scatter: Mat3, iron: Vec3) -> float:
    """Sum of the squares of y that an iron leaves, of the spread of y."""
    return spread - 2.0 * dot(iron, slope) + quadratic(scatter, iron)


def _covariance(scatter: Mat3, variance: float) -> Mat3:
    """Of the iron by a regression with the prior, for readings whose y has this variance."""
    return inverse(add_diagonal(mat_scale(scatter, 1.0 / (variance * ALIKE_TURN)), 1.0 / square(PRIOR)))


def watch_iron(
    nav: NavigationState,
    magnetometer: Magnetometer,
    fit: IronFit | None,
    field: Vec3,
    levelled: LevelledField,
    since_s: float,
    parameters: FlightParameters,
) -> tuple[NavigationState, Magnetometer, IronFit]:
    """State, magnetometer's memory and fit after a reading in place (``field``, gauss)."""
    if parameters.hard_iron <= 0.0:
        return nav, magnetometer, new_fit(field)
    before = new_fit(field) if fit is None else fit
    turn = levelled.rate * min(since_s, LONGEST_S)
    after = before.with_reading(field, turn) if levelled.rate > TURNING_RATE else before
    found = fitted(after, scale(nav.hard_iron, 1.0 / after.strength))
    off = sub(scale(found.iron, after.strength), nav.hard_iron)
    known = add_diagonal(mat_scale(found.covariance, square(after.strength)), square(parameters.hard_iron))
    is_far = levelled.rate > TURNING_RATE and quadratic(inverse(known), off) > SIGNIFICANT
    is_news = is_far and found.unexplained < LARGEST_UNEXPLAINED
    judged = after.judged(_heading_sigma(after, found, off, levelled), before.has_replaced or is_news)
    if not is_news:
        return nav, magnetometer, judged
    return _with_iron(nav, before, found, parameters), magnetometer.without_field(parameters), judged


def _heading_sigma(fit: IronFit, found: FittedIron, off: Vec3, levelled: LevelledField) -> float:
    """The sigma of the heading for the iron's covariance, and for iron that is seen but not taken yet (off), rad."""
    measurement = levelled.measurement
    level = max(hypotenuse(levelled.direction[0], levelled.direction[1]), LEAST_LEVEL)
    unseen = square(fit.strength) * quadratic(found.covariance, measurement.m)
    return sqrt(unseen + square(dot(measurement.m, off))) / level


def _with_iron(nav: NavigationState, fit: IronFit, found: FittedIron, parameters: FlightParameters) -> NavigationState:
    """The state with the fitted iron. A heading and a lag that were made with another one are uncertain."""
    covariance = mat_scale(found.covariance, square(fit.strength))
    apart = decoupled(nav.covariance, ErrorBlock.HARD_IRON, covariance)
    nav = nav.with_sensor_errors(nav.accel_bias, scale(found.iron, fit.strength), apart)
    if fit.has_replaced or not _was_there(fit, found):
        return nav
    nav = nav.with_mag_lag(nominal_mag_lag_s(parameters), mag_lag_variance(parameters))
    return nav.with_added_variance(ErrorBlock.ATTITUDE, (0.0, 0.0, square(LOST_HEADING)))


def _was_there(fit: IronFit, found: FittedIron) -> bool:
    """Whether the iron may have been in the first reading, of which the heading was made.

    It came later where that reading has the strength of the field as it is, and not with the iron taken off.
    """
    u = scale(fit.first, 1.0 / fit.strength)
    return abs(norm(sub(u, found.iron)) - found.strength) < abs(1.0 - found.strength) + STRENGTH_MARGIN
