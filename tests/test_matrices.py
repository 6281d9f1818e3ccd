"""The written-out matrices against numpy, on random values."""

import numpy as np
import pytest

from attest_mav import matrices as m
from attest_mav import matrices4 as m4


def rows(array):
    return tuple(tuple(row) for row in array.tolist())


def vector(array):
    return tuple(array.tolist())


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def near(ours, expected, tolerance=1e-14):
    assert np.abs(np.array(ours) - expected).max() < tolerance


def covariance(rng, size):
    half = rng.standard_normal((size, size))
    return half @ half.T + 0.1 * np.eye(size)


def test_products_of_three_rows(rng):
    a, b = rng.standard_normal((2, 3, 3))
    u, v = rng.standard_normal((2, 3))
    near(m.transpose(rows(a)), a.T)
    near(m.mat_add(rows(a), rows(b)), a + b)
    near(m.mat_scale(rows(a), 2.5), 2.5 * a)
    near(m.mat_t_vec(rows(a), vector(v)), a.T @ v)
    near(m.mat_mul(rows(a), rows(b)), a @ b)
    near(m.mat_mul_t(rows(a), rows(b)), a @ b.T)
    near(m.minus_outer(rows(a), vector(u), vector(v)), a - np.outer(u, v))
    near(m.symmetric(rows(a)), (a + a.T) / 2)
    assert m.quadratic(rows(a), vector(v)) == pytest.approx(v @ a @ v)


def test_diagonals_of_three_rows(rng):
    a = rng.standard_normal((3, 3))
    near(m.diagonal(2.0), 2.0 * np.eye(3))
    near(m.add_diagonal(rows(a), 2.0), a + 2.0 * np.eye(3))
    near(m.floor_diagonal(rows(a), 0.3), np.where(np.eye(3, dtype=bool), np.maximum(a, 0.3), a))
    assert m.trace(rows(a)) == pytest.approx(np.trace(a))
    assert m.largest_variance(rows(a)) == a.diagonal().max()


def test_products_of_four_rows(rng):
    a = rng.standard_normal((4, 4))
    u, v = rng.standard_normal((2, 4))
    near(m4.transpose4(rows(a)), a.T)
    near(m4.mat_vec4(rows(a), vector(v)), a @ v)
    near(m4.rank_one4(rows(a), vector(u), vector(v)), a + np.outer(u, v))
    near(m4.scaled4(rows(a), 2.5), 2.5 * a)
    near(m4.symmetric4(rows(a)), (a + a.T) / 2)
    assert m4.quadratic4(rows(a), vector(v)) == pytest.approx(v @ a @ v)


def test_diagonals_of_four_rows(rng):
    a = rng.standard_normal((4, 4))
    near(m4.diagonal4(2.0), 2.0 * np.eye(4))
    near(m4.add_diagonal4(rows(a), 2.0), a + 2.0 * np.eye(4))
    near(m4.floor_diagonal4(rows(a), 0.3), np.where(np.eye(4, dtype=bool), np.maximum(a, 0.3), a))
    assert m4.largest_variance4(rows(a)) == a.diagonal().max()


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("value", [-1e-9, float("nan")])
def test_a_bad_variance_is_seen_wherever_it_is(place, value):
    broken = np.eye(4)
    broken[place, place] = value
    assert m4.no_negative_variance4(rows(np.eye(4)))
    assert not m4.no_negative_variance4(rows(broken))
    if place < 3:
        assert m.no_negative_variance(rows(np.eye(3)))
        assert not m.no_negative_variance(rows(broken[:3, :3]))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.05, 0.0999, 0.1001, 1.0, 3.0])
def test_turning_axes_is_the_exponential_of_the_cross_product_matrix(angle, rng):
    axis = rng.standard_normal(3)
    x, y, z = angle * axis / np.linalg.norm(axis)
    exponent = -np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    term, total = np.eye(3), np.eye(3)
    for k in range(1, 60):
        term = term @ exponent / k
        total = total + term
    near(m.axes_turn((x, y, z)), total, 3e-16 if angle < 1e-3 else 1e-14)


def test_one_row_of_a_kalman_filter(rng):
    p, h, r = covariance(rng, 4), rng.standard_normal(4), 0.3
    gain = p @ h / (h @ p @ h + r)
    left = np.eye(4) - np.outer(gain, h)
    k, after = m4.correction4(rows(p), vector(h), r)
    near(k, gain)
    near(after, left @ p @ left.T + r * np.outer(gain, gain), 1e-13)


@pytest.mark.parametrize("seed", range(20))
def test_a_nearly_exact_row_leaves_its_own_variance(seed):
    """P - k h^T P alone loses so many digits here that it errs by a factor of two or three on some of the seeds."""
    rng = np.random.default_rng(seed)
    half = rng.standard_normal((4, 4))
    p, h, r = 1e6 * (half @ half.T + 0.1 * np.eye(4)), rng.standard_normal(4), 1e-8
    _, after = m4.correction4(rows(p), vector(h), r)
    after = np.array(m4.symmetric4(after))
    # The least is about 1e-9, eigvalsh's own rounding as much.
    assert np.linalg.eigvalsh(after).min() > -1e-15 * np.linalg.eigvalsh(after).max()
    assert h @ after @ h == pytest.approx(r, rel=0.2)


def test_a_rotated_diagonal(rng):
    a, k = rng.normal(size=(3, 3)), rng.normal(size=3)
    near(m.rotated_diagonal(rows(a), vector(k)), a @ np.diag(k) @ a.T)
