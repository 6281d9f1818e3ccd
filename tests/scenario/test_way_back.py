"""No wrong state of the flight filter is a trap: whatever attitude, bias and velocity it believes in, it comes back."""

from math import degrees, pi, radians
from random import Random

import pytest

from attest_mav.algebra import add, q_exp, q_mul, scale, tilt_between, unit
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.samples import ImuSample, PositionSample, VelocitySample

from .flying import fly

WRONG_S = 20.0
"""When the state is made wrong."""


def wrong(pipeline, rng):
    """The state turned by up to 180 degrees about any axis, with other velocity and bias, and as sure as before."""
    watch = pipeline.lanes["RAW_IMU"]._stepper
    state = watch.state
    nav = state.navigation.estimate
    axis = unit(tuple(rng.gauss(0.0, 1.0) for _ in range(3)))
    turned = NavigationState(
        q_mul(q_exp(scale(axis, 0.5 * rng.uniform(radians(20.0), pi))), nav.q_nb),
        add(nav.velocity, tuple(rng.gauss(0.0, 5.0) for _ in range(3))),
        add(nav.gyro_bias, tuple(radians(rng.gauss(0.0, 1.5)) for _ in range(3))),
        nav.gyro_drift,
        nav.gyro_scale,
        nav.accel_bias,
        nav.hard_iron,
        nav.mag_lag_s,
        nav.fix_lag_s,
        nav.declination_error,
        nav.covariance,
    )
    watch.adopt(watch.configured.with_estimate(state, turned))


def flown(scenario, seed, receiver, field, until_s):
    """A flight whose state is made wrong once. receiver, field: whether they are heard from 15 s on, or ever."""
    done = []

    def heard(sample):
        if not receiver and isinstance(sample, (VelocitySample, PositionSample)) and sample.rx_ns > 15e9:
            return None
        if not field and isinstance(sample, ImuSample):
            return sample.with_readings(sample.gyro, sample.accel, None)
        return sample

    def meddle(pipeline, now_ns):
        if now_ns >= WRONG_S * 1e9 and not done:
            done.append(now_ns)
            wrong(pipeline, Random(seed))

    return fly(until_s, "velocity-aided", scenario=scenario, heard=heard, meddle=meddle)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("field", [True, False])
@pytest.mark.parametrize("scenario", ["hover", "coordinated-turns", "square"])
def test_with_a_receiver_every_wrong_attitude_is_left_in_five_seconds(scenario, field, seed):
    flight = flown(scenario, seed, True, field, WRONG_S + 12.0)
    assert max(flight.errors(WRONG_S, WRONG_S + 1.0))[0] > 10.0, "it was wrong"
    assert flight.worst(WRONG_S + 5.0)[0] < 2.0


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("field", [True, False])
@pytest.mark.parametrize("receiver", [True, False])
def test_at_rest_every_wrong_attitude_is_left_in_six_seconds(receiver, field, seed):
    flight = flown("still", seed, receiver, field, WRONG_S + 12.0)
    assert max(flight.errors(WRONG_S, WRONG_S + 1.0))[0] > 10.0, "it was wrong"
    assert flight.worst(WRONG_S + 6.0)[0] < 2.0


@pytest.mark.parametrize("field", [True, False])
def test_without_a_receiver_in_flight_sigma_tells_that_the_attitude_is_wrong(field):
    """Nothing there can show the right one; the velocity that gravity makes of the wrong one is impossible."""
    flight = flown("hover", 3, False, field, WRONG_S + 25.0)
    late = [one for one in flight.estimates if one.rx_ns * 1e-9 > WRONG_S + 15.0]
    for one in late:
        error = tilt_between(one.q_nb, flight.vehicle.truth(one.t_ns).q_nb)
        assert error < max(3.0 * one.tilt_sigma, radians(2.0))
    published = [one for one in flight.published if one.rx_ns * 1e-9 > WRONG_S + 15.0]
    assert all(degrees(tilt_between(one.q_nb, flight.vehicle.truth(one.t_ns).q_nb)) < 3.0 for one in published)
