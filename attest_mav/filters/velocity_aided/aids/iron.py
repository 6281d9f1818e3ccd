"""Hard iron in place: readings over many attitudes of the body tell it apart from the field.

Without a velocity nothing but the magnetometer shows the heading, so its calibration is not taken for granted. The
field stays where it is while the body turns, and the iron turns with the body; the gyro shows both apart
(``iron_fit``). The heading of these attitudes is the gyro's alone, for the filter's follows the very readings that are
in doubt. Its drift is why the field is another one after a minute.

The regression gives the iron and its covariance; only turning adds to them. The covariance is part of the heading's
sigma, and an iron far beyond what calibration leaves takes the place of the estimated one.
"""

from math import atan2, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import (
    dot,
    heading_between,
    hypotenuse,
    norm,
    q_heading,
    q_to_matrix,
    scale,
    square,
    sub,
    wrap_pi,
)
from attest_mav.filters.velocity_aided.aids.field import LevelledField
from attest_mav.filters.velocity_aided.aids.iron_fit import (
    EQUATIONS,
    FIELD_NOISE,
    LONGEST_S,
    MEMORY_TURN,
    TURNING_RATE,
    FittedIron,
    Regression,
    VectorMoments,
    fitted,
    no_moments,
)
from attest_mav.filters.velocity_aided.aids.magnetometer import Magnetometer
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock, decoupled
from attest_mav.filters.velocity_aided.lags import mag_lag_variance, nominal_mag_lag_s
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import mat_mul, mat_scale, quadratic
from attest_mav.record import Record
from attest_mav.types import Quat, Vec3

GYRO_HEADING_S: Final = 60.0
"""s. For so long the gyro alone keeps a heading to some degrees."""
LOST_HEADING: Final = 0.35
"""rad. 1-sigma of a heading that a wrong iron has made."""
FAR_HEADING: Final = 1.0
"""rad. A reading that differs by more turns the heading too little, and beyond half a turn the wrong way."""
STRENGTH_MARGIN: Final = 0.07
"""Share of the field. A first reading that fits better by less proves nothing: two strengths, each with its noise."""
LEAST_LEVEL: Final = 0.05
"""Share of the field. A smaller horizontal part shows no heading."""


@mypyc_attr(acyclic=True)
class IronFit(Record):
    """The regression of the readings while the body turned, and what follows from it."""

    def __init__(
        self,
        first: Vec3,
        moments: VectorMoments,
        earlier: Regression,
        age_s: float,
        corrected: float,
        heading_sigma: float,
        calibrated: Vec3,
        supposed: Vec3,
        has_replaced: bool,
    ) -> None:
        self.first: Final = first
        """The first reading, gauss; its length is the unit of the regression."""
        self.moments: Final = moments
        """Of the readings in the present field."""
        self.earlier: Final = earlier
        """Of those in fields before."""
        self.age_s: Final = age_s
        """Time for which the present field is that, s."""
        self.corrected: Final = corrected
        """What the magnetometer has turned the heading by in that time, rad."""
        self.heading_sigma: Final = heading_sigma
        """1-sigma of the heading for an iron that turning has not shown, rad."""
        self.calibrated: Final = calibrated
        """The estimated iron before the first turn, gauss."""
        self.supposed: Final = supposed
        """The iron that the fit is held against, gauss: the calibrated one, then the fit that took its place. The
        estimate itself is none to test: it follows the heading alone, and takes up a part of any iron."""
        self.has_replaced: Final = has_replaced
        """Whether the fitted iron has taken the place of the estimated one before."""

    @property
    def strength(self) -> float:
        """Of the first reading, gauss."""
        return norm(self.first)

    def regression(self) -> Regression:
        """Of all readings."""
        return self.moments.regression().and_of(self.earlier)

    def is_news(self, found: FittedIron, parameters: FlightParameters) -> bool:
        """Whether the fitted iron is to take the place of the estimated one."""
        share = 1.0 / self.strength
        supposed, calibrated = scale(self.supposed, share), scale(self.calibrated, share)
        return found.is_news(self.regression(), supposed, calibrated, parameters.hard_iron * share)

    def with_reading(self, levelled: LevelledField, since_s: float) -> "IronFit":
        """The fit with one more reading, which came so long after the one before."""
        if self.age_s + since_s > GYRO_HEADING_S:
            return self.in_another_field().with_reading(levelled, 0.0)
        turn = levelled.rate * min(since_s, LONGEST_S) if levelled.rate > TURNING_RATE else 0.0
        turned = self.moments.turned + self.earlier.weight / EQUATIONS
        keep = 1.0 - min(1.0, turn / MEMORY_TURN) if turned > MEMORY_TURN - turn else 1.0
        by_gyro = mat_mul(q_to_matrix(q_heading(-self.corrected)), levelled.attitude)
        u = scale(levelled.reading, 1.0 / self.strength)
        return self._with(
            self.moments.with_reading(u, by_gyro, turn, keep),
            self.earlier.faded(keep),
            self.age_s + since_s,
            self.corrected,
        )

    def in_another_field(self) -> "IronFit":
        """The fit whose next readings are in a field of their own: the heading is another one, or has drifted."""
        return self._with(no_moments(), self.regression(), 0.0, 0.0)

    def corrected_by(self, heading: float) -> "IronFit":
        """The fit after the heading has been turned by this angle, rad, and not by the gyro."""
        return self._with(self.moments, self.earlier, self.age_s, self.corrected + heading)

    def _with(self, moments: VectorMoments, earlier: Regression, age_s: float, corrected: float) -> "IronFit":
        return IronFit(
            self.first,
            moments,
            earlier,
            age_s,
            corrected,
            self.heading_sigma,
            self.calibrated,
            self.supposed,
            self.has_replaced,
        )

    def judged(self, heading_sigma: float, taken: Vec3 | None) -> "IronFit":
        """The same regression with what follows from it. taken: the iron that takes the estimated one's place."""
        return IronFit(
            self.first,
            self.moments,
            self.earlier,
            self.age_s,
            self.corrected,
            heading_sigma,
            self.calibrated,
            self.supposed if taken is None else taken,
            self.has_replaced or taken is not None,
        )


