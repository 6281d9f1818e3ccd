"""The named blocks against the same filter written with one dense matrix."""

import numpy as np
import pytest

from attest_mav.algebra import q_heading, q_to_matrix
from attest_mav.filters.velocity_aided.covariance import Covariance, ProcessNoise, drifted, propagated
from attest_mav.filters.velocity_aided.covariance_blocks import (
    ErrorBlock,
    decoupled,
    diagonal_covariance,
    turned,
    with_added_variance,
    with_component_restarted,
    with_gyro_bias_floor,
)
from attest_mav.filters.velocity_aided.measurement import Measurement, consider_updated, cross_covariance, updated
from attest_mav.matrices import diagonal

NAMES = "tvbsamdr"
SIZE = 3 * len(NAMES)
BLOCKS = [x + y for i, x in enumerate(NAMES) for y in NAMES[i:]]


def from_dense(p):
    def block(name):
        i, j = (3 * NAMES.index(letter) for letter in name)
        return tuple(tuple(float(x) for x in measurement) for measurement in p[i : i + 3, j : j + 3])

    return Covariance(*(block(name) for name in BLOCKS))


def to_dense(covariance):
    p = np.zeros((SIZE, SIZE))
    for name in BLOCKS:
        i, j = (3 * NAMES.index(letter) for letter in name)
        p[i : i + 3, j : j + 3] = getattr(covariance, name)
        p[j : j + 3, i : i + 3] = np.transpose(getattr(covariance, name))
    return p


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def transition(rotation_dt, delta_velocity, rate):
    """The same step as one matrix: t' = t - turn (b + W s), v' = v - [push]x t' - turn a."""
    f = np.eye(SIZE)
    f[0:3, 6:9] = -rotation_dt
    f[0:3, 9:12] = -rotation_dt @ np.diag(rate)
    f[3:6, 0:3] = -skew(delta_velocity)
    f[3:6, 6:9] = skew(delta_velocity) @ rotation_dt
    f[3:6, 9:12] = skew(delta_velocity) @ rotation_dt @ np.diag(rate)
    f[3:6, 12:15] = -rotation_dt
    return f


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.fixture
def dense(rng):
    root = rng.normal(size=(SIZE, SIZE))
    return root @ root.T + 0.1 * np.eye(SIZE)


def floats(v):
    return tuple(float(x) for x in v)


def tuples(m):
    return tuple(floats(measurement) for measurement in m)


def test_blocks_are_taken_and_given_back(dense):
    assert np.array_equal(to_dense(from_dense(dense)), dense)


def test_propagation_is_f_p_f_transposed_plus_q(rng, dense):
    rotation_dt, delta_velocity, rate = 0.02 * rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=3)
    noise = ProcessNoise(1e-3, diagonal(2e-3), 3e-3, 4e-3, 5e-3, 6e-3)
    result = to_dense(propagated(from_dense(dense), tuples(rotation_dt), floats(delta_velocity), floats(rate), noise))
    f = transition(rotation_dt, delta_velocity, rate)
    q = np.diag(np.repeat([1e-3, 2e-3, 3e-3, 0.0, 4e-3, 5e-3, 0.0, 6e-3], 3))
    assert np.allclose(result, f @ dense @ f.T + q, rtol=1e-12, atol=1e-12)


def test_the_bias_drifts_and_the_drift_rate_fades(dense):
    f = np.eye(SIZE)
    f[6:9, 21:24] = 0.3 * np.eye(3)
    f[21:24, 21:24] = 0.9 * np.eye(3)
    assert np.allclose(to_dense(drifted(from_dense(dense), 0.3, 0.9)), f @ dense @ f.T, rtol=1e-12, atol=1e-12)


def random_measurement(rng):
    """A measurement, and its Jacobian as one vector."""
    h = np.zeros(SIZE)
    parts = {}
    for name in "tvbmd":
        v = rng.normal(size=3)
        h[3 * NAMES.index(name) : 3 * NAMES.index(name) + 3] = v
        parts[name] = floats(v)
    return Measurement(0.3, **parts), h


def test_an_update_is_the_joseph_form(rng, dense):
    measurement, h = random_measurement(rng)
    cross_cov = cross_covariance(from_dense(dense), measurement)
    assert cross_cov.state_variance == pytest.approx(h @ dense @ h)
    variance = 0.7
    gain = dense @ h / (h @ dense @ h + variance)
    joseph = np.eye(SIZE) - np.outer(gain, h)
    expected = joseph @ dense @ joseph.T + variance * np.outer(gain, gain)
    result = to_dense(updated(from_dense(dense), cross_cov, 1.0 / (cross_cov.state_variance + variance)))
    assert np.allclose(result, expected, rtol=1e-10, atol=1e-10)


