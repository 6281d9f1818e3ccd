"""Each option of the gradient-descent filter does what it says, against expectations of other origin."""

import random
from dataclasses import replace
from math import cos, degrees, exp, inf, nan, pi, radians, sin, sqrt

import numpy as np
import pytest
from scipy.linalg import expm

from attest_mav.algebra import (
    down_in_body,
    heading_between,
    norm,
    q_conj,
    q_exp,
    q_from_euler,
    q_heading,
    q_mul,
    q_norm,
    rotate_back,
    sub,
    tilt_between,
)
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.field_monitor import FieldMonitor
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.gradient_descent.inertial_force import InertialForce, advanced, initial_force
from attest_mav.filters.gradient_descent.options import OptionMemory
from attest_mav.filters.gradient_descent.state import GradientDescentState, OptionState
from attest_mav.filters.gradient_descent.stationary_bias import StationaryBias, detect_bias, initial_bias
from attest_mav.low_pass import Smoothed, smoothed, steady
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North

ZERO = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, -G_MPS2)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
MAG = (0.2, 0.0, 0.4)
NO_INPUTS = FilterInputs()
ALL_ON = GradientDescent(beta=0.02, rest_bias=True, accel_time_s=2.5, heading_rate=0.01, field_gate=True)


def reading(gyro=ZERO, accel=LEVEL, mag=MAG, saturated=False):
    return ImuSample("BROAD", 1, 1, 0, 0, gyro, accel, mag, saturated)


def started(filter_, q=UPRIGHT, mag=MAG, bias=ZERO):
    return filter_.initial(Start(q, bias, North.MAGNETIC, rotate_back(q, LEVEL), mag))


def run(filter_, state, samples, dt_s=0.01):
    for sample in samples:
        state = filter_.step(state, dt_s, sample, NO_INPUTS)
    return state


# --- the low-pass ------------------------------------------------------------------------------------------------


def test_the_low_pass_is_the_exact_solution_at_any_interval():
    """Against the matrix exponential of the equation in its docstring, input held over each interval."""
    rng = np.random.default_rng(1)
    time_s = 2.5
    system = np.zeros((3, 3))  # y, y', u
    system[0, 1], system[1, 0], system[1, 1], system[1, 2] = 1.0, -2.0 / time_s**2, -2.0 / time_s, 2.0 / time_s**2
    ours, theirs = steady((1.0, -2.0, 0.5)), np.array([[1.0, -2.0, 0.5], [0.0, 0.0, 0.0]])
    carry = {dt_s: expm(dt_s * system) for dt_s in (0.0035, 0.01, 0.25, 1.0, 7.0)}
    for dt_s in rng.choice(list(carry), 200).tolist():
        u = rng.standard_normal(3)
        ours = smoothed(ours, tuple(u.tolist()), dt_s, time_s)
        theirs = (carry[dt_s] @ np.vstack((theirs, u)))[:2]
        assert ours.value == pytest.approx(theirs[0], abs=1e-12)
        assert ours.slope == pytest.approx(time_s * theirs[1], abs=1e-12)


def test_the_low_pass_is_butterworth_with_its_corner_where_it_says():
    """At sqrt(2)/T the amplitude is sqrt(1/2), at k times that 1/sqrt(1 + k^4)."""
    time_s, dt_s = 2.0, 0.002
    for k in (1.0, 3.0):
        omega = k * sqrt(2.0) / time_s
        state, largest = steady(ZERO), 0.0
        for step in range(1, round(60.0 / dt_s)):
            state = smoothed(state, (sin(omega * step * dt_s), 0.0, 0.0), dt_s, time_s)
            largest = max(largest, abs(state.value[0])) if step * dt_s > 40.0 else 0.0
        assert largest == pytest.approx(1.0 / sqrt(1.0 + k**4), rel=2e-3)


# --- bias at rest ------------------------------------------------------------------------------------------------

BIAS = (0.010, -0.020, 0.005)


def quiet(rng, seconds, gyro=BIAS, noise=0.002):
    return [
        reading(
            tuple(b + rng.gauss(0.0, noise) for b in gyro),
            tuple(a + rng.gauss(0.0, 0.02) for a in LEVEL),
        )
        for _ in range(round(seconds * 100))
    ]


