"""Sensor errors have the sizes they are given, and a run is the filter's own steps."""

import numpy as np
import pytest

from attest_mav.evaluation.attitude_error import accuracy, error_vectors
from attest_mav.evaluation.motion import euler_to_quaternion, motion, multiply, times
from attest_mav.evaluation.simulation import SensorErrors, imu_samples, run_filter
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.types import G_MPS2, North

T = times(100.0, 100.0)
STILL = motion((0.0 * T, 0.0 * T, 0.0 * T), np.zeros((len(T), 3)), 0.01)
FIELD = (0.5, 0.0, 0.8)
ERRORS = SensorErrors(gyro_noise=0.001, gyro_bias=0.01, accel_noise=0.04, mag_noise=0.008)


def columns(samples):
    return (np.array([getattr(sample, name) for sample in samples]) for name in ("gyro", "accel", "mag"))


def test_without_errors_the_sensors_read_the_truth():
    gyro, accel, mag = columns(imu_samples(STILL, FIELD, SensorErrors(), np.random.default_rng(1)))
    assert np.all(gyro == 0.0)
    assert accel == pytest.approx(np.tile((0.0, 0.0, -G_MPS2), (len(accel), 1)))
    assert mag == pytest.approx(np.tile(FIELD, (len(mag), 1)))


def test_errors_have_the_sizes_given():
    gyro, accel, mag = columns(imu_samples(STILL, FIELD, ERRORS, np.random.default_rng(1)))
    # 10,000 samples: a standard deviation is known to 0.7 %, a mean to 1 % of it.
    assert np.abs(gyro.mean(axis=0)) == pytest.approx(np.full(3, 0.01), abs=5e-5)
    assert gyro.std(axis=0) == pytest.approx(np.full(3, 0.001), rel=0.04)
    assert (accel - (0.0, 0.0, -G_MPS2)).std(axis=0) == pytest.approx(np.full(3, 0.04), rel=0.04)
    assert (mag - FIELD).std(axis=0) == pytest.approx(np.full(3, 0.008), rel=0.04)


def test_runs_that_differ_in_one_error_share_all_other_draws():
    _, with_bias, _ = columns(imu_samples(STILL, FIELD, ERRORS, np.random.default_rng(1)))
    _, without, _ = columns(imu_samples(STILL, FIELD, SensorErrors(accel_noise=0.04), np.random.default_rng(1)))
    assert np.array_equal(with_bias, without)


def test_samples_carry_their_time():
    samples = imu_samples(STILL, FIELD, SensorErrors(), np.random.default_rng(1))
    assert [sample.t_ns for sample in samples[:2]] == [10_000_000, 20_000_000]


def test_a_run_is_the_filters_steps():
    samples = imu_samples(STILL, FIELD, ERRORS, np.random.default_rng(1))[:50]
    chosen = GradientDescent()
    state = chosen.initial(Start(STILL.start, (0.0, 0.0, 0.0), North.TRUE, (0.0, 0.0, -G_MPS2), None))
    for sample in samples:
        state = chosen.step(state, 0.01, sample, FilterInputs())
    assert tuple(run_filter(chosen, STILL.start, samples, 0.01)[-1].tolist()) == state.q_nb


# --- figures ------------------------------------------------------------------------------------------------------


def turned(truth, roll, pitch, yaw):
    """The truth turned by small angles about north, east and down."""
    n = len(truth)
    return multiply(euler_to_quaternion(np.full(n, roll), np.full(n, pitch), np.full(n, yaw)), truth)


def test_the_error_vector_is_the_turn_in_ned_whatever_the_attitude_and_its_sign():
    truth = euler_to_quaternion(0.5 * np.sin(T), 0.4 * np.cos(T), 0.3 * T)
    estimate = turned(truth, 1e-4, -2e-4, 3e-4)
    estimate[::2] *= -1.0
    expected = np.tile((1e-4, -2e-4, 3e-4), (len(T), 1))
    assert error_vectors(estimate, truth) == pytest.approx(expected, abs=1e-7)


def test_accuracy_splits_tilt_heading_and_vibration_and_skips_the_start():
    truth = np.tile((1.0, 0.0, 0.0, 0.0), (10_000, 1))
    shaking = 1e-3 * np.sin(2.0 * np.pi * 20.0 * T[1:])
    estimate = euler_to_quaternion(np.full(10_000, 0.003), np.full(10_000, 0.004), 0.006 + shaking)
    estimate[:1999] = (0.0, 1.0, 0.0, 0.0)
    figures = accuracy(estimate, truth, 100.0, 20.0)
    assert np.radians(figures.tilt) == pytest.approx(0.005, rel=1e-4)
    assert np.radians(figures.heading) == pytest.approx(np.sqrt(0.006**2 + 0.5e-6), rel=1e-3)
    assert figures.total == pytest.approx(np.hypot(figures.tilt, figures.heading))
    # 20 Hz is far above the cutoff: all but 1e-5 of it passes.
    assert np.radians(figures.hf) == pytest.approx(1e-3 / np.sqrt(2.0), rel=1e-3)
