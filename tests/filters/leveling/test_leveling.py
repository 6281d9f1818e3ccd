"""The leveling filter in motion and at rest, from any start, and with readings that are missing or bad."""

from dataclasses import replace
from math import cos, degrees, exp, inf, isnan, nan, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.algebra import (
    heading_between,
    norm,
    q_from_euler,
    q_heading,
    q_mul,
    q_norm,
    q_to_euler,
    rotate_back,
    tilt_between,
)
from attest_mav.filters.base import BodyVelocity, FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.leveling.filter import Leveling
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North

ONE = (1.0, 0.0, 0.0, 0.0)
ZERO = (0.0, 0.0, 0.0)
REST = (0.0, 0.0, -G_MPS2)
FIELD = (0.2, 0.0, 0.35)
STANDING = FilterInputs(stationary=True)
NO_INPUTS = FilterInputs()


def reading(gyro=ZERO, accel=REST, mag=FIELD, saturated=False):
    return ImuSample("RAW_IMU", 1, 1, 0, 0, gyro, accel, mag, saturated)


def started(filter_, q=ONE, north=North.MAGNETIC, at_rest=True):
    return filter_.initial(Start(q, ZERO, north, REST, None, at_rest))


def run(filter_, steps, state=None, dt_s=0.02, q=ONE):
    """The state after (sample, aids) pairs."""
    state = started(filter_, q) if state is None else state
    for sample, inputs in steps:
        state = filter_.step(state, dt_s, sample, inputs)
    return state


def moving(speed, **lateral):
    return FilterInputs(BodyVelocity(speed, **lateral))


def turning_steps(bank, speed, seconds, dt_s=0.02):
    """A steady coordinated turn to the right: true attitudes, and the readings that go with them."""
    rate = G_MPS2 * np.tan(bank) / speed
    truth, steps = [], []
    for k in range(round(seconds / dt_s)):
        yaw = rate * (k + 1) * dt_s
        q = q_from_euler(bank, 0.0, yaw)
        gyro = (0.0, rate * sin(bank), rate * cos(bank))
        accel = (0.0, 0.0, -G_MPS2 / cos(bank))
        truth.append(q)
        steps.append((reading(gyro, accel, rotate_back(q, FIELD)), moving(speed)))
    return truth, steps


# --- what it is for -----------------------------------------------------------------------------------------------


def test_a_long_banked_turn_leaves_it_level_where_gradient_descent_leans():
    truth, steps = turning_steps(radians(40.0), 22.0, 60.0)
    start = q_from_euler(radians(40.0), 0.0, 0.0)
    leveling, leaning = (
        run(Leveling(), steps, q=start),
        run(GradientDescent(), steps, GradientDescent().initial(Start(start, ZERO, North.MAGNETIC, REST, None))),
    )
    assert tilt_between(leveling.q_nb, truth[-1]) < radians(0.1)
    assert abs(heading_between(leveling.q_nb, truth[-1])) < radians(1.0)
    assert tilt_between(leaning.q_nb, truth[-1]) > radians(8.0)


def test_it_finds_the_level_when_started_in_the_middle_of_a_turn():
    """The start takes the specific force for gravity, as an alignment in flight must: it is wrong by the bank."""
    truth, steps = turning_steps(radians(40.0), 22.0, 20.0)
    state = started(Leveling(), at_rest=False)
    errors = []
    for q, (sample, inputs) in zip(truth, steps, strict=True):
        state = Leveling().step(state, 0.02, sample, inputs)
        errors.append(tilt_between(state.q_nb, q))
    assert errors[0] > radians(30.0)
    assert max(errors[500:]) < radians(2.0)
    assert errors[-1] < radians(0.5)


def test_forward_acceleration_is_not_taken_for_pitch():
    """10 s at 3 m/s^2: the specific force points 17 degrees off; the speed explains it."""
    steps = [(reading(accel=(3.0, 0.0, -G_MPS2)), moving(3.0 * 0.02 * (k + 1))) for k in range(500)]
    assert tilt_between(run(Leveling(), steps).q_nb, ONE) < radians(0.1)
    no_speed = [(sample, STANDING) for sample, _ in steps]
    assert tilt_between(run(Leveling(), no_speed).q_nb, ONE) > radians(10.0)


