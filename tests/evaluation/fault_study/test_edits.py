"""Faults put into samples: at their time, in whole counts, and nothing else."""

import pytest

from attest_mav.evaluation.fault_study import edits
from attest_mav.evaluation.fault_study.edits import faulted
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import Quantum, VelocityOrigin

COUNTS = Quantum(1e-3, 9.80665e-3, 1e-3)
S = 1_000_000_000


@pytest.fixture
def samples():
    """Ten seconds of two sensors at 10 Hz and fixes at 5 Hz; the vehicle speeds up by 1 m/s each second."""
    made = []
    for k in range(100):
        t_ns = k * S // 10
        for source in ("RAW_IMU", "SCALED_IMU2"):
            gyro = (0.01 + 0.001 * k, 0.0, 0.0)
            made.append(ImuSample(source, 1, 1, t_ns, t_ns, gyro, (0.0, 0.0, -9.8), (0.2, 0.0, 0.4), quantum=COUNTS))
        if k % 2 == 0:
            v_ned = (0.1 * k, 0.0, 0.0)
            made.append(VelocitySample("GPS_RAW_INT", 1, 1, t_ns, t_ns, v_ned, False, VelocityOrigin.RECEIVER))
    return made


def of(samples, kind, source=None):
    return [sample for sample in samples if isinstance(sample, kind) and source in (None, sample.source)]


def test_a_step_is_on_one_sensor_and_between_its_times(samples):
    changed = faulted(samples, 2.0, 4.0, edits.gyro_step(["RAW_IMU"], (0.05, 0.0, 0.0)))
    before, after = of(samples, ImuSample, "RAW_IMU"), of(changed, ImuSample, "RAW_IMU")
    steps = [b.gyro[0] - a.gyro[0] for a, b in zip(before, after, strict=True)]
    assert steps[:20] == [0.0] * 20
    assert steps[20:40] == pytest.approx([0.05] * 20, abs=1.1e-3)
    assert steps[40:] == [0.0] * 60
    assert of(changed, ImuSample, "SCALED_IMU2") == of(samples, ImuSample, "SCALED_IMU2")


def test_readings_stay_whole_counts(samples):
    changed = faulted(samples, 0.0, 9.0, edits.gyro_scale(["RAW_IMU"], 1.5))
    counts = [sample.gyro[0] / COUNTS.gyro for sample in of(changed, ImuSample, "RAW_IMU")]
    assert counts == pytest.approx([round(count) for count in counts], abs=1e-6)


def test_a_frozen_sensor_repeats_itself_but_for_its_magnetometer(samples):
    changed = of(faulted(samples, 2.0, 4.0, edits.frozen(["RAW_IMU"])), ImuSample, "RAW_IMU")
    assert {sample.gyro for sample in changed[20:40]} == {changed[20].gyro}
    assert changed[41].gyro != changed[40].gyro


def test_an_accelerometer_that_is_stuck_shows_one_value(samples):
    changed = of(faulted(samples, 2.0, 4.0, edits.accel_stuck(["RAW_IMU"])), ImuSample, "RAW_IMU")
    assert len(set(changed[25].accel)) == 1


def test_a_late_receiver_tells_of_the_past(samples):
    changed = of(faulted(samples, 2.0, 9.0, edits.receiver_late(0.4)), VelocitySample)
    assert [fix.t_ns for fix in changed] == [fix.t_ns for fix in of(samples, VelocitySample)]
    assert changed[20].v_ned[0] == pytest.approx(4.0 - 0.4)


def test_a_ramp_begins_at_nothing(samples):
    changed = of(faulted(samples, 2.0, 9.0, edits.receiver_ramp((0.0, 0.5, 0.0))), VelocitySample)
    assert changed[10].v_ned[1] == 0.0
    assert changed[20].v_ned[1] == pytest.approx(1.0)


def test_a_receiver_that_is_off_is_silent(samples):
    changed = of(faulted(samples, 2.0, 4.0, edits.receiver_off()), VelocitySample)
    assert not [fix for fix in changed if 2.0 <= fix.t_ns / S < 4.0]
    assert len(changed) == 40


def test_noise_differs_from_fix_to_fix_and_is_the_same_each_time(samples):
    first = of(faulted(samples, 2.0, 9.0, edits.receiver_noise(1.0)), VelocitySample)
    again = of(faulted(samples, 2.0, 9.0, edits.receiver_noise(1.0)), VelocitySample)
    errors = {round(fix.v_ned[1], 6) for fix in first[10:40]}
    assert len(errors) == 30
    assert [fix.v_ned for fix in first] == [fix.v_ned for fix in again]


def test_all_compasses_are_off_alike(samples):
    changed = faulted(samples, 2.0, 4.0, edits.compass_offset((0.15, 0.0, 0.0)))
    fields = {sample.mag[0] for sample in of(changed, ImuSample) if 2.0 <= sample.t_ns / S < 4.0}
    assert len(fields) == 1
    assert fields.pop() == pytest.approx(0.35, abs=2e-3)