def test_a_consider_update_is_the_joseph_form_with_no_gain_for_the_sensors(rng, dense):
    measurement, h = random_measurement(rng)
    cross_cov = cross_covariance(from_dense(dense), measurement)
    variance = 0.7
    gain = dense @ h / (h @ dense @ h + variance)
    gain[9:] = 0.0
    joseph = np.eye(SIZE) - np.outer(gain, h)
    expected = joseph @ dense @ joseph.T + variance * np.outer(gain, gain)
    k = 1.0 / (cross_cov.state_variance + variance)
    assert np.allclose(to_dense(consider_updated(from_dense(dense), cross_cov, k)), expected, rtol=1e-10, atol=1e-10)
    without = cross_cov.without_sensors()
    assert (without.t, without.v, without.b) == (cross_cov.t, cross_cov.v, cross_cov.b)
    assert without.s == without.a == without.m == without.d == without.r == (0.0, 0.0, 0.0)


def test_the_gyro_bias_is_known_no_better_than_its_floor_below_which_it_may_drift(dense):
    own = range(3 * ErrorBlock.GYRO_BIAS, 3 * ErrorBlock.GYRO_BIAS + 3)
    floored = dense.copy()
    floored[own, own] = np.maximum(np.diag(dense)[own], 20.0)
    floored[:21, 21:] = floored[21:, :21] = 0.0
    assert not np.array_equal(floored, dense)
    assert np.array_equal(to_dense(with_gyro_bias_floor(from_dense(dense), 20.0)), floored)


@pytest.mark.parametrize("error", list(ErrorBlock))
def test_blocks_are_edited_by_name(dense, error):
    p, own = from_dense(dense), slice(3 * error, 3 * error + 3)
    added = dense.copy()
    added[own, own] += np.diag([1.0, 2.0, 3.0])
    assert np.array_equal(to_dense(with_added_variance(p, error, (1.0, 2.0, 3.0))), added)
    alone = dense.copy()
    alone[own, :], alone[:, own] = 0.0, 0.0
    alone[own, own] = np.diag([4.0] * 3)
    assert np.array_equal(to_dense(decoupled(p, error, diagonal(4.0))), alone)
    for axis in range(3):
        restarted = dense.copy()
        restarted[own.start + axis, :], restarted[:, own.start + axis] = 0.0, 0.0
        restarted[own.start + axis, own.start + axis] = 7.0
        assert np.array_equal(to_dense(with_component_restarted(p, error, axis, 7.0)), restarted)


def test_errors_that_are_independent_make_a_block_diagonal(dense):
    diagonals = [tuples(dense[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]) for i in range(8)]
    expected = np.where(np.kron(np.eye(8), np.ones((3, 3))) > 0.0, dense, 0.0)
    assert np.array_equal(to_dense(diagonal_covariance(diagonals)), expected)


def test_a_thousand_steps_and_updates_stay_symmetric_and_positive(rng):
    covariance = from_dense(np.diag(np.repeat([1e-3, 0.1, 1e-5, 1e-5, 1e-3, 1e-4, 1e-3, 1e-9], 3)))
    assert covariance.tt == diagonal(1e-3)
    for k in range(1000):
        rotation_dt, delta_velocity = np.linalg.qr(rng.normal(size=(3, 3)))[0] * 0.02, 0.2 * rng.normal(size=3)
        noise = ProcessNoise(1e-8, diagonal(1e-6), 1e-12, 1e-12, 1e-12, 1e-15)
        covariance = propagated(
            covariance, tuples(rotation_dt), floats(delta_velocity), floats(rng.normal(size=3)), noise
        )
        covariance = drifted(covariance, 0.02, 0.9999)
        if k % 5 == 0:
            measurement = Measurement(0.0, t=floats(rng.normal(size=3)), v=(1.0, 0.0, 0.0), d=(0.0, 1.0, 0.0))
            cross_cov = cross_covariance(covariance, measurement)
            covariance = updated(covariance, cross_cov, 1.0 / (cross_cov.state_variance + 1e-4))
    p = to_dense(covariance)
    assert np.linalg.eigvalsh(p).min() > -1e-15
    assert np.allclose(np.array(covariance.vv), np.array(covariance.vv).T, rtol=0.0, atol=1e-15)


def test_a_turned_attitude_turns_its_errors(dense):
    turn = np.array(q_to_matrix(q_heading(0.7)))
    whole = np.eye(SIZE)
    whole[0:3, 0:3] = whole[3:6, 3:6] = turn
    found = turned(from_dense(dense), tuple(floats(row) for row in turn))
    assert to_dense(found) == pytest.approx(whole @ dense @ whole.T)