@pytest.mark.parametrize(("roll", "pitch"), [(0.5, 0.0), (-1.5, 1.0), (3.0, 0.3), (0.0, -1.5)])
def test_at_rest_it_levels_from_any_start(roll, pitch):
    truth = q_from_euler(0.2, -0.1, 0.0)
    still = reading(accel=rotate_back(truth, REST), mag=None)
    state = run(Leveling(p0_down=1.0, r_length=0.7), [(still, STANDING)] * 500, q=q_from_euler(roll, pitch, 0.0))
    assert tilt_between(state.q_nb, truth) < radians(0.05)


def test_sideways_motion_is_used_when_it_is_known_and_left_alone_when_not():
    """A copter that accelerates to its right with its nose ahead: V_y grows; a filter that believes V_y = 0 leans."""

    def steps(side):
        return [(reading(accel=(0.0, 1.0, -G_MPS2)), moving(0.0, side=side(0.02 * (k + 1)))) for k in range(300)]

    known = run(Leveling(), steps(lambda t: t))
    assumed = run(Leveling(), steps(lambda _: 0.0))
    unknown = run(Leveling(), steps(lambda _: nan))
    assert tilt_between(known.q_nb, ONE) < radians(0.05)
    assert tilt_between(assumed.q_nb, ONE) > radians(3.0)
    assert isnan(unknown.velocity_fusion.residual[1])
    assert unknown.velocity_fusion.residual[2] == pytest.approx(0.0)
    assert unknown.level.velocity[1] == pytest.approx(6.0, rel=0.05)


# --- measurement models -------------------------------------------------------------------------------------------


def test_the_first_speed_starts_the_velocity_without_touching_the_attitude():
    tilted = q_from_euler(0.1, -0.1, 0.0)
    before = run(Leveling(), [(reading(), NO_INPUTS)] * 20, q=tilted)
    after = Leveling().step(before, 0.02, reading(), moving(25.0))
    assert after.velocity_model.moving
    assert after.level.velocity == pytest.approx((25.0, 0.0, 0.0), abs=0.01)
    assert tilt_between(after.q_nb, before.q_nb) < radians(0.1)


def test_a_sensor_that_shows_wind_at_rest_does_not_tilt_when_the_vehicle_starts_to_move():
    standing = run(Leveling(), [(reading(), replace_aids(moving(8.0), stationary=True))] * 500)
    assert standing.level.velocity == pytest.approx(ZERO, abs=1e-3)
    rolling = run(Leveling(), [(reading(), moving(8.0))] * 100, standing)
    assert tilt_between(rolling.q_nb, ONE) < radians(0.1)
    again = run(Leveling(), [(reading(), replace_aids(moving(8.0), stationary=True))] * 100, rolling)
    assert tilt_between(again.q_nb, ONE) < radians(0.1)


def replace_aids(inputs, stationary):
    return FilterInputs(inputs.body_velocity, stationary)


def test_without_any_speed_it_levels_by_the_mean_specific_force():
    """A minute of swinging about level, 3 m/s^2 to and fro: the mean shows gravity. Then a speed comes, and rules."""
    swing = [(reading(accel=(3.0 * sin(0.02 * k * 2.0), 0.0, -G_MPS2)), NO_INPUTS) for k in range(3000)]
    state = run(Leveling(), swing, q=q_from_euler(0.2, 0.2, 0.0))
    assert tilt_between(state.q_nb, ONE) < radians(2.0)
    assert not state.velocity_model.moving
    aided = run(Leveling(), [(reading(), moving(30.0))] * 100, state)
    assert aided.velocity_model.moving
    assert tilt_between(aided.q_nb, state.q_nb) < radians(2.0)


def test_rows_with_an_infinite_variance_are_left_out():
    state = run(Leveling(r_unaided=inf, r_sideslip=inf), [(reading(), NO_INPUTS), (reading(), moving(5.0))] * 20)
    assert q_norm(state.q_nb) == pytest.approx(1.0)
    assert isnan(state.velocity_fusion.residual[1])
    assert state.level.velocity[0] == pytest.approx(5.0, abs=0.1)


