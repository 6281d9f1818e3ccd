"""The filter against the printed equations: test vectors, gradients, the identity of the complete form."""

import random
from math import cos, inf, pi, radians, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.algebra import down_in_body, heading_between, q_from_euler, tilt_between
from attest_mav.evaluation.papers.paper1_equations import identity_gap, jacobian_gap, misfit
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import FixedField, GradientDescent
from attest_mav.filters.gradient_descent.gradients import field_misfit, full_gradient, gravity_gradient
from attest_mav.filters.gradient_descent.state import GradientDescentState
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North

Q = q_from_euler(0.1, -0.2, 0.3)
GYRO = (0.05, -0.02, 0.1)
ACCEL = (1.5, 1.0, -9.6)
MAG = (0.45, -0.1, 0.85)
FIELD = FixedField(0.5, sqrt(0.75))
ZERO = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, -G_MPS2)
NO_INPUTS = FilterInputs()


def reading(gyro=GYRO, accel=ACCEL, mag=MAG, saturated=False):
    return ImuSample("RAW_IMU", 1, 1, 0, 0, gyro, accel, mag, saturated)


def started(filter_, q=Q, bias=ZERO):
    return filter_.initial(Start(q, bias, North.MAGNETIC, ACCEL, MAG))


def after(filter_, sample, q=Q, dt_s=0.01, steps=1, bias=ZERO):
    """The attitude after so many steps with the same reading."""
    state = started(filter_, q, bias)
    for _ in range(steps):
        state = filter_.step(state, dt_s, sample, NO_INPUTS)
    return state.q_nb


# --- vectors: computed by an independent implementation of the same equations ------------------------------------


@pytest.mark.parametrize(
    ("filter_", "mag", "expected"),
    [
        pytest.param(
            GradientDescent(beta=0.1, exponential=False, field=FIELD),
            MAG,
            (0.981849742988, 0.063796818078, -0.090411638937, 0.154035008173),
            id="(31)",
        ),
        pytest.param(
            GradientDescent(beta=0.1, exponential=False),
            MAG,
            (0.981846497105, 0.063607145391, -0.090556321307, 0.154049147512),
            id="reference field from the estimate",
        ),
        pytest.param(
            GradientDescent(beta=0.1, exponential=False, field=FIELD),
            None,
            (0.98186005238, 0.06368216004, -0.090491374563, 0.153969903431),
            id="accelerometer only",
        ),
        pytest.param(
            GradientDescent(beta=0.1, exponential=False, field=FIELD, full_fusion=True, alpha=10.0),
            MAG,
            (0.981850767542, 0.063837933174, -0.090523345453, 0.153945810251),
            id="(26)-(30), alpha 10",
        ),
    ],
)
def test_one_step_gives_the_published_attitude(filter_, mag, expected):
    assert after(filter_, reading(mag=mag)) == pytest.approx(expected, abs=1e-9)


def test_gradients_give_the_published_values():
    down = tuple(-x / sqrt(sum(y * y for y in ACCEL)) for x in ACCEL)
    direction = tuple(x / sqrt(sum(y * y for y in MAG)) for x in MAG)
    f_g = tuple(a - b for a, b in zip(down_in_body(Q), down, strict=True))
    f_b = field_misfit(Q, down_in_body(Q), direction, FIELD.b_x, FIELD.b_z)
    gravity_only = (0.089874570852, 0.503229640940, -0.633034485528, 0.008633121085)
    with_field = (0.126542740676, 0.608464660894, -1.036213690344, -0.069012118564)
    assert gravity_gradient(Q, f_g) == pytest.approx(gravity_only, abs=1e-9)
    assert full_gradient(Q, f_g, f_b, FIELD.b_x, FIELD.b_z) == pytest.approx(with_field, abs=1e-9)


def test_the_field_levelled_by_the_estimate_has_the_published_parts():
    assert GradientDescent()._reference_field(
        down_in_body(Q), tuple(x / sqrt(sum(y * y for y in MAG)) for x in MAG)
    ) == pytest.approx((0.342383286747, 0.939560367915), abs=1e-9)


