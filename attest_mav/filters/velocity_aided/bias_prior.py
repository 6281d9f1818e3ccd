"""The prior of the accelerometer's bias, as large as the sensor itself shows.

What calibration leaves differs from vehicle to vehicle by a factor of ten, but the axes of one sensor are of one grade.
Their common variance is a random variable with an inverse gamma distribution of shape 1/2, so the prior of the bias is
a Cauchy distribution: narrow where all axes turn out small, and no obstacle where they do not. The variance follows the
estimate (variational Bayes; Bishop, Pattern Recognition and Machine Learning, sections 3.5 and 10.3). Where it changes,
the information of the old prior is taken out of the state and that of the new one is put in.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import dot
from attest_mav.filters.velocity_aided.measurement import CrossCovariance, updated
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import largest_variance, trace, transpose
from attest_mav.record import Record

SPACING_S: Final = 1.0
"""Time between two looks at the variances, s."""
SAME: Final = 0.05
"""A change of a variance by a smaller share is none."""
LARGEST_GROWTH: Final = 2.0
"""Largest factor on a variance in one look."""
LARGEST_SHARE: Final = 0.75
"""The information taken out is at most this share of what the state holds; else the prior stays as it is."""


@mypyc_attr(acyclic=True)
class BiasPrior(Record):
    """The variance in force, and the time since it was looked at."""

    def __init__(self, variance: float, since_s: float) -> None:
        self.variance: Final = variance
        """Of each axis, (m/s^2)^2; 0 where the bias is no state."""
        self.since_s: Final = since_s
        """s."""


def initial_prior(parameters: FlightParameters) -> BiasPrior:
    """The prior at the first start."""
    return BiasPrior(parameters.accel_bias_sigma**2, 0.0)


def follow_prior(
    nav: NavigationState, prior: BiasPrior, dt_s: float, parameters: FlightParameters
) -> tuple[NavigationState, BiasPrior]:
    """State and prior a step later; both stay as they are between two looks."""
    since_s = prior.since_s + dt_s
    if since_s < SPACING_S:
        return nav, BiasPrior(prior.variance, since_s)
    variance = _variance(prior.variance, parameters.accel_bias_sigma, nav)
    if variance != prior.variance:
        nav = _with_information(nav, 1.0 / variance - 1.0 / prior.variance)
    return nav, BiasPrior(variance, 0.0)


def _variance(before: float, sigma: float, nav: NavigationState) -> float:
    """The variance of each axis: the mean square of the three axes and of a fourth that is as expected (``sigma``)."""
    if before <= 0.0:
        return before
    known, bias = nav.covariance.aa, nav.accel_bias
    square = dot(bias, bias) + trace(known)
    variance = min(0.25 * (sigma * sigma + square), LARGEST_GROWTH * before)
    removed = (1.0 / before - 1.0 / variance) * largest_variance(known)
    is_same = abs(variance - before) < SAME * before
    return before if is_same or removed > LARGEST_SHARE else variance


def _with_information(nav: NavigationState, information: float) -> NavigationState:
    """The state with more or less information that each axis of the bias is zero; information: 1 / variance.

    A measurement of zero with the variance 1 / information; a negative one takes the information out.
    """
    for axis in range(3):
        cross_cov = _cross_covariance(nav, axis)
        k = information / (information * cross_cov.state_variance + 1.0)
        nav = nav.corrected(cross_cov, -k * nav.accel_bias[axis], updated(nav.covariance, cross_cov, k))
    return nav


def _cross_covariance(nav: NavigationState, axis: int) -> CrossCovariance:
    """P h of one axis of the bias: the column of P."""
    p = nav.covariance
    t, v, b, s = transpose(p.ta)[axis], transpose(p.va)[axis], transpose(p.ba)[axis], transpose(p.sa)[axis]
    return CrossCovariance(t, v, b, s, p.aa[axis], p.am[axis], p.ad[axis], p.aa[axis][axis])
