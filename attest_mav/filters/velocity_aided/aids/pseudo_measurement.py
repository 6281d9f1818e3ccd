"""Pseudo-measurements: assumptions in the form of a measurement, robust, and without effect on the sensor errors.

An assumption such as "no horizontal acceleration" is wrong for as long as a turn lasts. Its error is not white, and a
Kalman update would explain it by the sensors. The update considers their errors instead of estimating them (the
Schmidt-Kalman filter; Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, chapter 3).
"""

from math import sqrt
from typing import Final

from attest_mav.filters.velocity_aided.covariance import CrossCovariance, Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState, consider_update, cross_covariance_of, update

SPACING_S: Final = 0.1
"""Time between two updates of a fallback aid, s."""
KNEE: Final = 2.0
"""Normalised residual from which the variance grows with the residual."""


def robust_update(nav: NavigationState, measurement: Measurement, variance: float) -> NavigationState:
    """The state after a measurement whose variance is inflated where the residual is large."""
    cross_cov = cross_covariance_of(nav, measurement)
    return update(nav, measurement, cross_cov, inflated_variance(measurement, cross_cov, variance))


def robust_consider_update(nav: NavigationState, measurement: Measurement, variance: float) -> NavigationState:
    """The same for a pseudo-measurement."""
    cross_cov = cross_covariance_of(nav, measurement)
    return consider_update(nav, measurement, cross_cov, inflated_variance(measurement, cross_cov, variance))


def inflated_variance(measurement: Measurement, cross_cov: CrossCovariance, variance: float) -> float:
    """The equivalent variance of paper 2, eq. (16): it grows with the normalised residual from ``KNEE`` on."""
    return variance * max(1.0, abs(measurement.residual) / sqrt(cross_cov.state_variance + variance) / KNEE)