def test_a_vehicle_whose_speed_is_lost_is_taken_to_keep_it():
    """Half a minute without a speed, half of it in a turn; then the speed is back, and different."""
    _, turn = turning_steps(radians(20.0), 30.0, 15.0)
    cruising = run(Leveling(), [(reading(), moving(30.0))] * 200)
    straight = run(Leveling(), [(reading(), NO_INPUTS)] * 750, cruising)
    assert tilt_between(straight.q_nb, ONE) < radians(0.1)
    banked = q_mul(straight.q_nb, q_from_euler(radians(20.0), 0.0, 0.0))
    lost = run(Leveling(), [(reading((radians(20.0), 0.0, 0.0)), NO_INPUTS)] * 50, straight)
    lost = run(Leveling(), [(sample, NO_INPUTS) for sample, _ in turn], lost)
    assert tilt_between(lost.q_nb, banked) < radians(1.0)
    found = run(Leveling(), turning_steps(radians(20.0), 26.0, 5.0)[1], lost)
    assert tilt_between(found.q_nb, banked) < radians(1.0)


def test_only_a_fresh_speed_is_a_reading():
    state = run(Leveling(), [(reading(), moving(5.0))] * 10)
    stale = Leveling().step(state, 0.02, reading(), FilterInputs(BodyVelocity(50.0, is_new=False)))
    assert stale.velocity_fusion is None
    assert stale.level.velocity[0] == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize("speed", [nan, inf, -inf, 1e9])
def test_a_senseless_speed_is_not_used(speed):
    state = run(Leveling(), [(reading(), moving(speed))] * 10)
    assert not state.velocity_model.moving
    assert state.q_nb == pytest.approx(ONE)


def test_constraint_rows_come_at_their_spacing():
    state, used = started(Leveling()), []
    for _ in range(20):
        state = Leveling().step(state, 0.01, reading(), STANDING)
        used.append(state.length_fusion is not None)
    assert used == [k % 5 == 0 for k in range(20)]


def test_the_length_row_is_loose_until_the_level_is_found():
    """A tight one from the start makes some of these starts diverge."""

    def pull(r_length):
        """How much one unit-length row takes off a down vector that is ten percent too long."""
        filter_ = Leveling(p0_down=1.0, r_length_start=0.7, r_length=r_length)
        found = run(filter_, [(reading(), STANDING)] * 200)
        loose, tight = (filter_.step(state, 0.02, reading(), STANDING) for state in (started(filter_), found))
        return loose.level.p_dd[2][2], tight.level.p_dd[2][2]

    assert pull(0.1)[0] == pull(0.01)[0]
    assert pull(0.1)[1] > pull(1e-6)[1]


# --- heading ------------------------------------------------------------------------------------------------------


def test_the_heading_follows_the_field_with_its_time_constant():
    state = run(Leveling(), [(reading(), STANDING)] * 250, q=q_heading(radians(20.0)))
    assert heading_between(state.q_nb, ONE) == pytest.approx(radians(20.0) * exp(-1.0), rel=0.01)
    assert state.mag_used


def test_without_a_field_the_heading_is_relative_and_turns_with_the_gyro():
    turning = reading((0.0, 0.0, radians(9.0)), mag=None)
    state = run(Leveling(), [(turning, STANDING)] * 500, started(Leveling(), north=North.RELATIVE))
    assert heading_between(state.q_nb, ONE) == pytest.approx(radians(90.0), abs=1e-6)
    assert not state.north.known
    assert not state.mag_used
    assert state.heading_sigma > started(Leveling()).heading_sigma


def test_the_first_field_after_a_start_without_one_sets_the_heading():
    state = Leveling().step(started(Leveling(), q_heading(2.0), North.RELATIVE), 0.02, reading(), STANDING)
    assert abs(heading_between(state.q_nb, ONE)) < 1e-9
    assert not state.north.known
    assert run(Leveling(), [(reading(), STANDING)] * 50, state).north.known


def test_a_start_in_motion_takes_its_heading_when_the_level_is_found():
    """The alignment's heading was levelled by a down direction 40 degrees off."""
    truth, steps = turning_steps(radians(40.0), 22.0, 5.0)
    state = run(Leveling(), steps, started(Leveling(), q_heading(1.0), at_rest=False))
    assert abs(heading_between(state.q_nb, truth[-1])) < radians(3.0)
    assert state.north.known


