"""Motion that stays in place, without any velocity: carried and turned by hand."""

import copy

import numpy as np
import pytest

from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.control import AidingMode

from .conftest import DECLINATION, Motion, rms


@pytest.fixture(scope="module")
def worn(hand, telemetry):
    """The hand's motion with the errors of real sensors, at 100 Hz, and no velocity."""
    flight = telemetry(
        hand, rate_hz=100.0, integer=False, gyro_bias=(0.004, -0.003, 0.005), gyro_noise=2e-3, accel_noise=0.05,
        accel_bias=(0.03, -0.04, 0.02), mag_noise=2e-3,
    )  # fmt: skip
    flight.inputs = [FilterInputs(declination=DECLINATION) for _ in flight.samples]
    return flight


def test_swinging_does_not_tilt_it(worn):
    states = worn.run()
    tilt, heading = worn.errors(states)
    assert states[3000].navigation.mode == AidingMode.ZERO_MEAN_VELOCITY
    assert states[-1].navigation.mode == AidingMode.STATIONARY
    assert rms(tilt[600:]) < 0.6
    assert rms(heading[600:]) < 1.5
    sigma = np.degrees([s.tilt_sigma for s in states])
    assert np.mean(tilt[600:] < 3.0 * sigma[600:]) > 0.99


def test_a_vehicle_under_way_is_not_held_in_place(worn):
    sent = copy.copy(worn)
    sent.inputs = [FilterInputs(declination=DECLINATION, zero_mean_velocity=False) for _ in worn.samples]
    states = sent.run(last=3000)
    assert states[-1].navigation.mode == AidingMode.GRAVITY


def test_a_gyro_that_shows_too_much_is_found_out(hand, telemetry):
    """Half a per cent too much about the body's z."""
    scaled = Motion(hand.q, hand.rate * (1.0, 1.0, 1.005), hand.velocity, hand.acceleration)
    flight = telemetry(scaled, rate_hz=100.0, integer=False, gyro_noise=5e-4, accel_noise=0.02, mag_noise=1e-3)
    flight.inputs = [FilterInputs(declination=DECLINATION) for _ in flight.samples]
    scale = flight.run()[-1].navigation.estimate.gyro_scale
    assert scale[2] == pytest.approx(0.005, abs=0.002)
    assert scale[:2] == pytest.approx((0.0, 0.0), abs=0.002)