# --- equations ----------------------------------------------------------------------------------------------------

seeds = st.integers(0, 2**32)


@given(seeds)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_jacobians_are_the_derivatives_of_the_misfit(seed):
    assert jacobian_gap(np.random.default_rng(seed)) < 1e-6


@given(seeds)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_the_complete_form_is_the_simple_one_with_both_terms_slowed(seed):
    assert identity_gap(np.random.default_rng(seed)) < 1e-12


@given(seeds)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_the_field_misfit_is_that_of_the_general_equation(seed):
    rng = np.random.default_rng(seed)
    q, s, dip = rng.standard_normal(4), rng.standard_normal(3), rng.uniform(-pi / 2, pi / 2)
    q /= np.linalg.norm(q)
    ours = field_misfit(tuple(q.tolist()), down_in_body(tuple(q.tolist())), tuple(s.tolist()), cos(dip), sin(dip))
    assert ours == pytest.approx(misfit(q, np.array([cos(dip), 0.0, sin(dip)]), s), abs=1e-12)


def test_an_infinite_alpha_gives_the_simple_form():
    simple = after(GradientDescent(beta=0.1), reading())
    assert after(GradientDescent(beta=0.1, full_fusion=True, alpha=inf), reading()) == simple


@pytest.mark.parametrize(("alpha", "share"), [(2.0, 0.636), (10.0, 0.897), (100.0, 0.989)])
def test_the_complete_form_turns_too_slowly(alpha, share):
    """10 deg/s of yaw without a magnetometer at beta 0.1: the gyro loses a share that depends on its rate."""
    turning = reading((0.0, 0.0, radians(10.0)), LEVEL, None)
    q = after(GradientDescent(beta=0.1, full_fusion=True, alpha=alpha), turning, (1.0, 0.0, 0.0, 0.0), steps=500)
    assert heading_between(q, (1.0, 0.0, 0.0, 0.0)) / radians(50.0) == pytest.approx(share, abs=5e-4)


def test_the_complete_form_freezes_at_rest():
    tilted = q_from_euler(radians(11.46), 0.0, 0.0)
    still = reading(ZERO, LEVEL, None)
    assert after(GradientDescent(beta=0.1, full_fusion=True), still, tilted, steps=1000) == pytest.approx(tilted)
    level = after(GradientDescent(beta=0.1), still, tilted, steps=1000)
    assert tilt_between(level, (1.0, 0.0, 0.0, 0.0)) < 2 * 2 * 0.1 * 0.01


# --- behaviour ----------------------------------------------------------------------------------------------------


def test_a_wrong_tilt_goes_at_up_to_twice_beta():
    """A part of the gradient points along q, where normalising takes it back: the larger the tilt, the more."""
    beta, dt_s, steps = 0.05, 0.01, 20
    still, limit = reading(ZERO, LEVEL, None), 2 * beta * dt_s * steps
    small, large = q_from_euler(0.0, 0.05, 0.0), q_from_euler(0.0, 1.5, 0.0)
    from_small = tilt_between(small, after(GradientDescent(beta=beta), still, small, dt_s, steps))
    from_large = tilt_between(large, after(GradientDescent(beta=beta), still, large, dt_s, steps))
    assert 0.999 * limit < from_small < limit
    assert 0.4 * limit < from_large < 0.6 * limit


def test_without_correction_the_turn_is_exact_however_long_the_step():
    rate, dt_s = (0.3, -0.4, 1.2), 0.9
    once = after(GradientDescent(), reading(rate, ZERO, None), dt_s=dt_s)
    often = after(GradientDescent(), reading(rate, ZERO, None), dt_s=dt_s / 100, steps=100)
    assert once == pytest.approx(often, abs=1e-13)


