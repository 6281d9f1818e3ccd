"""A magnetometer that is not calibrated, in place: iron of a quarter of the field."""

from math import radians

import numpy as np
import pytest

from attest_mav.algebra import q_from_euler, q_to_matrix
from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters

from .conftest import DECLINATION, FIELD, FINE_S, Motion, rms

RATE_HZ = 50.0
TURN_BEGINS = round(5.0 * RATE_HZ)
QUARTER = 0.25 * 0.49
"""gauss."""
DIRECTIONS = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (-0.58, 0.58, 0.58))
PRIORS = (0.010, 0.015)
"""gauss. What calibration may leave: with the larger, the estimate takes up more of an iron by itself."""


def spinning():
    """Five seconds of rest, then 30 s of turning about the vertical at 200 deg/s, level to 3 degrees."""
    t = np.arange(0.0, 35.0, FINE_S)
    fade = np.clip(t - 5.0, 0.0, 1.0)
    yaw = 0.4 + radians(200.0) * np.cumsum(fade) * FINE_S
    roll, pitch = 0.05 * fade * np.sin(2.1 * t), 0.05 * fade * np.cos(1.7 * t)
    rolling, pitching, yawing = (np.gradient(one, FINE_S) for one in (roll, pitch, yaw))
    rate = np.stack(
        [
            rolling - yawing * np.sin(pitch),
            pitching * np.cos(roll) + yawing * np.sin(roll) * np.cos(pitch),
            -pitching * np.sin(roll) + yawing * np.cos(roll) * np.cos(pitch),
        ],
        axis=1,
    )
    q = np.array([q_from_euler(*each) for each in zip(roll, pitch, yaw, strict=True)])
    return Motion(q, rate, np.zeros_like(rate), np.zeros_like(rate))


@pytest.fixture(scope="module")
def flown(telemetry):
    """Heading errors and sigmas (degrees) with iron on a motion, and whether the attitude is there yet."""

    def fly(motion, iron, prior=PRIORS[0]):
        flight = telemetry(
            motion, rate_hz=RATE_HZ, integer=False, hard_iron=iron, gyro_bias=(0.004, -0.003, 0.005), gyro_noise=2e-3,
            accel_noise=0.05, accel_bias=(0.03, -0.04, 0.02), mag_noise=2e-3,
        )  # fmt: skip
        flight.inputs = [FilterInputs(declination=DECLINATION) for _ in flight.samples]
        states = flight.run(VelocityAided(FlightParameters(hard_iron=prior)))
        sigma = np.degrees([state.heading_sigma if state.aligned else np.nan for state in states])
        return flight.errors(states)[1], sigma, states

    return fly


@pytest.mark.parametrize("prior", PRIORS)
@pytest.mark.parametrize("direction", DIRECTIONS)
def test_turning_about_all_axes_shows_the_iron(hand, flown, direction, prior):
    heading, sigma, states = flown(hand, tuple(QUARTER * x for x in direction), prior)
    late = TURN_BEGINS + round(10.0 * RATE_HZ)
    assert rms(heading[late:]) < 6.0
    assert np.mean(np.abs(heading[late:]) < 3.0 * sigma[late:]) > 0.99
    found = states[-1].navigation.estimate.hard_iron
    assert found == pytest.approx(tuple(QUARTER * x for x in direction), abs=0.03)


def test_a_level_turn_shows_the_level_iron(flown):
    heading, _, states = flown(spinning(), tuple(QUARTER * x for x in DIRECTIONS[2]))
    found = states[-1].navigation.estimate.hard_iron
    assert found[:2] == pytest.approx(tuple(QUARTER * x for x in DIRECTIONS[2][:2]), abs=0.01)
    assert rms(heading[TURN_BEGINS + round(10.0 * RATE_HZ) :]) < 3.0


def test_iron_that_turns_the_heading_round(hand, flown):
    """Half as large again as the level field and against it: the first heading is the opposite one."""
    first = q_to_matrix(tuple(hand.q[0]))
    level = np.array(first).T @ (FIELD[0], FIELD[1], 0.0)
    heading, sigma, _ = flown(hand, tuple((-1.5 * level).tolist()))
    assert abs(heading[TURN_BEGINS - 50]) > 170.0
    late = TURN_BEGINS + round(10.0 * RATE_HZ)
    assert rms(heading[late:]) < 6.0
    assert np.mean(np.abs(heading[late:]) < 3.0 * sigma[late:]) > 0.99


def test_a_new_alignment_begins_a_field_of_its_own(hand, telemetry):
    """Its heading is another one, and what turning has shown of the iron stays."""
    flight = telemetry(hand, rate_hz=RATE_HZ, integer=False, hard_iron=(QUARTER, 0.0, 0.0), mag_noise=2e-3)
    del flight.samples[1500:1600], flight.truth[1500:1600]
    flight.inputs = [FilterInputs(declination=DECLINATION) for _ in flight.samples]
    states = flight.run(last=1900)
    before = states[1499].navigation.iron
    first = next(state for state in states[1500:] if state.aligned).navigation
    assert before.moments.turned > 1.0
    assert first.iron.moments.turned < 0.1  # rad: of the first reading
    assert first.iron.regression().weight == pytest.approx(before.regression().weight, rel=0.01)
    assert states[-1].navigation.estimate.hard_iron == pytest.approx((QUARTER, 0.0, 0.0), abs=0.01)


def test_sigma_tells_what_a_level_turn_does_not_show(flown):
    """Of the iron along the axis of the turn nothing is seen, and before the first turn nothing at all."""
    for direction in DIRECTIONS[::2]:
        heading, sigma, _ = flown(spinning(), tuple(QUARTER * x for x in direction))
        known = np.isfinite(sigma)
        assert np.mean(np.abs(heading[known]) < 3.0 * sigma[known]) > 0.99
        assert np.nanmax(sigma[TURN_BEGINS - 50 : TURN_BEGINS]) > 10.0


def test_a_calibrated_magnetometer_keeps_its_calibration(hand, flown):
    heading, sigma, states = flown(hand, (0.0, 0.0, 0.0))
    assert rms(heading[TURN_BEGINS:]) < 1.5
    assert not states[-1].navigation.iron.has_replaced
    assert sigma[-1] < 6.0


def test_a_vehicle_with_a_velocity_keeps_its_iron_to_itself(copter_log):
    """In flight the velocity shows the heading, and nothing of the above applies."""
    states = copter_log.run(last=1000)
    assert states[-1].navigation.iron is None
