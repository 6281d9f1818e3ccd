"""The algebra against formulas written independently with numpy."""

from math import cos, inf, isclose, nan, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from attest_mav import algebra

component = st.floats(-10.0, 10.0)
vectors = st.tuples(component, component, component)
angles = st.floats(-pi, pi)
attitudes = st.tuples(component, component, component, component).filter(lambda q: sum(x * x for x in q) > 0.01)
checked = settings(derandomize=True, max_examples=50, deadline=None)


def unit(q):
    return tuple((np.array(q) / np.linalg.norm(q)).tolist())


def skew(v):
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turn_about(axis, angle):
    """Rodrigues' formula: I + sin [u]x + (1 - cos) [u]x^2."""
    u = skew(np.array(axis) / np.linalg.norm(axis))
    return np.eye(3) + sin(angle) * u + (1.0 - cos(angle)) * u @ u


def of_axis(axis, angle):
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    return (cos(angle / 2), x * sin(angle / 2), y * sin(angle / 2), z * sin(angle / 2))


def left(q):
    """The matrix of multiplication by q from the left, from the table i^2 = j^2 = k^2 = ijk = -1."""
    w, x, y, z = q
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])


axes = vectors.filter(lambda v: sum(x * x for x in v) > 1e-4)

# --- vectors ------------------------------------------------------------------------------------------------------


@given(vectors, vectors, component)
@checked
def test_vector_operations(a, b, k):
    assert algebra.add(a, b) == pytest.approx(np.add(a, b))
    assert algebra.sub(a, b) == pytest.approx(np.subtract(a, b))
    assert algebra.scale(a, k) == pytest.approx(k * np.array(a))
    assert algebra.dot(a, b) == pytest.approx(np.dot(a, b), abs=1e-12)
    assert algebra.cross(a, b) == pytest.approx(skew(a) @ b, abs=1e-12)
    assert algebra.norm(a) == pytest.approx(np.linalg.norm(a))


@given(axes)
@checked
def test_unit_vector_has_length_one_and_the_same_direction(a):
    assert algebra.unit(a) == pytest.approx(np.array(a) / np.linalg.norm(a))


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_vector_with_a_component_that_is_no_number_is_not_finite(place, bad):
    v = [1.0, -2.0, 3.0]
    assert algebra.is_finite(tuple(v))
    v[place] = bad
    assert not algebra.is_finite(tuple(v))


# --- angles -------------------------------------------------------------------------------------------------------


@given(st.floats(-1000.0, 1000.0))
@checked
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle):
    wrapped = algebra.wrap_pi(angle)
    assert -pi < wrapped <= pi
    assert isclose(cos(wrapped), cos(angle), abs_tol=1e-12)
    assert isclose(sin(wrapped), sin(angle), abs_tol=1e-12)


@pytest.mark.parametrize(("angle", "wrapped"), [(pi, pi), (-pi, pi), (3 * pi, pi), (0.0, 0.0), (-3 * pi, pi)])
def test_half_a_turn_is_positive(angle, wrapped):
    assert algebra.wrap_pi(angle) == pytest.approx(wrapped)


@given(component, component, component)
@checked
def test_clamp(value, a, b):
    low, high = min(a, b), max(a, b)
    assert algebra.clamp(value, low, high) == np.clip(value, low, high)


# --- quaternions --------------------------------------------------------------------------------------------------


@given(attitudes, attitudes)
@checked
def test_product_follows_hamiltons_table_and_keeps_lengths(a, b):
    product = algebra.q_mul(a, b)
    assert product == pytest.approx(left(a) @ b, abs=1e-10)
    assert algebra.q_norm(product) == pytest.approx(algebra.q_norm(a) * algebra.q_norm(b))


@given(attitudes)
@checked
def test_a_unit_quaternion_times_its_conjugate_is_no_rotation(q):
    q = algebra.q_unit(q)
    assert algebra.q_norm(q) == pytest.approx(1.0)
    assert algebra.q_mul(q, algebra.q_conj(q)) == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-12)


@given(axes, angles, vectors)
@checked
def test_rotation_is_rodrigues_and_undone_by_rotating_back(axis, angle, v):
    q = of_axis(axis, angle)
    assert algebra.rotate(q, v) == pytest.approx(turn_about(axis, angle) @ v, abs=1e-11)
    assert algebra.rotate_back(q, algebra.rotate(q, v)) == pytest.approx(v, abs=1e-11)
    assert np.array(algebra.q_to_matrix(q)) == pytest.approx(turn_about(axis, angle), abs=1e-12)
    assert algebra.mat_vec(algebra.q_to_matrix(q), v) == pytest.approx(algebra.rotate(q, v), abs=1e-11)


@given(axes, st.floats(-12.0, 1.5))
@checked
def test_exponential_is_the_half_angle_turn_at_any_size(axis, decade):
    """From 1e-12 rad, over the change from the series to cosine and sine, to 30 rad."""
    half = 10.0**decade
    u = tuple((half * np.array(axis) / np.linalg.norm(axis)).tolist())
    assert algebra.q_exp(u) == pytest.approx(of_axis(axis, 2.0 * half), rel=1e-13, abs=3e-16)


