"""The leveling filter's equations: published vectors, and matrices written with numpy."""

from math import atan2, cos, degrees, nan, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.algebra import dot, q_from_euler, q_to_matrix, scale, unit
from attest_mav.filters.leveling.model import (
    LevelState,
    is_sound,
    predicted,
    tilt_variance,
    updated,
    with_variance_floor,
)
from attest_mav.filters.leveling.north import (
    EARTH_RATE,
    NorthVector,
    earth_rate,
    heading_error,
    level_axes,
    made_level,
    north_from_heading,
    turned_east,
)
from attest_mav.matrices import diagonal

ZERO = (0.0, 0.0, 0.0)
FORWARD = (1.0, 0.0, 0.0)
DOWN = (0.05, 0.1, 0.99)
LATITUDE = radians(37.5)
GYRO = (0.05, -0.02, 0.1)


def level(velocity=(4.0, 0.1, -0.2), down=DOWN, variance=1.0):
    return LevelState(velocity, down, diagonal(variance), diagonal(0.0), diagonal(variance))


def whole(x):
    """State and covariance as numpy arrays of 6 and 6 x 6."""
    p_vv, p_vd, p_dd = np.array(x.p_vv), np.array(x.p_vd), np.array(x.p_dd)
    return np.array([*x.velocity, *x.down]), np.block([[p_vv, p_vd], [p_vd.T, p_dd]])


def random_level(rng):
    half = rng.standard_normal((6, 6))
    p = half @ half.T
    blocks = [tuple(map(tuple, block.tolist())) for block in (p[:3, :3], p[:3, 3:], p[3:, 3:])]
    return LevelState(tuple(rng.standard_normal(3).tolist()), tuple(rng.standard_normal(3).tolist()), *blocks)


def cross_matrix(v):
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


# --- vectors: computed by an independent implementation of the same equations -------------------------------------


def test_the_earth_rate_has_the_published_values():
    down = unit(DOWN)
    north = north_from_heading(0.3, down, ZERO)
    with_heading = earth_rate(NorthVector(north, 0.0, True), down, LATITUDE, nan)
    without = earth_rate(NorthVector(north, 0.0, False), down, LATITUDE, nan)
    assert with_heading == pytest.approx((5.297087203e-5, -2.174437710e-5, -4.515266214e-5), abs=1e-14)
    assert without == pytest.approx((-2.227837479e-6, -4.455674957e-6, -4.411118208e-5), abs=1e-14)
    assert earth_rate(NorthVector(north, 0.0, True), down, nan, nan) == ZERO


def test_prediction_and_rows_give_the_published_states():
    earth = (5.297087203e-5, -2.174437710e-5, -4.515266214e-5)
    x = predicted(level(), GYRO, earth, (0.2, 0.5, -9.7), 9.81, 0.01, (1e-5, 3e-9))
    assert x.velocity == pytest.approx((4.00698481277, 0.110729823485, -0.200738249581), abs=1e-9)
    assert x.down == pytest.approx((0.050298046159, 0.100444288966, 0.989939923110), abs=1e-9)
    x = updated(x, FORWARD, ZERO, 4.1 - x.velocity[0], 0.01)
    assert x.velocity == pytest.approx((4.09908774986, 0.110729823485, -0.200738249581), abs=1e-9)
    assert x.down == pytest.approx((0.059247220033, 0.100444284927, 0.989939925058), abs=1e-9)
    x = updated(x, ZERO, scale(x.down, 2.0), 1.0 - dot(x.down, x.down), 0.5)
    assert x.velocity == pytest.approx((4.099087913438, 0.110758099888, -0.200459569871), abs=1e-9)
    assert x.down == pytest.approx((0.059415633567, 0.100732523941, 0.992780697008), abs=1e-9)
    roll, pitch = atan2(x.down[1], x.down[2]), atan2(-x.down[0], sqrt(x.down[1] ** 2 + x.down[2] ** 2))
    assert (degrees(roll), degrees(pitch)) == pytest.approx((5.79369001426, -3.407481177338), abs=1e-9)


# --- equations ----------------------------------------------------------------------------------------------------

seeds = st.integers(0, 2**32)


@given(seeds)
@settings(derandomize=True, max_examples=50, deadline=None)
def test_a_step_is_the_exponential_of_the_system_matrix(seed):
    rng = np.random.default_rng(seed)
    x = random_level(rng)
    rates = rng.uniform(-2.0, 2.0, 3)
    earth = rng.uniform(-1.0, 1.0, 3) * EARTH_RATE
    force, dt_s = rng.uniform(-20.0, 20.0, 3), rng.uniform(0.001, 0.02)
    f = np.zeros((7, 7))
    f[:3, :3], f[:3, 3:6], f[3:6, 3:6] = -cross_matrix(rates + earth), 9.81 * np.eye(3), -cross_matrix(rates - earth)
    f[:3, 6] = force
    phi, term = np.eye(7), np.eye(7)
    for k in range(1, 20):
        term = term @ f * dt_s / k
        phi = phi + term
    state, p = whole(x)
    ours, p_ours = whole(predicted(x, tuple(rates), tuple(earth), tuple(force), 9.81, dt_s, (0.1, 0.2)))
    noise = dt_s * np.diag([0.1] * 3 + [0.2] * 3)
    # The force is integrated to third order: the next term of it is below 20 (w dt)^3 dt / 24.
    assert np.abs(ours - (phi @ [*state, 1.0])[:6]).max() < 2e-6
    assert np.abs(ours[3:] - (phi @ [*state, 1.0])[3:6]).max() < 1e-13
    # Gravity's part leaves out how the Earth's turn and the gyro's fail to commute, 1e-4 w g dt^3 at most.
    assert np.abs(p_ours - (phi[:6, :6] @ p @ phi[:6, :6].T + noise)).max() < 1e-7


