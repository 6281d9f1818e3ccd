"""What is watched of one lane: dead sensors, the field, the fixes, and when there is doubt."""

from math import cos, sin

import pytest

from attest_mav.estimation.witness.dead_sensor import DeadSensor
from attest_mav.estimation.witness.doubt import Doubt
from attest_mav.estimation.witness.field_watch import FieldWatch
from attest_mav.estimation.witness.fix_stream import FixStream
from attest_mav.estimation.witness.naming import sensor_text
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import VelocityOrigin

DT = 0.02
S = 1_000_000_000


def imu(k, gyro, accel):
    return ImuSample("RAW_IMU", 1, 1, round(k * DT * S), 0, gyro, accel, None)


def fix(t_s, v_ned):
    return VelocitySample("GPS_RAW_INT", 1, 1, round(t_s * S), 0, v_ned, False, VelocityOrigin.RECEIVER)


def reasons(readings):
    dead = DeadSensor()
    found = []
    for k, (gyro, accel) in enumerate(readings):
        dead.take(imu(k, gyro, accel), DT)
        found.append(dead.reason)
    return found


def test_an_accelerometer_stuck_on_all_axes_is_dead_within_a_tenth_of_a_second():
    turning = [((0.1 + 0.001 * k, 0.0, 0.0), (5.0, 5.0, 5.0)) for k in range(6)]
    assert "stuck" in reasons(turning)[5]


def test_an_accelerometer_that_reads_nothing_is_dead():
    turning = [((0.1 + 0.001 * k, 0.0, 0.0), (0.0, 0.0, 0.0)) for k in range(6)]
    assert "nothing" in reasons(turning)[5]


def test_a_whole_sensor_that_repeats_a_turn_is_dead_and_one_at_rest_is_not():
    assert reasons([((0.1, 0.0, 0.0), (0.0, 0.1, -9.8))] * 20)[-1]
    assert not reasons([((0.001, 0.0, 0.0), (0.0, 0.1, -9.8))] * 200)[-1]


def test_a_sensor_that_comes_back_is_not_dead_any_more():
    stuck = [((0.1, 0.0, 0.0), (5.0, 5.0, 5.0))] * 6
    assert not reasons([*stuck, ((0.1, 0.0, 0.0), (0.0, 0.0, -9.8))])[-1]


def direction(angle):
    return (0.6 * cos(angle), 0.6 * sin(angle), 0.8)