def test_the_bias_is_the_mean_gyro_at_rest():
    filter_ = GradientDescent(rest_bias=True)
    rng = random.Random(1)
    before = run(filter_, started(filter_), quiet(rng, 1.4))
    assert before.gyro_bias == ZERO
    after = run(filter_, before, quiet(rng, 4.0))
    # 0.5 s of low-pass and some 3 s of mean: noise of 0.002 on 100 Hz leaves 0.002 / sqrt(350) = 0.0001 of it.
    assert norm(sub(after.gyro_bias, BIAS)) < 0.0004


@pytest.mark.parametrize(
    ("rate", "shake", "name"),
    [
        (radians(2.5), 0.0, "a steady turn too fast for a bias"),
        (0.0, 1.5, "a shaken accelerometer"),
    ],
)
def test_motion_is_not_rest(rate, shake, name):
    state = initial_bias(ZERO, LEVEL)
    for k in range(1000):
        accel = (shake * (-1.0) ** (k // 5), 0.0, -G_MPS2)
        state = detect_bias(state, (0.0, 0.0, rate), accel, 0.01)
    assert state.bias == ZERO, name


def test_a_shaken_gyro_is_not_rest_and_rest_must_last():
    state = initial_bias(ZERO, LEVEL)
    for k in range(3000):
        jolt = radians(5.0) if k % 140 == 0 else 0.0  # every 1.4 s
        state = detect_bias(state, (0.01 + jolt, 0.0, 0.0), LEVEL, 0.01)
    assert state.bias == ZERO


def test_a_reading_that_is_not_finite_ends_the_rest_and_no_more():
    state = initial_bias(ZERO, LEVEL)
    for k in range(400):
        gyro = (nan, 0.0, 0.0) if k % 100 == 0 else (0.01, 0.0, 0.0)
        state = detect_bias(state, gyro, LEVEL, 0.01)
    assert state.bias == ZERO
    for _ in range(300):
        state = detect_bias(state, (0.01, 0.0, 0.0), LEVEL, 0.01)
    assert state.bias == pytest.approx((0.01, 0.0, 0.0), abs=1e-4)


def test_a_known_bias_keeps_the_attitude_while_it_turns():
    """After the rest it yaws by half a turn without a magnetometer: only the bias can drift it."""
    rate = (BIAS[0], BIAS[1], BIAS[2] + pi / 20.0)
    turning = [reading(rate, LEVEL, None) for _ in range(1000)]
    for rest_bias, low, high in ((True, 0.0, 0.1), (False, 2.0, 10.0)):
        filter_ = GradientDescent(beta=0.1, rest_bias=rest_bias, accel_time_s=2.5)
        state = run(filter_, started(filter_), quiet(random.Random(2), 10.0, noise=0.0))
        heading = state.q_nb
        state = run(filter_, state, turning)
        assert low <= abs(degrees(heading_between(state.q_nb, q_mul(heading, q_heading(pi / 2.0))))) <= high


# --- the accelerometer in almost inertial axes -------------------------------------------------------------------


def test_a_force_that_is_constant_in_the_world_is_kept_however_the_body_turns():
    q, gyro = q_from_euler(0.3, -0.4, 1.0), (1.0, -2.0, 0.5)
    force = initial_force(q, rotate_back(q, LEVEL))
    for dt_s in (0.01, 0.25, 0.0035, 1.0) * 20:
        q = q_mul(q, q_exp(tuple(0.5 * dt_s * w for w in gyro)))
        force = advanced(force, gyro, rotate_back(q, LEVEL), dt_s, 2.5)
        assert force.in_body == pytest.approx(rotate_back(q, LEVEL), abs=1e-9)


def worst_tilt(filter_):
    """Degrees: yawing at 90 deg/s while shaken to the north, 3 m/s^2 at 1 Hz, for 30 s; the last 10 s count."""
    rate, dt_s = (0.0, 0.0, pi / 2.0), 0.01
    q, state, worst = UPRIGHT, started(filter_, mag=None), 0.0
    for k in range(1, 3001):
        q = q_mul(q, q_exp((0.0, 0.0, 0.5 * rate[2] * dt_s)))
        accel = rotate_back(q, (3.0 * sin(2.0 * pi * k * dt_s), 0.0, -G_MPS2))
        state = filter_.step(state, dt_s, reading(rate, accel, None), NO_INPUTS)
        worst = max(worst, tilt_between(state.q_nb, q)) if k > 2000 else 0.0
    return degrees(worst)


def test_accelerations_to_and_fro_average_out():
    """The low-pass leaves 1/sqrt(1 + (2 pi T/sqrt(2))^4) of the 17 degrees by which the force leans: 0.14 degrees.

    Without it the step runs at 2 beta = 0.04 rad/s after the force, for half a second to one side, then back: 1.15.
    """
    left = degrees(3.0 / G_MPS2) / sqrt(1.0 + (2.0 * pi * 2.5 / sqrt(2.0)) ** 4)
    plain = GradientDescent(beta=0.02)
    assert worst_tilt(replace(plain, accel_time_s=2.5)) == pytest.approx(left, rel=0.25)
    assert worst_tilt(plain) == pytest.approx(degrees(0.04) * 0.5, rel=0.1)


def test_a_tilt_that_is_wrong_is_mended_at_the_rate_of_the_step():
    """5 degrees at 2 beta = 0.04 rad/s: 1 s brings 2.3 degrees."""
    filter_ = GradientDescent(beta=0.02, accel_time_s=2.5)
    wrong = q_from_euler(radians(5.0), 0.0, 0.0)
    state = filter_.initial(Start(wrong, ZERO, North.RELATIVE, LEVEL, None))
    state = run(filter_, state, [reading(mag=None)] * 100)
    assert degrees(tilt_between(state.q_nb, UPRIGHT)) == pytest.approx(5.0 - degrees(0.04), abs=0.1)


# --- the heading's own step --------------------------------------------------------------------------------------


def test_a_large_heading_error_is_mended_at_the_fixed_rate():
    filter_ = GradientDescent(heading_rate=0.01)
    for error in (0.5, -0.5, 3.0):
        state = run(filter_, started(filter_, q_heading(error)), [reading()] * 1000)
        expected = error - 0.1 * (1.0 if error > 0.0 else -1.0)
        assert heading_between(state.q_nb, UPRIGHT) == pytest.approx(expected, abs=1e-9)
        assert state.mag_used


def test_a_small_one_fades_and_does_not_chatter():
    filter_ = GradientDescent(heading_rate=0.01)
    state = run(filter_, started(filter_, q_heading(0.005)), [reading()] * 100)
    assert heading_between(state.q_nb, UPRIGHT) == pytest.approx(0.005 * exp(-1.0), rel=0.01)


def test_a_step_after_a_gap_counts_no_more_than_a_twentieth_of_a_second():
    filter_ = GradientDescent(heading_rate=0.01)
    state = run(filter_, started(filter_, q_heading(0.5)), [reading()], dt_s=1.0)
    assert heading_between(state.q_nb, UPRIGHT) == pytest.approx(0.5 - 0.01 * 0.05, abs=1e-12)


def test_no_field_touches_the_tilt():
    """The same motion with wild fields from the right and with none: the down directions agree to rounding."""
    rng = np.random.default_rng(3)
    filter_ = GradientDescent(beta=0.02, rest_bias=True, accel_time_s=2.5, heading_rate=0.1)
    with_field, without = started(filter_), started(filter_)
    for row in rng.standard_normal((500, 9)).tolist():
        gyro, accel = tuple(row[:3]), tuple(a + b for a, b in zip(LEVEL, row[3:6], strict=True))
        with_field = filter_.step(with_field, 0.01, reading(gyro, accel, (row[6], 3.0 + row[7], row[8])), NO_INPUTS)
        without = filter_.step(without, 0.01, reading(gyro, accel, None), NO_INPUTS)
    assert down_in_body(with_field.q_nb) == pytest.approx(down_in_body(without.q_nb), abs=1e-12)
    assert abs(heading_between(with_field.q_nb, without.q_nb)) > 0.1


@pytest.mark.parametrize("mag", [(0.0, 0.0, 0.5), (0.04, 0.0, 0.5), ZERO, (nan, 0.0, 0.4), (inf, 0.0, 0.4), None])
def test_a_field_without_a_heading_is_not_used(mag):
    filter_ = GradientDescent(heading_rate=0.01)
    state = run(filter_, started(filter_, q_heading(0.5)), [reading(mag=mag)] * 10)
    assert heading_between(state.q_nb, UPRIGHT) == pytest.approx(0.5, abs=1e-12)
    assert not state.mag_used


# --- the gate ----------------------------------------------------------------------------------------------------


def field(strength, dip_deg, heading=0.4):
    dip = radians(dip_deg)
    return (
        strength * cos(dip) * cos(heading),
        -strength * cos(dip) * sin(heading),
        strength * sin(dip),
    )


GATED = GradientDescent(heading_rate=0.01, field_gate=True)
USUAL = field(0.5, 60.0)


def turned(samples, dt_s=0.05):
    """How far the heading goes in these samples after a start in the usual field, rad; the last state."""
    state = run(GATED, started(GATED, mag=USUAL), samples, dt_s)
    return abs(heading_between(state.q_nb, UPRIGHT)), state


@pytest.mark.parametrize(
    ("strength", "dip_deg", "used"),
    [
        (0.5, 60.0, True),
        (0.54, 60.0, True),
        (0.46, 60.0, True),
        (0.56, 60.0, False),
        (0.44, 60.0, False),
        (0.5, 69.0, True),
        (0.5, 51.0, True),
        (0.5, 71.0, False),
        (0.5, 49.0, False),
    ],
)
def test_a_field_counts_while_it_is_within_a_tenth_and_ten_degrees_of_the_usual(strength, dip_deg, used):
    """Twenty seconds at 0.01 rad/s are 0.2 rad, less what the gate lets through before its 50 ms are over."""
    way, _ = turned([reading(mag=field(strength, dip_deg))] * 400)
    assert way == pytest.approx(0.2 if used else 0.0, abs=0.002)


def test_a_field_that_stays_is_the_new_reference_after_a_minute():
    way, state = turned([reading(mag=field(0.8, 60.0))] * 1180)  # 59 s
    assert way == pytest.approx(0.0, abs=0.002)
    state = run(GATED, state, [reading(mag=field(0.8, 60.0))] * 220, 0.05)  # 11 s more, 10 of which count
    assert abs(heading_between(state.q_nb, UPRIGHT)) == pytest.approx(0.1, abs=0.005)


def test_a_magnet_that_goes_away_leaves_nothing_behind():
    way, _ = turned([reading(mag=field(0.8, 60.0))] * 200 + [reading(mag=USUAL)] * 200)
    assert way == pytest.approx(0.1, abs=0.003)


def test_without_a_field_at_the_start_the_first_one_is_the_reference():
    state = run(GATED, started(GATED, mag=None), [reading(mag=USUAL)] * 20, 0.05)
    assert state.mag_used
    assert abs(heading_between(state.q_nb, UPRIGHT)) == pytest.approx(0.01, abs=1e-4)


# --- together ----------------------------------------------------------------------------------------------------


def test_without_an_option_the_filter_is_the_papers():
    state = started(GradientDescent())
    assert type(state) is GradientDescentState
    assert type(GradientDescent().step(state, 0.01, reading(), NO_INPUTS)) is GradientDescentState


def test_an_option_with_nothing_to_do_changes_nothing():
    """Never at rest, always the usual field: bit for bit the paper's attitudes."""
    rng = np.random.default_rng(5)
    plain, optional = GradientDescent(), GradientDescent(rest_bias=True, field_gate=True)
    a, b = started(plain), started(optional)
    for gyro in rng.standard_normal((200, 3)).tolist():
        mag = rotate_back(a.q_nb, MAG)
        a = plain.step(a, 0.01, reading(tuple(gyro), mag=mag), NO_INPUTS)
        b = optional.step(b, 0.01, reading(tuple(gyro), mag=mag), NO_INPUTS)
        assert a.q_nb == b.q_nb
        assert (a.accel_used, a.mag_used, a.field_residual) == (b.accel_used, b.mag_used, b.field_residual)


@pytest.mark.parametrize(
    "bad",
    [
        reading(gyro=(nan, 0.0, 0.0)),
        reading(gyro=(1e5, 0.0, 0.0)),
        reading(accel=(nan, 0.0, 0.0)),
        reading(accel=(1e300, 0.0, 0.0)),
        reading(accel=ZERO, mag=ZERO),
        reading(mag=(nan, 0.0, 0.0)),
        reading(mag=(1e300, 0.0, 0.0)),
        reading(accel=(0.0, 0.0, -60.0), saturated=True),
    ],
)
def test_a_bad_reading_leaves_no_trace(bad):
    good = started(ALL_ON)
    state = run(ALL_ON, good, [bad] * 3 + [reading()] * 300)
    assert all(abs(x) < inf for x in numbers(state))
    assert degrees(tilt_between(state.q_nb, UPRIGHT)) < 0.5
    assert norm(sub(state.memory.inertial.force.value, LEVEL)) < 0.5
    assert q_norm(state.q_nb) == pytest.approx(1.0, abs=1e-12)


def test_an_unusable_accelerometer_is_said_to_be_unused():
    state = run(ALL_ON, started(ALL_ON), [reading(accel=(nan, 0.0, 0.0))])
    assert not state.accel_used
    assert run(ALL_ON, state, [reading()]).accel_used


def numbers(state):
    """A state as plain numbers."""
    rest, inertial, gate = state.memory.stationary, state.memory.inertial, state.memory.field
    smoothings = (rest.gyro, rest.accel, inertial.force)
    flat = [*state.q_nb, *rest.bias, rest.quiet_s, rest.averaged_s, *inertial.q_inertial_body]
    flat += [x for s in smoothings for x in (*s.value, *s.slope)]
    return [*flat, gate.strength, gate.inclination, gate.usual_strength, gate.usual_inclination, gate.rejected_s]


def restored(flat):
    """The state of these numbers."""
    q, bias, (quiet_s, rested_s), axes = flat[:4], flat[4:7], flat[7:9], flat[9:13]
    low = [Smoothed(tuple(flat[i : i + 3]), tuple(flat[i + 3 : i + 6])) for i in (13, 19, 25)]
    learned = OptionMemory(
        StationaryBias(tuple(bias), low[0], low[1], quiet_s, rested_s),
        InertialForce(tuple(axes), low[2]),
        FieldMonitor(*flat[31:], True),
    )
    plain = GradientDescentState(tuple(q), tuple(bias), False, False, ZERO, ZERO, None)
    return OptionState(plain, tuple(q), False, learned, None, field_rejected=False)


def test_a_split_run_restored_from_numbers_is_the_whole_run_at_any_interval():
    rng = random.Random(7)
    still = quiet(rng, 3.0)
    moving = [
        reading(
            tuple(rng.gauss(0.0, 1.0) for _ in range(3)),
            tuple(a + rng.gauss(0.0, 2.0) for a in LEVEL),
            tuple(m + rng.gauss(0.0, 0.05) for m in MAG) if rng.random() < 0.8 else None,
        )
        for _ in range(300)
    ]
    steps = [(rng.choice((0.0035, 0.01, 0.25, 0.9)), sample) for sample in still + moving]
    whole = split = started(ALL_ON)
    for k, (dt_s, sample) in enumerate(steps):
        whole = ALL_ON.step(whole, dt_s, sample, NO_INPUTS)
        if k % 50 == 0:
            split = restored([float(text) for text in repr(numbers(split))[1:-1].split(", ")])
        split = ALL_ON.step(split, dt_s, sample, NO_INPUTS)
        assert split.q_nb == whole.q_nb
        assert q_norm(q_mul(q_conj(whole.q_nb), whole.q_nb)) == pytest.approx(1.0, abs=1e-12)
    assert whole.gyro_bias != ZERO