def new_fit(field: Vec3, calibrated: Vec3) -> IronFit:
    """The fit before the first turn. field: a reading; calibrated: the estimated iron; gauss."""
    moments = no_moments()
    return IronFit(field, moments, moments.regression(), 0.0, 0.0, 0.0, calibrated, calibrated, has_replaced=False)


def watch_iron(
    nav: NavigationState,
    magnetometer: Magnetometer,
    fit: IronFit | None,
    levelled: LevelledField,
    q_before: Quat,
    since_s: float,
    parameters: FlightParameters,
) -> tuple[NavigationState, Magnetometer, IronFit]:
    """State, magnetometer's memory and fit after a reading in place that was fused; q_before: attitude without it."""
    if fit is None or parameters.hard_iron <= 0.0:
        fit = new_fit(levelled.reading, nav.hard_iron)
    if parameters.hard_iron <= 0.0:
        return nav, magnetometer, fit
    after = fit.with_reading(levelled, since_s).corrected_by(heading_between(nav.q_nb, q_before))
    found = fitted(after.regression(), FIELD_NOISE)
    iron = scale(found.iron, after.strength)
    heading_sigma = _heading_sigma(after, found, sub(iron, nav.hard_iron), levelled)
    if not (levelled.rate > TURNING_RATE and after.is_news(found, parameters)):
        return nav, magnetometer, after.judged(heading_sigma, None)
    changed = _with_iron(nav, after, found, levelled.north, parameters)
    judged = after.corrected_by(heading_between(changed.q_nb, nav.q_nb)).judged(heading_sigma, iron)
    return changed, magnetometer.without_field(parameters), judged


def _heading_sigma(fit: IronFit, found: FittedIron, off: Vec3, levelled: LevelledField) -> float:
    """The sigma of the heading for the iron's covariance, and for iron that is seen but not taken yet (off), rad."""
    measurement = levelled.measurement
    level = max(hypotenuse(levelled.direction[0], levelled.direction[1]), LEAST_LEVEL)
    unseen = square(fit.strength) * quadratic(found.covariance, measurement.m)
    return sqrt(unseen + square(dot(measurement.m, off))) / level


def _with_iron(
    nav: NavigationState, fit: IronFit, found: FittedIron, north: float, parameters: FlightParameters
) -> NavigationState:
    """The state with the fitted iron.

    A heading that was made with another one is lost, and the field without it shows the new one; so is the lag.
    """
    covariance = mat_scale(found.covariance, square(fit.strength))
    apart = decoupled(nav.covariance, ErrorBlock.HARD_IRON, covariance)
    nav = nav.with_sensor_errors(nav.accel_bias, scale(found.iron, fit.strength), apart)
    field = fit.moments.field(found.iron)
    off = wrap_pi(north - atan2(field[1], field[0]) - fit.corrected)
    is_lost = not fit.has_replaced and _was_there(fit, found)
    if is_lost:
        nav = nav.with_mag_lag(nominal_mag_lag_s(parameters), mag_lag_variance(parameters))
    if not is_lost and abs(off) < FAR_HEADING:
        return nav
    return nav.turned(off).with_added_variance(ErrorBlock.ATTITUDE, (0.0, 0.0, square(LOST_HEADING)))


def _was_there(fit: IronFit, found: FittedIron) -> bool:
    """Whether the iron may have been in the first reading, of which the heading was made.

    It came later where that reading has the strength of the field as it is, and not with the iron taken off.
    """
    u, strength = scale(fit.first, 1.0 / fit.strength), norm(fit.moments.field(found.iron))
    return abs(norm(sub(u, found.iron)) - strength) < abs(1.0 - strength) + STRENGTH_MARGIN