@given(seeds)
@settings(derandomize=True, max_examples=50, deadline=None)
def test_a_row_is_the_kalman_update_in_joseph_form(seed):
    rng = np.random.default_rng(seed)
    x, h, r, z = random_level(rng), rng.standard_normal(6), rng.uniform(0.01, 1.0), rng.standard_normal()
    state, p = whole(x)
    gain = p @ h / (h @ p @ h + r)
    left = np.eye(6) - np.outer(gain, h)
    ours, p_ours = whole(updated(x, tuple(h[:3].tolist()), tuple(h[3:].tolist()), z, r))
    assert np.abs(ours - (state + gain * z)).max() < 1e-12
    assert np.abs(p_ours - (left @ p @ left.T + r * np.outer(gain, gain))).max() < 1e-12


def test_the_length_row_is_the_derivative_of_the_squared_length():
    step = 1e-6
    for axis in range(3):
        shifted = list(DOWN)
        shifted[axis] += step
        numeric = (sum(a * a for a in shifted) - dot(DOWN, DOWN)) / step
        assert numeric == pytest.approx(2.0 * DOWN[axis], abs=2e-6)


def test_tilt_variance_leaves_out_what_changes_only_the_length():
    down = unit(DOWN)
    along, across = np.outer(down, down), np.eye(3) - np.outer(down, down)
    p_dd = tuple(map(tuple, (0.3 * along + 0.02 * across).tolist()))
    x = LevelState(ZERO, scale(down, 2.0), diagonal(1.0), diagonal(0.0), p_dd)
    assert tilt_variance(x) == pytest.approx(2 * 0.02 / 4.0)
    assert tilt_variance(level(down=ZERO)) == pi * pi


def test_soundness_sees_each_part():
    assert is_sound(level())
    assert not is_sound(level(velocity=(nan, 0.0, 0.0)))
    assert not is_sound(level(down=(0.0, float("inf"), 0.0)))
    assert not is_sound(level(variance=-1e-9))
    assert np.array(with_variance_floor(level(variance=0.0)).p_dd).diagonal().min() == 1e-12


# --- the north vector ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading", [-3.0, -0.3, 0.0, 1.5, 3.1])
@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.5, -0.7), (3.0, 1.4)])
def test_north_from_a_heading_completes_the_attitude(heading, roll, pitch):
    axes = q_to_matrix(q_from_euler(roll, pitch, heading))
    north = north_from_heading(heading, axes[2], ZERO)
    assert np.abs(np.array(level_axes(north, axes[2])) - np.array(axes)).max() < 1e-12


def test_a_nose_that_points_up_shows_no_heading():
    assert north_from_heading(1.0, (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) == (0.0, 1.0, 0.0)


@pytest.mark.parametrize("error", [-2.0, -0.1, 0.0, 0.3, 3.0])
def test_the_field_shows_how_far_north_is_off_and_turning_takes_it_there(error):
    axes = q_to_matrix(q_from_euler(0.4, -0.6, 1.0))
    north, down = axes[0], axes[2]
    field = tuple((0.2 * np.array(turned_east(north, down, error)) + 0.4 * np.array(down)).tolist())
    assert heading_error(north, down, field) == pytest.approx(error)
    assert heading_error(turned_east(north, down, error), down, field) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("field", [(0.0, 0.0, 0.0), (0.01, 0.0, 1.0), (nan, 0.0, 0.0), (1e300, 0.0, 0.0)])
def test_a_field_without_a_level_part_shows_nothing(field):
    assert np.isnan(heading_error((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), field))


def test_declination_turns_the_earth_rate_back_to_true_north():
    declination = radians(12.0)
    down = (0.0, 0.0, 1.0)
    ours = earth_rate(NorthVector((1.0, 0.0, 0.0), 0.0, True), down, LATITUDE, declination)
    horizontal = EARTH_RATE * cos(LATITUDE)
    # True north is 12 degrees to the left of magnetic north, which is the body's x here.
    assert ours == pytest.approx(
        (horizontal * cos(declination), -horizontal * sin(declination), -EARTH_RATE * sin(LATITUDE))
    )


@pytest.mark.parametrize("north", [(1.0, 0.2, 0.3), (0.0, 0.0, 2.0), (0.0, 0.0, 0.0), (0.0, 1e-9, -1.0)])
@pytest.mark.parametrize("down", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.6, 0.0, -0.8)])
def test_levelled_is_always_a_level_direction(north, down):
    ours = made_level(north, down)
    assert dot(ours, down) == pytest.approx(0.0, abs=1e-9)
    assert dot(ours, ours) == pytest.approx(1.0)