def test_exponential_of_nothing_is_no_rotation():
    assert algebra.q_exp((0.0, 0.0, 0.0)) == (1.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("angle_sq", [0.9999e-3, 1.0001e-3])
def test_exponential_is_as_exact_on_both_sides_of_its_change_of_method(angle_sq):
    half = angle_sq**0.5
    assert algebra.q_exp((half, 0.0, 0.0)) == pytest.approx((cos(half), sin(half), 0.0, 0.0), rel=2e-16, abs=0.0)


@given(attitudes, attitudes)
@checked
def test_the_continuous_sign_is_the_nearer_of_the_two(q, previous):
    chosen = np.array(algebra.q_continuous(q, previous))
    assert np.linalg.norm(chosen - previous) <= np.linalg.norm(-chosen - previous)
    assert algebra.q_dot(q, previous) == pytest.approx(np.dot(q, previous), abs=1e-12)


@given(attitudes)
@checked
def test_down_in_the_body_is_the_last_row_of_the_matrix(q):
    q = unit(q)
    assert algebra.down_in_body(q) == pytest.approx(algebra.q_to_matrix(q)[2])
    assert algebra.down_in_body(q) == pytest.approx(algebra.rotate_back(q, (0.0, 0.0, 1.0)), abs=1e-12)


def euler_matrix(roll, pitch, yaw):
    """Body to NED: yaw about down, then pitch about right, then roll about forward."""
    forward, right, down = np.eye(3)
    return turn_about(down, yaw) @ turn_about(right, pitch) @ turn_about(forward, roll)


@given(angles, st.floats(-1.57, 1.57), angles)
@checked
def test_euler_angles_are_the_three_turns_and_come_back(roll, pitch, yaw):
    q = algebra.q_from_euler(roll, pitch, yaw)
    assert np.array(algebra.q_to_matrix(q)) == pytest.approx(euler_matrix(roll, pitch, yaw), abs=1e-12)
    again = euler_matrix(*algebra.q_to_euler(q))
    # Near 90 degrees of pitch roll and yaw are not told apart, and asin loses half the digits.
    assert again == pytest.approx(euler_matrix(roll, pitch, yaw), abs=1e-7)


def test_pitch_never_leaves_its_range_by_rounding():
    w = 0.5**0.5
    assert algebra.q_to_euler((w * 1.0000001, 0.0, w * 1.0000001, 0.0))[1] == pytest.approx(pi / 2)


@given(angles)
@checked
def test_a_heading_turns_north_to_it(angle):
    assert algebra.rotate(algebra.q_heading(angle), (1.0, 0.0, 0.0)) == pytest.approx(
        (cos(angle), sin(angle), 0.0), abs=1e-12
    )


@given(attitudes, attitudes)
@checked
def test_tilt_between_is_the_angle_of_the_two_verticals(a, b):
    a, b = unit(a), unit(b)
    cosine = np.dot(algebra.q_to_matrix(a)[2], algebra.q_to_matrix(b)[2])
    assert cos(algebra.tilt_between(a, b)) == pytest.approx(cosine, abs=1e-12)
    assert 0.0 <= algebra.tilt_between(a, b) <= pi


@given(st.floats(0.0, 3.0), angles, st.floats(-3.1, 3.1), attitudes)
@checked
def test_tilt_and_heading_errors_are_told_apart(tilt, direction, heading, q):
    """Error: first a turn about the vertical, then a tilt about a horizontal axis of the world."""
    tilted = of_axis((cos(direction), sin(direction), 0.0), tilt)
    q = unit(q)
    wrong = algebra.q_mul(algebra.q_mul(tilted, algebra.q_heading(heading)), q)
    assert algebra.heading_between(wrong, q) == pytest.approx(heading, abs=1e-9)
    assert algebra.tilt_between(wrong, algebra.q_mul(algebra.q_heading(heading), q)) <= tilt + 1e-9


@given(axes, st.floats(0.0, pi))
@checked
def test_the_angle_of_a_rotation(axis, angle):
    assume(angle > 1e-6)
    assert algebra.angle_of(of_axis(axis, angle)) == pytest.approx(angle, rel=1e-9, abs=1e-9)
    assert algebra.angle_of(tuple(-x for x in of_axis(axis, angle))) == pytest.approx(angle, rel=1e-9, abs=1e-9)


@given(attitudes)
@checked
def test_the_quaternion_comes_back_from_its_matrix(q):
    q = unit(q)
    again = algebra.q_from_matrix(algebra.q_to_matrix(q))
    assert again[0] >= 0.0
    assert abs(np.dot(again, q)) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, -1), (0, 1, 1), (1, 1, 1)])
@pytest.mark.parametrize("angle", [0.0, 1e-9, pi - 1e-9, pi])
def test_the_quaternion_comes_back_where_single_formulas_fail(axis, angle):
    q = of_axis(axis, angle)
    again = np.array(algebra.q_from_matrix(algebra.q_to_matrix(q)))
    assert min(np.abs(again - q).max(), np.abs(again + q).max()) < 1e-15
