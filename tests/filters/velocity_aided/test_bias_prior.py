"""The prior of the accelerometer's bias follows the bias that is found."""

from dataclasses import replace

import numpy as np
import pytest

from attest_mav.filters.velocity_aided.bias_prior import BiasPrior, follow_prior
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters

PARAMETERS = replace(FlightParameters(), accel_bias_sigma=0.09)
ACCEL = slice(3 * ErrorBlock.ACCEL_BIAS, 3 * ErrorBlock.ACCEL_BIAS + 3)


@pytest.fixture(scope="module")
def estimate(plane_log):
    """The estimate after twenty seconds, in which all errors depend on each other."""
    return plane_log.run(last=1000)[-1].navigation.estimate


def with_bias(nav, bias):
    """The estimate with another accelerometer bias, m/s^2."""
    return NavigationState(
        nav.q_nb,
        nav.velocity,
        nav.gyro_bias,
        nav.gyro_scale,
        bias,
        nav.hard_iron,
        nav.mag_lag_s,
        nav.fix_lag_s,
        nav.declination_error,
        nav.covariance,
    )


def matrix(p):
    """The whole covariance, 21 by 21."""
    whole = np.zeros((21, 21))
    blocks = iter(p.blocks())
    for row in range(7):
        for column in range(row, 7):
            whole[3 * row : 3 * row + 3, 3 * column : 3 * column + 3] = next(blocks)
    upper = np.triu(whole)
    return upper + np.triu(whole, 1).T


@pytest.mark.parametrize("bias", [(0.0, 0.0, 0.0), (0.15, -0.1, 0.12)], ids=["narrower", "wider"])
def test_another_prior_is_what_it_would_have_been_from_the_start(estimate, bias):
    """By the information form: the inverse of P gains the difference of both priors, and P^-1 x stays."""
    nav, before = with_bias(estimate, bias), 0.09**2
    p = matrix(nav.covariance)
    expected = 0.25 * (before + float(np.dot(bias, bias)) + float(np.trace(p[ACCEL, ACCEL])))
    after, prior = follow_prior(nav, BiasPrior(before, 1.0), 0.02, PARAMETERS)
    assert prior.variance == pytest.approx(expected)
    information = np.linalg.inv(p)
    gained = information.copy()
    gained[ACCEL, ACCEL] += np.eye(3) * (1.0 / expected - 1.0 / before)
    truth = np.linalg.inv(gained)
    found = matrix(after.covariance)
    scale = np.sqrt(np.outer(np.diag(truth), np.diag(truth)))
    assert (np.abs(found - truth) / scale).max() < 1e-6
    x = np.zeros(21)
    x[ACCEL] = bias
    assert after.accel_bias == pytest.approx(tuple((truth @ information @ x)[ACCEL]), abs=1e-9)


def test_a_prior_as_expected_stays_and_is_looked_at_once_a_second(estimate):
    prior = BiasPrior(0.09**2, 0.5)
    after, kept = follow_prior(estimate, prior, 0.02, PARAMETERS)
    assert after is estimate
    assert (kept.variance, kept.since_s) == (prior.variance, pytest.approx(0.52))


def test_a_bias_that_is_no_state_has_no_prior(estimate):
    after, kept = follow_prior(estimate, BiasPrior(0.0, 1.0), 0.02, replace(PARAMETERS, accel_bias_sigma=0.0))
    assert after is estimate
    assert kept.variance == 0.0


def test_information_that_the_state_does_not_hold_is_not_taken_out(estimate):
    """A bias that has become uncertain again, as that of a sensor which returns, holds nothing of the old prior."""
    nav = with_bias(estimate, (0.3, 0.3, 0.3)).with_added_variance(ErrorBlock.ACCEL_BIAS, (0.04, 0.04, 0.04))
    after, kept = follow_prior(nav, BiasPrior(0.005, 1.0), 0.02, PARAMETERS)
    assert after is nav
    assert kept.variance == 0.005
