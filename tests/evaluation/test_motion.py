"""True motions: their parts must belong together, whatever the angles."""

from math import pi, radians

import numpy as np
import pytest

from attest_mav.algebra import q_exp, q_from_euler, q_mul, rotate_back
from attest_mav.evaluation.motion import Wave, euler_to_quaternion, gauss_markov, mean_rate, motion, times, waves
from attest_mav.types import G_MPS2

T = times(20.0, 100.0)
ANGLES = (np.sin(T), 0.8 * np.sin(0.7 * T + 1.0), 2.0 * T)
"""Two and a half turns of yaw with large tilts: the half angle passes through its wrap."""


def test_times_run_from_zero_to_the_end():
    assert T[0] == 0.0
    assert T[-1] == pytest.approx(20.0)
    assert len(T) == 2001


def test_quaternions_are_those_of_the_angles_and_never_jump():
    q = euler_to_quaternion(*ANGLES)
    for k in (0, 700, 1400, 2000):
        assert abs(np.dot(q[k], q_from_euler(*(float(angle[k]) for angle in ANGLES)))) == pytest.approx(1.0)
    assert np.max(np.linalg.norm(np.diff(q, axis=0), axis=1)) < 0.03


def test_rates_turn_each_attitude_exactly_into_the_next():
    moving = motion(ANGLES, np.zeros((len(T), 3)), 0.01)
    q = moving.start
    for k in range(300):
        q = q_mul(q, q_exp(tuple((0.5 * 0.01 * moving.rate[k]).tolist())))
        assert q == pytest.approx(tuple(moving.q_nb[k].tolist()), abs=1e-12)


def test_standing_still_has_no_rate():
    still = euler_to_quaternion(np.full(3, 0.3), np.full(3, -0.2), np.full(3, 1.0))
    assert mean_rate(still, 0.01) == pytest.approx(np.zeros((2, 3)))


def test_specific_force_is_acceleration_less_gravity_in_the_body():
    acceleration = np.column_stack((np.cos(T), np.sin(T), 0.3 * T))
    moving = motion(ANGLES, acceleration, 0.01)
    north, east, down = acceleration[1000]
    expected = rotate_back(tuple(moving.q_nb[999].tolist()), (north, east, down - G_MPS2))
    assert moving.force[999] == pytest.approx(expected)
    assert moving.time_s[999] == pytest.approx(10.0)


def test_waves_add_up_with_random_phases():
    t = times(60.0, 100.0)
    parts = (Wave(30.0, 7.5), Wave(8.0, 1.25))
    angle = waves(t, parts, np.random.default_rng(1))
    power = sum(radians(part.amplitude_deg) ** 2 / 2.0 for part in parts)
    assert np.mean(angle[:-1] ** 2) == pytest.approx(power, rel=1e-6)
    assert not np.allclose(angle, waves(t, parts, np.random.default_rng(2)))


def test_accelerations_have_the_rms_and_memory_asked_for():
    rms, tau_s, dt_s = 0.7, 0.25, 0.01
    x = gauss_markov((200_000, 3), rms, tau_s, dt_s, np.random.default_rng(5))
    assert x.mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    # 2000 s hold 4000 independent pieces of 2 tau: the rms is known to about 1 / sqrt(2 * 4000) = 1.1 %.
    assert x.std(axis=0) == pytest.approx(np.full(3, rms), rel=0.05)
    lag = round(tau_s / dt_s)
    correlation = np.mean(x[:-lag] * x[lag:], axis=0) / x.var(axis=0)
    assert correlation == pytest.approx(np.full(3, np.exp(-1.0)), abs=0.05)


def test_accelerations_have_their_rms_from_the_first_sample_on():
    first = [gauss_markov((2, 3), 0.7, 1e-9, 0.01, np.random.default_rng(seed)) for seed in range(2000)]
    # Two samples without memory and their mean removed: half the variance is left.
    assert np.std([x[0] for x in first]) == pytest.approx(0.7 / np.sqrt(2.0), rel=0.05)


def test_a_full_turn_between_samples_is_not_invented():
    assert np.linalg.norm(mean_rate(euler_to_quaternion(*ANGLES), 0.01), axis=1).max() * 0.01 < pi / 2
