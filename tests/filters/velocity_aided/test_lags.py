"""The delay of a low-pass that is only assumed, from the magnetometer's lag, against Gaussians in matrices."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

from attest_mav.filters.velocity_aided.covariance import Covariance
from attest_mav.filters.velocity_aided.lags import low_pass_delay
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import diagonal
from attest_mav.types import Mat3

SETTINGS = FlightParameters(low_pass_hz=20.0, low_pass_delay_sigma=0.02, mag_delay_s=0.055, mag_delay_sigma=0.03)
AT_20_HZ = sqrt(2.0) / (2.0 * np.pi * 20.0)
NONE: Mat3 = diagonal(0.0)
ZERO = (0.0, 0.0, 0.0)


def with_mag_lag(lag_s, sigma_s):
    p = Covariance(*([NONE] * 33), diagonal(sigma_s**2), NONE, NONE)
    return NavigationState((1.0, 0.0, 0.0, 0.0), *([ZERO] * 6), lag_s, 0.09, 0.0, p)


def conditional(lag_s, sigma_s):
    """Mean and sigma of the low-pass's delay, given a measurement of the difference of both delays."""
    prior = np.diag([0.02**2, 0.03**2])
    h = np.array([[-1.0, 1.0]])
    # The filter's own sigma of the lag is that of prior and turns together: the turns alone have this variance.
    total = (h @ prior @ h.T).item()
    noise = 1.0 / (1.0 / sigma_s**2 - 1.0 / total)
    innovation = lag_s - (0.055 - AT_20_HZ)
    measured = innovation * (total + noise) / total  # the filter's lag is the weighted mean of prior and turns
    gain = prior @ h.T / (total + noise)
    mean = np.array([[AT_20_HZ], [0.055]]) + gain * measured
    return mean[0].item(), sqrt((prior - gain @ h @ prior)[0, 0])


@pytest.mark.parametrize(("lag_s", "sigma_s"), [(0.012, 0.003), (0.044, 0.003), (0.05, 0.01), (0.03, 0.03)])
def test_the_delay_is_the_conditional_mean(lag_s, sigma_s):
    found = low_pass_delay(with_mag_lag(lag_s, sigma_s), 0.02, SETTINGS)
    assert (found.delay_s, found.sigma_s) == pytest.approx(conditional(lag_s, sigma_s), abs=1e-9)


def test_before_any_turn_the_assumption_stands():
    prior = sqrt(0.02**2 + 0.03**2)
    found = low_pass_delay(with_mag_lag(0.055 - AT_20_HZ, prior), 0.02, SETTINGS)
    assert (found.delay_s, found.sigma_s) == pytest.approx((AT_20_HZ, 0.02))


def test_no_low_pass_looks_ahead():
    assert low_pass_delay(with_mag_lag(0.2, 0.003), 0.02, SETTINGS).delay_s == 0.0


def test_one_that_is_told_is_certain():
    found = low_pass_delay(with_mag_lag(0.2, 0.003), 0.02, replace(SETTINGS, low_pass_delay_sigma=0.0))
    assert (found.delay_s, found.sigma_s) == (pytest.approx(AT_20_HZ), 0.0)


@pytest.mark.parametrize(("interval_s", "older_s"), [(0.02, 0.0), (0.1, 0.04), (0.25, 0.04), (0.01, -0.005)])
def test_slow_messages_show_an_older_mean(interval_s, older_s):
    """A mean of 10 Hz waits for half an interval until a message shows it first, and never longer than 50 ms."""
    usual = low_pass_delay(with_mag_lag(0.03, 0.003), 0.02, SETTINGS)
    slow = low_pass_delay(with_mag_lag(0.03 + older_s, 0.003), interval_s, SETTINGS)
    assert slow.delay_s == pytest.approx(usual.delay_s)
