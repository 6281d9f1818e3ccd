from itertools import pairwise

import pytest

from attest_mav.evaluation.flight_study.edits import (
    WHOLE,
    between,
    decimated,
    restored,
    truncated,
    with_iron,
    without_velocity,
)
from attest_mav.samples import AirDataSample, AttitudeSample, ImuSample, PositionSample, VelocitySample

START_S = 5.0


def of(kind, samples):
    return [sample for sample in samples if isinstance(sample, kind)]


def seconds(samples):
    return [sample.t_ns * 1e-9 - START_S for sample in samples]


@pytest.mark.parametrize(("value", "sent"), [(2.7, 2.0), (-2.7, -2.0), (0.9, 0.0), (-0.9, 0.0), (3.0, 3.0)])
def test_messages_cut_off_toward_zero(value, sent):
    assert truncated(0.001 * value, 0.001) == pytest.approx(0.001 * sent, abs=1e-12)


@pytest.mark.parametrize("units", [-300, -2, -1, 1, 9, 1234])
def test_what_is_restored_is_cut_off_to_the_same_again(units):
    middle = restored(units * 0.001, 0.001)
    assert abs(middle) == pytest.approx(abs(units) * 0.001 + 0.0005)
    assert truncated(middle, 0.001) == pytest.approx(units * 0.001)


def test_zero_is_restored_as_zero():
    assert restored(0.0, 0.001) == 0.0


def test_the_whole_is_what_was_there(stream):
    assert WHOLE(stream, "RAW_IMU") == stream


def test_a_late_start_has_heard_nothing_before(stream):
    kept = between(stream, "RAW_IMU", from_s=4.0, to_s=7.0)
    times = seconds(of(ImuSample, kept))
    assert times[0] == pytest.approx(4.0)
    assert times[-1] == pytest.approx(7.0)
    assert min(seconds(of(VelocitySample, kept))) >= 4.0
    assert min(seconds(of(PositionSample, kept))) >= 4.0


def test_a_late_start_keeps_the_truth_just_before(stream):
    kept = between(stream, "RAW_IMU", from_s=4.0, to_s=7.0)
    assert min(seconds(of(AttitudeSample, kept))) == pytest.approx(3.0)


def test_withheld_fixes_are_withheld(stream):
    kept = without_velocity(stream, "RAW_IMU", from_s=4.0, to_s=6.0)
    for kind in (VelocitySample, PositionSample):
        times = seconds(of(kind, kept))
        assert not [t_s for t_s in times if 4.0 - 1e-9 <= t_s < 6.0 - 1e-9]
        assert len(times) == 40  # of 50 in 10 s, two seconds' worth is gone
    rest = [sample for sample in stream if not isinstance(sample, (VelocitySample, PositionSample))]
    assert [sample for sample in kept if not isinstance(sample, (VelocitySample, PositionSample))] == rest


def test_airspeed_is_withheld_only_when_that_is_wanted(stream):
    air = AirDataSample("VFR_HUD", 1, 1, stream[250].rx_ns, 20.0, 20.0, 0.0)
    samples = [*stream[:250], air, *stream[250:]]
    assert air in without_velocity(samples, "RAW_IMU", from_s=1.0, to_s=9.0)
    assert air not in without_velocity(samples, "RAW_IMU", from_s=1.0, to_s=9.0, airspeed=False)


@pytest.mark.parametrize(("rate_hz", "steps_s"), [(25.0, {0.04}), (10.0, {0.1}), (5.0, {0.2}), (4.0, {0.24, 0.26})])
def test_fewer_samples_keep_their_own_times_and_readings(stream, rate_hz, steps_s):
    kept = of(ImuSample, decimated(stream, "RAW_IMU", rate_hz=rate_hz))
    assert all(sample in stream for sample in kept)  # the very objects: these records compare by identity
    assert len(kept) == pytest.approx(10.0 * rate_hz, abs=1)
    assert {round(after - before, 6) for before, after in pairwise(seconds(kept))} <= steps_s


def test_fewer_samples_leave_all_else(stream):
    kept = decimated(stream, "RAW_IMU", rate_hz=5.0)
    assert [s for s in kept if not isinstance(s, ImuSample)] == [s for s in stream if not isinstance(s, ImuSample)]


def test_iron_moves_one_axis_for_its_time_only(stream):
    moved = of(ImuSample, with_iron(stream, "RAW_IMU", from_s=2.0, to_s=3.0, gauss=0.06))
    assert sum(sample.mag[0] == pytest.approx(0.26) for sample in moved) == 50
    assert {sample.mag[0] for sample in moved if not 2.0 <= sample.t_ns * 1e-9 - START_S < 3.0} == {0.2}
    assert {sample.mag[1:] for sample in moved} == {(0.0, 0.44)}
