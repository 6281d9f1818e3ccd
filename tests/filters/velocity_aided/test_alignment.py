"""Alignment: attitudes from pairs of directions, on the ground, in a turn, and what it waits for."""

from math import degrees, radians

import numpy as np
import pytest

from attest_mav.algebra import q_conj, q_from_euler, q_mul, rotate_back, tilt_between, unit
from attest_mav.filters.velocity_aided.alignment.wahba import VectorPair, solve_wahba, triad
from attest_mav.types import North

from .conftest import coordinated

Q = q_from_euler(0.7, -0.3, 2.1)


def pair(world, sigma, error=(0.0, 0.0, 0.0)):
    world = unit(world)
    return VectorPair(unit(tuple(b + e for b, e in zip(rotate_back(Q, world), error, strict=True))), world, sigma**2)


def test_triad_recovers_an_attitude():
    found = triad(pair((0.0, 1.0, -9.0), 1.0), pair((0.4, 0.0, 0.9), 1.0))
    assert degrees(2.0 * np.linalg.norm(q_mul(found, q_conj(Q))[1:])) < 1e-6


def test_the_fit_weighs_its_pairs():
    """A direction that is wrong by 2 degrees but uncertain by 20 hardly moves one known to a tenth of a degree."""
    pairs = [
        pair((0.0, 1.0, -9.0), radians(0.1)),
        pair((5.0, 1.0, -8.0), radians(0.1)),
        pair((0.4, 0.0, 0.9), radians(20.0), error=(0.03, -0.02, 0.0)),
    ]
    fit = solve_wahba(pairs)
    assert degrees(2.0 * np.linalg.norm(q_mul(fit.q_nb, q_conj(Q))[1:])) < 0.01


def test_the_covariance_of_the_fit_is_that_of_its_errors():
    rng = np.random.default_rng(3)
    worlds, sigmas = [(0.0, 2.0, -9.0), (0.4, 0.0, 0.9), (3.0, 0.0, -9.0)], [0.02, 0.03, 0.02]
    errors = []
    for _ in range(400):
        pairs = [pair(w, s, tuple(rng.normal(0.0, s, 3))) for w, s in zip(worlds, sigmas, strict=True)]
        fit = solve_wahba(pairs)
        error = 2.0 * np.array(q_mul(Q, q_conj(fit.q_nb)))
        errors.append(np.sign(error[0]) * error[1:])
    ratio = np.linalg.eigvals(np.cov(np.array(errors).T) @ np.linalg.inv(np.array(fit.covariance)))
    assert min(ratio.real) > 0.7
    assert max(ratio.real) < 1.4


def test_parallel_directions_make_no_attitude():
    assert solve_wahba([pair((0.0, 1.0, -9.0), 0.01), pair((0.0, -1.0, 9.0), 0.01)]) is None


def test_on_the_ground_it_starts_within_a_second(plane_log):
    states = plane_log.run(last=60)
    tilt, heading = plane_log.errors(states)
    started = np.flatnonzero(np.isfinite(tilt))[0]
    assert plane_log.samples[started].t_ns < 1e9
    assert np.nanmax(tilt) < 0.2
    assert np.nanmax(np.abs(heading)) < 0.5
    assert not states[0].aligned
    assert states[-1].referred_to == North.TRUE


@pytest.mark.parametrize("seconds", [20.0, 37.3, 51.7, 66.0, 90.4])
def test_it_starts_in_the_middle_of_a_turn(plane_log, seconds):
    first = round(seconds * 50)
    states = plane_log.run(first=first, last=first + 250)
    tilt, heading = plane_log.errors(states, first)
    started = np.flatnonzero(np.isfinite(tilt))[0]
    assert started < 50 * 3
    assert np.nanmax(tilt) < 2.0
    assert np.nanmax(np.abs(heading)) < 5.0


def test_its_first_attitude_is_no_better_known_than_it_is(plane_log):
    """Over many starts the errors of the first output are within three of its sigmas."""
    for first in range(600, 5000, 400):
        states = plane_log.run(first=first, last=first + 200)
        tilt, heading = plane_log.errors(states, first)
        k = np.flatnonzero(np.isfinite(tilt))[0]
        assert tilt[k] < 3.0 * degrees(states[k].tilt_sigma)
        assert abs(heading[k]) < 3.0 * degrees(states[k].heading_sigma)


def test_without_a_velocity_it_waits_for_rest_then_starts_with_what_there_is(plane_log):
    first = 1500
    state, ready = None, None
    chosen_states = []
    for k in range(first, first + 300):
        sample = plane_log.samples[k]
        states = _step(plane_log, k, state)
        state = states
        chosen_states.append(states)
        if ready is None and states.aligned:
            ready = (sample.t_ns - plane_log.samples[first].t_ns) * 1e-9
    assert ready == pytest.approx(5.0, abs=0.1)
    lean = degrees(tilt_between(chosen_states[-1].q_nb, plane_log.truth[first + 299]))
    assert lean < 3.0 * degrees(chosen_states[-1].tilt_sigma)
    assert degrees(chosen_states[-1].tilt_sigma) > 5.0


def _step(flight, k, state):
    """One step in which no velocity is known."""
    from attest_mav.filters.base import FilterInputs, Start  # noqa: PLC0415
    from attest_mav.filters.velocity_aided.filter import VelocityAided  # noqa: PLC0415

    sample = flight.samples[k]
    if state is None:
        return VelocityAided().initial(
            Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.RELATIVE, sample.accel, sample.mag, at_rest=False)
        )
    return VelocityAided().step(
        state, 0.02, sample, FilterInputs(declination=flight.inputs[k].declination, zero_mean_velocity=False)
    )


def test_at_2_hz_a_start_among_rolls_knows_what_it_has_missed(telemetry):
    """Between samples the wing rolls to the other side and half of the way back."""
    rolling = coordinated(60.0, lambda t: radians(50.0) * np.sin(2.0 * np.pi * t / 1.7))
    flight = telemetry(rolling, rate_hz=2.0)
    inside = []
    for first in range(2, 90, 2):
        states = flight.run(first=first, last=first + 20)
        tilt, _ = flight.errors(states, first)
        k = np.flatnonzero(np.isfinite(tilt))[0]
        inside.append(tilt[k] < 3.0 * degrees(states[k].tilt_sigma))
    assert np.mean(inside) > 0.95