def test_after_a_gap_one_reading_moves_the_attitude_no_further_than_in_fifty_milliseconds():
    tilted, still = q_from_euler(0.5, 0.0, 0.0), reading(ZERO, LEVEL, None)
    after_a_gap, usual = (after(GradientDescent(beta=0.1), still, tilted, dt_s) for dt_s in (1.0, 0.05))
    assert after_a_gap == usual != tilted


def test_the_gyro_bias_of_the_start_is_subtracted_and_kept():
    bias = (0.01, -0.02, 0.03)
    biased = tuple(rate + error for rate, error in zip(GYRO, bias, strict=True))
    with_bias = GradientDescent().step(started(GradientDescent(), bias=bias), 0.01, reading(biased), NO_INPUTS)
    assert with_bias.q_nb == pytest.approx(after(GradientDescent(), reading()), abs=1e-15)
    assert with_bias.gyro_bias == bias


def test_a_field_of_the_wrong_dip_tilts_only_against_a_fixed_reference():
    """The vehicle is level and heads north; iron nearby has made the field 20 degrees steeper, still due north."""
    steep = (cos(radians(80.0)), 0.0, sin(radians(80.0)))
    disturbed, level = reading(ZERO, LEVEL, steep), (1.0, 0.0, 0.0, 0.0)
    assert tilt_between(after(GradientDescent(), disturbed, level, steps=500), level) < 1e-9
    assert tilt_between(after(GradientDescent(field=FIELD), disturbed, level, steps=500), level) > radians(1.0)


def test_the_state_says_what_was_used_and_what_was_left_over():
    state = GradientDescent(field=FIELD).step(started(GradientDescent()), 0.01, reading(), NO_INPUTS)
    assert (state.accel_used, state.mag_used) == (True, True)
    turned = after(GradientDescent(), reading(accel=ZERO))
    down = tuple(-x / sqrt(sum(y * y for y in ACCEL)) for x in ACCEL)
    assert state.gravity_residual == pytest.approx(np.subtract(down_in_body(turned), down), abs=1e-14)
    direction = np.array(MAG) / np.linalg.norm(MAG)
    expected = misfit(np.array(turned), np.array([FIELD.b_x, 0.0, FIELD.b_z]), direction)
    assert state.field_residual == pytest.approx(expected, abs=1e-14)


@given(st.integers(0, 200), seeds)
@settings(derandomize=True, max_examples=20, deadline=None)
def test_a_run_split_anywhere_and_restored_from_plain_numbers_is_the_same_to_the_last_bit(split, seed):
    rng = np.random.default_rng(seed)
    filter_ = GradientDescent()
    samples = [reading(*map(tuple, row)) for row in rng.standard_normal((200, 3, 3)).tolist()]
    state = started(filter_)
    whole = []
    for k, sample in enumerate(samples):
        if k == split:
            saved = repr((state.q_nb, state.gyro_bias, state.gravity_residual, state.field_residual))
            q_nb, bias, gravity_residual, field_residual = parsed(saved)
            state = GradientDescentState(
                q_nb, bias, state.accel_used, state.mag_used, gravity_residual, field_residual, None
            )
        state = filter_.step(state, 0.01, sample, NO_INPUTS)
        whole.append(state.q_nb)
    state = started(filter_)
    for sample, expected in zip(samples, whole, strict=True):
        state = filter_.step(state, 0.01, sample, NO_INPUTS)
        assert state.q_nb == expected


@pytest.mark.parametrize(
    ("filter_", "expected"),
    [
        (GradientDescent(), (0.5082098161410201, 0.6378252074669611, -0.5786433214888536, -0.00858452060315724)),
        (
            GradientDescent(exponential=False, field=FIELD, full_fusion=True),
            (0.487906712064288, 0.8089191663257139, -0.32801903440399377, 0.0005794326531829858),
        ),
    ],
)
def test_compiled_and_interpreted_agree_after_a_hundred_thousand_random_steps(filter_, expected):
    """The attitude is that of the interpreted filter; the suite runs compiled as well."""
    rng = random.Random(1)

    def random_vector():
        return (rng.random() - 0.5, rng.random() - 0.5, rng.random() - 0.5)

    state = started(filter_)
    for _ in range(100_000):
        accel = tuple(20.0 * x for x in random_vector())
        mag = random_vector() if rng.random() < 0.7 else None
        state = filter_.step(state, 0.1 * rng.random() + 1e-3, reading(random_vector(), accel, mag), NO_INPUTS)
    assert state.q_nb == pytest.approx(expected, abs=1e-12)