def test_a_supplied_heading_is_taken_as_it_is():
    state = Leveling().step(started(Leveling()), 0.02, reading(), FilterInputs(stationary=True, heading=-2.0))
    assert heading_between(state.q_nb, ONE) == pytest.approx(-2.0)


def test_the_earth_is_not_taken_for_a_turn():
    """At rest for ten minutes with a perfect gyro: with the latitude no heading is lost, without it two degrees are."""
    latitude = radians(60.0)
    earth = rotate_back(ONE, (7.292115e-5 * cos(latitude), 0.0, -7.292115e-5 * sin(latitude)))
    still = reading(earth, mag=None)
    corrected = run(Leveling(), [(still, FilterInputs(stationary=True, latitude=latitude))] * 6000, dt_s=0.1)
    ignored = run(Leveling(), [(still, STANDING)] * 6000, dt_s=0.1)
    assert abs(heading_between(corrected.q_nb, ONE)) < radians(0.01)
    assert degrees(heading_between(ignored.q_nb, ONE)) == pytest.approx(-2.17, abs=0.05)


# --- readings that are missing or bad -----------------------------------------------------------------------------


@pytest.mark.parametrize("accel", [(nan, 0.0, -9.8), (inf, 0.0, 0.0), ZERO, (1e200, 0.0, 0.0)])
def test_without_an_accelerometer_it_turns_with_the_gyro_and_says_so(accel):
    before = run(Leveling(), [(reading(), moving(10.0))] * 100)
    after = run(Leveling(), [(reading((0.1, 0.0, 0.0), accel, None), NO_INPUTS)] * 50, before)
    assert not after.accel_used
    assert q_to_euler(after.q_nb)[0] == pytest.approx(0.1, abs=1e-3)
    assert after.level.p_vv[0][0] > before.level.p_vv[0][0] + 0.5


@pytest.mark.parametrize("gyro", [(nan, 0.0, 0.0), (inf, 0.0, 0.0), (1e200, 1e200, 0.0)])
def test_a_senseless_gyro_holds_everything(gyro):
    before = run(Leveling(), [(reading((0.1, 0.2, 0.3)), moving(10.0))] * 20)
    after = Leveling().step(before, 0.02, reading(gyro), moving(10.0))
    assert after.q_nb == before.q_nb
    assert after.level.p_dd == before.level.p_dd
    assert not after.accel_used


@pytest.mark.parametrize("mag", [(nan, 0.2, 0.3), (inf, 0.0, 0.0), ZERO, (0.001, 0.0, 0.5)])
def test_a_field_that_shows_no_heading_is_not_used(mag):
    state = run(Leveling(), [(reading(mag=mag), STANDING)] * 3, q=q_heading(1.0))
    assert not state.mag_used
    assert heading_between(state.q_nb, ONE) == pytest.approx(1.0)


def test_saturation_widens_the_covariance_tenfold():
    before = run(Leveling(), [(reading(), STANDING)] * 100)
    usual, saturated = (Leveling().step(before, 0.02, reading(saturated=flag), NO_INPUTS) for flag in (False, True))
    grown = [after.level.p_dd[1][1] - before.level.p_dd[1][1] for after in (usual, saturated)]
    assert grown[1] == pytest.approx(10.0 * grown[0], rel=0.05)


def test_a_long_gap_is_taken_in_parts():
    """0.9 s of a fast turn in one step, against the same in steps of 20 ms."""
    fast = reading((1.0, -2.0, 3.0), (1.0, 2.0, -9.0), None)
    once = run(Leveling(spacing_s=inf), [(fast, NO_INPUTS)], dt_s=0.9)
    often = run(Leveling(spacing_s=inf), [(fast, NO_INPUTS)] * 45, dt_s=0.02)
    assert tuple(-x for x in once.q_nb) == pytest.approx(often.q_nb, abs=1e-12)  # the same attitude: 2.7 rad round
    assert once.level.velocity == pytest.approx(often.level.velocity, abs=1e-10)
    assert np.array(once.level.p_vd) == pytest.approx(np.array(often.level.p_vd), rel=1e-9)


def test_a_broken_covariance_asks_for_a_new_start():
    assert isnan(q_norm(run(Leveling(p0_down=inf), [(reading(), STANDING)]).q_nb))


# --- properties ---------------------------------------------------------------------------------------------------

