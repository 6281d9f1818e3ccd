"""Fallback aids: assumptions in the form of a measurement, robust, and most without effect on the sensor errors.

An assumption such as "no horizontal acceleration" is wrong for as long as a turn lasts. Its error is not white, and an
update would explain it by the sensors; so the update considers their errors instead of estimating them (the
Schmidt-Kalman filter; Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed.,
chapter 3).
"""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.robust import inflation
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, fuse
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.record import Record

SPACING_S: Final = 0.1
"""Time between two updates of a fallback aid, s."""
KNEE: Final = 2.0
"""Normalised residual from which the variance grows with the residual."""


@mypyc_attr(acyclic=True)
class Fallback(Record):
    """The state of whichever fallback aid is at work."""

    def __init__(self, since_update_s: float, innovation: Innovation | None) -> None:
        self.since_update_s: Final = since_update_s
        """Time since the last update, s; 0 while no fallback is needed."""
        self.innovation: Final = innovation
        """Of this step's update, None where it had none."""


class FallbackUpdate:
    """Fuses the scalar measurements of one fallback aid, and keeps their record."""

    def __init__(self, nav: NavigationState, variance: float, estimates_sensors: bool) -> None:
        self.nav = nav
        """The state after the measurements so far."""
        self._variance: Final = variance
        self._estimates_sensors: Final = estimates_sensors
        self._fusion = Fusion.USED
        self._observations: Final[list[float]] = []
        self._residuals: Final[list[float]] = []
        self._variances: Final[list[float]] = []

    def fuse(self, measurement: Measurement, observation: float) -> None:
        """Take one more measurement of the aid; observation: the value that is assumed."""
        cross_cov = cross_covariance_of(self.nav, measurement)
        variance = cross_cov.state_variance + self._variance
        factor = inflation(abs(measurement.residual) / sqrt(variance), KNEE)
        if factor > 1.0:
            self._fusion = Fusion.INFLATED
        self._observations.append(observation)
        self._residuals.append(measurement.residual)
        self._variances.append(variance)
        self.nav = fuse(self.nav, measurement, cross_cov, self._variance * factor, self._estimates_sensors)

    def innovation(self, aid: Aid, t_ns: int) -> Innovation:
        """The record of the update."""
        observation, residual = tuple(self._observations), tuple(self._residuals)
        return Innovation(aid, self._fusion, t_ns, observation, residual, tuple(self._variances))