def parsed(text):
    """The tuples of floats in their own repr."""
    numbers = [float(part) for part in text.replace("(", " ").replace(")", " ").replace(",", " ").split()]
    q_nb, bias, gravity, field = numbers[:4], numbers[4:7], numbers[7:10], numbers[10:]
    return tuple(q_nb), tuple(bias), tuple(gravity), tuple(field)


# --- readings that are missing or make no sense ------------------------------------------------------------------

NAN, HUGE = float("nan"), 1e300


@pytest.mark.parametrize("scale", [0.49, 1.51, 0.0, HUGE, inf, NAN])
def test_an_accelerometer_that_does_not_show_gravity_is_not_used(scale):
    state = GradientDescent().step(
        started(GradientDescent()), 0.01, reading(accel=(0.0, 0.0, -G_MPS2 * scale)), NO_INPUTS
    )
    assert (state.accel_used, state.mag_used) == (False, False)
    assert state.q_nb == after(GradientDescent(), reading(accel=ZERO, mag=None))


@pytest.mark.parametrize("scale", [0.51, 1.49])
def test_an_accelerometer_within_its_gate_is_used(scale):
    accel = (0.0, 0.0, -G_MPS2 * scale)
    assert GradientDescent().step(started(GradientDescent()), 0.01, reading(accel=accel), NO_INPUTS).accel_used


@pytest.mark.parametrize("mag", [None, ZERO, (NAN, 0.1, 0.2), (0.1, inf, 0.2), (HUGE, 0.0, 0.0)])
def test_a_magnetometer_that_shows_no_field_is_not_used(mag):
    state = GradientDescent().step(started(GradientDescent()), 0.01, reading(mag=mag), NO_INPUTS)
    assert (state.accel_used, state.mag_used) == (True, False)
    assert state.q_nb == after(GradientDescent(), reading(mag=None))


@pytest.mark.parametrize("gyro", [(NAN, 0.0, 0.0), (0.0, -inf, 0.0), (0.0, 0.0, HUGE)])
def test_without_a_usable_gyro_the_attitude_is_held(gyro):
    state = GradientDescent().step(started(GradientDescent()), 0.01, reading(gyro), NO_INPUTS)
    assert state.q_nb == Q
    assert (state.accel_used, state.mag_used) == (False, False)


def test_a_saturated_reading_turns_the_attitude_but_does_not_correct_it():
    state = GradientDescent().step(started(GradientDescent()), 0.01, reading(saturated=True), NO_INPUTS)
    assert (state.accel_used, state.mag_used) == (False, False)
    assert state.q_nb == after(GradientDescent(), reading(accel=ZERO))


def test_at_the_bottom_of_the_misfit_nothing_moves():
    level = (1.0, 0.0, 0.0, 0.0)
    assert after(GradientDescent(), reading(ZERO, LEVEL, None), level, steps=10) == level


anything = st.floats(allow_nan=True, allow_infinity=True)
vectors = st.tuples(anything, anything, anything)


@given(vectors, vectors, st.none() | vectors, st.floats(1e-6, 1.0), st.booleans(), st.booleans())
@settings(derandomize=True, max_examples=300, deadline=None)
def test_no_reading_whatever_breaks_the_attitude(gyro, accel, mag, dt_s, full_fusion, exponential):
    filter_ = GradientDescent(full_fusion=full_fusion, exponential=exponential, min_accel_g=0.0)
    q = after(filter_, reading(gyro, accel, mag), dt_s=dt_s, steps=3)
    assert sum(x * x for x in q) == pytest.approx(1.0)