numbers = st.floats(allow_nan=True, allow_infinity=True)
vectors = st.one_of(
    st.tuples(*[st.floats(-50.0, 50.0)] * 3), st.tuples(numbers, numbers, numbers), st.just(REST), st.just(ZERO)
)
speeds = st.one_of(st.floats(-50.0, 50.0), numbers)
velocities = st.builds(BodyVelocity, speeds, speeds, speeds, st.booleans(), st.booleans())
aids_of = st.builds(
    FilterInputs,
    body_velocity=st.one_of(st.none(), velocities),
    stationary=st.booleans(),
    latitude=st.one_of(st.just(nan), st.floats(-1.5, 1.5)),
    declination=st.one_of(st.just(nan), st.floats(-3.0, 3.0)),
    heading=st.one_of(st.none(), numbers),
)


@given(st.lists(st.tuples(vectors, vectors, vectors, aids_of, st.floats(1e-4, 1.0), st.booleans()), max_size=25))
@settings(derandomize=True, max_examples=150, deadline=None)
def test_whatever_comes_the_state_stays_sound_or_asks_for_a_start(readings):
    filter_ = Leveling()
    state = started(filter_)
    for gyro, accel, mag, inputs, dt_s, saturated in readings:
        state = filter_.step(state, dt_s, reading(gyro, accel, mag, saturated), inputs)
        if isnan(q_norm(state.q_nb)):
            return
        assert q_norm(state.q_nb) == pytest.approx(1.0, abs=1e-12)
        x = state.level
        p = np.block([[np.array(x.p_vv), np.array(x.p_vd)], [np.array(x.p_vd).T, np.array(x.p_dd)]])
        assert (p == p.T).all()
        assert p.diagonal().min() >= 1e-12
        assert np.linalg.eigvalsh(p).min() > -1e-9 * max(1.0, p.diagonal().max())
        assert 0.0 <= state.tilt_sigma <= pi
        assert 0.0 <= state.heading_sigma <= pi
        assert norm(state.north.direction) == pytest.approx(1.0)


def test_a_run_cut_in_two_is_the_whole_run_bit_for_bit():
    rng = np.random.default_rng(4)
    gyro, force = rng.normal(0.0, 0.3, (400, 3)).tolist(), (rng.normal(0.0, 0.5, (400, 3)) + REST).tolist()
    steps = [
        (reading(tuple(g), tuple(f)), FilterInputs(BodyVelocity(4.0, is_new=k % 3 == 0), k > 300, 0.6, 0.1))
        for k, (g, f) in enumerate(zip(gyro, force, strict=True))
    ]
    whole, half = run(Leveling(), steps), run(Leveling(), steps[:150])
    other = run(replace(Leveling()), steps[150:], half)
    for name in ("velocity", "down", "p_vv", "p_vd", "p_dd"):
        assert getattr(other.level, name) == getattr(whole.level, name)
    assert (other.q_nb, other.since_update_s, other.north.variance) == (
        whole.q_nb,
        whole.since_update_s,
        whole.north.variance,
    )


def test_the_sigma_of_the_tilt_is_honest_on_noise_that_fits():
    """A straight and level run; noise of gyro, accelerometer and speed as large as the filter is told."""
    filter_ = Leveling(q_velocity=1e-3, q_down=1e-5, r_sideslip=0.09, r_length=0.7, p0_down=0.05)
    dt_s, ratios = 0.02, []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        start = q_mul(q_from_euler(*rng.normal(0.0, 0.1, 2).tolist(), 0.0), ONE)
        gyro = rng.normal(0.0, (1e-5 / dt_s) ** 0.5, (300, 3)).tolist()
        force = (rng.normal(0.0, (1e-3 / dt_s) ** 0.5, (300, 3)) + REST).tolist()
        speeds_, sides, downs = rng.normal(0.0, [[0.1], [0.3], [0.3]], (3, 300)).tolist()
        steps = [
            (reading(tuple(g), tuple(f), None), moving(10.0 + v, side=s, down=d))
            for g, f, v, s, d in zip(gyro, force, speeds_, sides, downs, strict=True)
        ]
        state = run(filter_, steps, q=start)
        ratios.append(tilt_between(state.q_nb, ONE) / state.tilt_sigma)
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.4