def test_a_turned_field_is_seen_at_once_and_moves_the_mean_only_in_calm_times():
    watch = FieldWatch()
    for k in range(20):
        watch.take(direction(0.0), k * S // 10, calm=True)
    mean = watch.mean
    for k in range(20, 40):
        watch.take(direction(0.1), k * S // 10, calm=False)
    assert watch.mean == mean
    assert watch.residual == pytest.approx(0.06, abs=1e-3)
    assert watch.score == pytest.approx(4.0)


def test_a_residual_beyond_the_usual_moves_the_mean_only_after_a_time():
    watch = FieldWatch()
    for k in range(20):
        watch.take(direction(0.0), k * S // 10, calm=True)
    mean = watch.mean
    for k in range(20, 45):
        watch.take(direction(0.1), k * S // 10, calm=True)
    assert watch.mean == mean
    for k in range(45, 200):
        watch.take(direction(0.1), k * S // 10, calm=True)
    assert watch.residual < 0.01
    watch.take(direction(0.11), 20 * S, calm=True)
    assert watch.mean[1] > 0.05


def test_a_residual_of_the_usual_size_is_little_evidence():
    watch = FieldWatch()
    watch.take(direction(0.0), 0, calm=True)
    assert watch.score_of(0.006) == pytest.approx(0.0625)


def test_the_gate_is_a_multiple_of_what_is_usual_between_its_limits():
    stream = FixStream()
    assert stream.gate == 3.0
    for _ in range(300):
        stream.learn(1.0, (0.1, 0.0, 0.0))
    assert 7.0 < stream.gate < 8.0
    stream.expect(5.0)
    assert stream.gate == 12.0


def misfits(stream, values, learn=False):
    found = []
    for nis in values:
        stream.take(nis)
        if learn:
            stream.learn(nis, (0.1, 0.0, 0.0))
        found.append(stream.misfit)
    return found


def test_one_fix_is_off_beyond_the_gate_and_five_in_a_row_beyond_a_smaller_one():
    assert misfits(FixStream(), [0.1, 3.3])[-1] == pytest.approx(1.1)
    assert max(misfits(FixStream(), [0.1, 2.7, 0.1, 2.0, 0.1, 0.1, 2.7])) <= 1.0
    in_a_row = misfits(FixStream(), [1.2, 1.2, 1.2, 1.2, 1.2])
    assert in_a_row[3] == pytest.approx(0.4)
    assert in_a_row[4] == pytest.approx(1.2)


def test_what_was_off_in_a_row_is_forgotten_with_the_state():
    stream = FixStream()
    misfits(stream, [2.0] * 5)
    stream.forget_misfit()
    assert stream.misfit == 0.0


def test_noise_becomes_usual_and_a_drift_does_not():
    noisy, drifting = FixStream(), FixStream()
    misfits(noisy, [0.2, 0.9, 0.4, 0.7, 0.3] * 40, learn=True)
    assert noisy.usual_nis == pytest.approx(0.5, abs=0.1)
    assert misfits(noisy, [1.2] * 5)[-1] < 1.0
    misfits(drifting, [0.5, 1.0, 1.5, *[2.0] * 100], learn=True)
    assert drifting.usual_nis < 0.3


def test_a_fix_is_new_once_and_not_too_soon_after_another():
    stream = FixStream()
    still = (0.0, 0.0, 0.0)
    assert stream.is_new(fix(1.0, (3.0, 0.0, 0.0)), 0.19, still)
    assert not stream.is_new(fix(1.0, (3.0, 0.0, 0.0)), 0.19, still)
    assert not stream.is_new(fix(1.1, (3.1, 0.0, 0.0)), 0.19, still)
    assert stream.is_new(fix(1.2, (3.2, 0.0, 0.0)), 0.19, still)
    assert not stream.is_new(None, 0.19, still)


@pytest.mark.parametrize(("own_change", "frozen"), [(0.0, False), (0.05, True)])
def test_a_repeated_velocity_is_a_frozen_receiver_where_the_vehicle_accelerates(own_change, frozen):
    stream = FixStream()
    for k in range(6):
        stream.is_new(fix(0.2 * k, (3.0, 0.0, 0.0)), 0.19, (3.0 + own_change * k, 0.0, 0.0))
    assert stream.frozen is frozen


def test_doubt_after_a_fix_lasts_until_it_is_explained_or_for_a_time():
    doubt = Doubt()
    doubt.fix_contradicts(10 * S)
    assert doubt.active(10 * S + S // 2)
    assert not doubt.active(11 * S)
    doubt.fix_contradicts(12 * S)
    doubt.fix_is_explained()
    assert not doubt.active(12 * S)


def test_a_field_that_stays_off_is_doubted_once():
    doubt = Doubt()
    active = []
    for k in range(100):
        doubt.field_contradicts(k * S // 10)
        active.append(doubt.active(k * S // 10))
    assert active[0]
    assert not any(active[15:])
    doubt.field_contradicts(20 * S)
    assert doubt.active(20 * S)


def test_probation_ends_after_twenty_small_innovations_in_a_row():
    doubt = Doubt()
    doubt.begin_probation()
    for _ in range(19):
        doubt.fix_on_probation(0.05, 0.05, field_fits=True)
    doubt.fix_on_probation(1.0, 0.05, field_fits=True)
    for _ in range(19):
        doubt.fix_on_probation(0.05, 0.05, field_fits=True)
    assert doubt.active(0)
    doubt.fix_on_probation(0.05, 0.05, field_fits=True)
    assert not doubt.active(0)


def test_a_fault_is_named_by_sensor_axis_and_size():
    assert sensor_text((0.0, -0.0873, 0.0), (0.0, 0.0, 0.0)) == "gyro y -5.0 degrees per second off"
    assert sensor_text((0.0, 0.0, 0.0), (0.0, 0.05, 1.5)) == "accelerometer z +1.5 m/s^2 off"
    assert sensor_text((0.1, 0.1, 0.0), (0.0, 0.0, 0.0)).startswith("gyro 8.1 degrees per second off (")


@pytest.mark.parametrize(
    ("shares", "doubted"),
    [
        ((0.3, 0.69, 0.3, 0.69), False),  # noise: far, and never twice in a row
        ((0.3, 0.51, 0.51), True),
        ((0.3, 0.71), True),
    ],
)
def test_fixes_make_doubt_by_two_in_a_row_or_by_one_that_is_farther(shares, doubted):
    doubt = Doubt()
    for k, share in enumerate(shares):
        doubt.take_fix(share, k * S // 5)
    assert doubt.active((len(shares) - 1) * S // 5) == doubted
    assert not doubt.active(len(shares) * S // 5 + S)
