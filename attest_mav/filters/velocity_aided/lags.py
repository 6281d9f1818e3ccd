"""The delays of inertial readings, magnetometer and fixes: what is assumed, and what turns show.

Everything is compared with the low-passed inertial readings. Turns show to some milliseconds how much older the
magnetometer is, and acceleration how much older the fixes are:

    lag of the magnetometer = its delay - L,    lag of the fixes = their delay - L,    L: delay of the low-pass

L itself does not show. Where its corner is only assumed, L follows from the magnetometer's lag as far as that sensor's
own delay is known: both are independent with known sigmas, so L has the conditional mean and variance of a Gaussian.
The delay of fixes depends on the receiver's driver and is known too badly to tell L. (Maybeck, Stochastic Models,
Estimation, and Control, vol. 1, section 3.10.)
"""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import square
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.record import Record
from attest_mav.types import Mat3, VelocityOrigin

MEAN_INTERVAL_S: Final = 0.1
"""ArduPilot makes a new mean of the magnetometer's readings this often, s."""
USUAL_INTERVAL_S: Final = 0.02
"""The interval of inertial messages for which ``mag_delay_s`` holds, s."""


@mypyc_attr(acyclic=True, free_list_len=1)
class LowPassDelay(Record):
    """The group delay of the autopilot's low-pass, s, and its sigma."""

    def __init__(self, delay_s: float, sigma_s: float) -> None:
        self.delay_s: Final = delay_s
        self.sigma_s: Final = sigma_s


def low_pass_delay_s(parameters: FlightParameters) -> float:
    """Group delay of a second-order Butterworth low-pass with the known or assumed corner, s: sqrt(2) / (2 pi f)."""
    return 0.2250790790392765 / parameters.low_pass_hz if parameters.low_pass_hz > 0.0 else 0.0


def nominal_mag_lag_s(parameters: FlightParameters) -> float:
    """Lag of the magnetometer before it is estimated, s."""
    return parameters.mag_delay_s - low_pass_delay_s(parameters)


def nominal_fix_lag_s(origin: VelocityOrigin, parameters: FlightParameters) -> float:
    """Lag of fixes of this origin before it is estimated, s."""
    delay_s = parameters.fix_delay_s if origin == VelocityOrigin.RECEIVER else parameters.own_delay_s
    return delay_s - low_pass_delay_s(parameters)


def fix_lag_variance(origin: VelocityOrigin, parameters: FlightParameters) -> float:
    """Variance of that lag, s^2."""
    sigma_s = parameters.fix_delay_sigma if origin == VelocityOrigin.RECEIVER else parameters.own_delay_sigma
    return square(sigma_s) + square(parameters.low_pass_delay_sigma)


def mag_lag_variance(parameters: FlightParameters) -> float:
    """Variance of the magnetometer's lag before it is estimated, s^2."""
    return square(parameters.mag_delay_sigma) + square(parameters.low_pass_delay_sigma)


def first_lag_covariance(declination_sigma: float, parameters: FlightParameters) -> Mat3:
    """Covariance of both lags and of the declination error at the start, taken for independent."""
    fix = fix_lag_variance(VelocityOrigin.RECEIVER, parameters)
    return (mag_lag_variance(parameters), 0.0, 0.0), (0.0, fix, 0.0), (0.0, 0.0, declination_sigma**2)


def low_pass_delay(nav: NavigationState, interval_s: float, parameters: FlightParameters) -> LowPassDelay:
    """The low-pass's delay by the magnetometer's lag as it is estimated. interval_s: of the inertial messages."""
    return low_pass_delay_by(nav.mag_lag_s, nav.covariance.dd[0][0], interval_s, parameters)


def low_pass_delay_by(
    mag_lag_s: float, lag_variance: float, interval_s: float, parameters: FlightParameters
) -> LowPassDelay:
    """The same for a lag of the magnetometer (s) with this variance.

    A mean is as old as half the interval when a message first shows it, beyond its age when it is new.
    """
    assumed_s, common = low_pass_delay_s(parameters), square(parameters.low_pass_delay_sigma)
    if common == 0.0:
        return LowPassDelay(assumed_s, 0.0)
    older_s = 0.5 * (min(interval_s, MEAN_INTERVAL_S) - USUAL_INTERVAL_S)
    share = common / (common + square(parameters.mag_delay_sigma))
    lead_s = nominal_mag_lag_s(parameters) + older_s - mag_lag_s
    variance = (1.0 - share) * common + share * share * lag_variance
    return LowPassDelay(max(assumed_s + share * lead_s, 0.0), sqrt(variance))
