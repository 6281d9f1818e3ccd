from dataclasses import replace
from math import radians

import numpy as np
import pytest

from attest_mav.evaluation.flight_study.sensor_errors import SETS, SensorErrors, with_sensor_errors
from attest_mav.samples import ImuSample, PositionSample, VelocitySample

NONE = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def of(kind, samples):
    return [sample for sample in samples if isinstance(sample, kind)]


def with_errors(samples, seed=1, **errors):
    return with_sensor_errors(samples, "RAW_IMU", errors=replace(NONE, **errors), seed=seed)


def column(samples, name):
    return np.array([getattr(sample, name) for sample in of(ImuSample, samples)])


def test_no_errors_change_nothing(stream):
    after = with_errors(stream)
    for name in ("gyro", "accel", "mag"):
        assert column(after, name) == pytest.approx(column(stream, name), abs=1e-9)
    assert [sample.t_ns for sample in after] == [sample.t_ns for sample in stream]


def test_typical_sensors_are_twice_as_bad_as_good_ones():
    good, typical = SETS["good"], SETS["typical"]
    assert typical.gyro == pytest.approx(2.0 * good.gyro)
    assert typical.gyro_bias == pytest.approx(radians(0.4))
    assert typical.accel == pytest.approx(0.3)
    assert typical.accel_bias == pytest.approx(0.0980665)
    assert (typical.mag, typical.hard_iron, typical.latency_s) == (0.004, 0.010, 0.03)
    assert (typical.velocity, typical.velocity_correlated) == (0.1, 0.1)


def test_equal_seeds_give_equal_errors_and_others_do_not(stream):
    once, again, other = (
        column(with_sensor_errors(stream, "RAW_IMU", errors=SETS["poor"], seed=seed), "gyro") for seed in (3, 3, 4)
    )
    assert np.array_equal(once, again)
    assert not np.array_equal(once, other)


def test_readings_are_whole_units_again(stream):
    after = with_sensor_errors(stream, "RAW_IMU", errors=SETS["typical"], seed=1)
    for name, unit in (("gyro", 1e-3), ("accel", 9.80665e-3), ("mag", 1e-3)):
        units = column(after, name) / unit
        assert units == pytest.approx(np.round(units), abs=1e-6)


def test_biases_have_their_size_on_every_axis_and_signs_of_their_own(stream):
    signs = set()
    for seed in range(8):
        after = with_errors(stream, seed, gyro_bias=0.02, accel_bias=0.0980665, hard_iron=0.01)
        gyro = column(after, "gyro") - column(stream, "gyro")
        accel = column(after, "accel") - column(stream, "accel")
        mag = column(after, "mag") - column(stream, "mag")
        # Up to a unit goes where a reading of zero, which stands for itself, is moved and cut off.
        assert np.abs(gyro) == pytest.approx(np.full(gyro.shape, 0.02), abs=1.01e-3)
        assert np.abs(accel) == pytest.approx(np.full(accel.shape, 0.0980665), abs=1.01 * 9.80665e-3)
        assert np.abs(mag) == pytest.approx(np.full(mag.shape, 0.01), abs=1.01e-3)
        signs.add(tuple(np.sign(gyro[0])))
    assert len(signs) > 2


def test_white_errors_have_their_size(stream):
    after = with_errors(stream, gyro=0.05, accel=0.5)
    # 500 samples show a standard deviation to 3 %.
    assert np.std(column(after, "gyro"), axis=0) == pytest.approx(np.full(3, 0.05), rel=0.12)
    assert np.std(column(after, "accel"), axis=0) == pytest.approx(np.full(3, 0.5), rel=0.12)


def test_a_repeated_field_keeps_its_error_until_the_compass_reads_again(stream):
    field = column(with_errors(stream, mag=0.02), "mag")
    changes = np.any(np.diff(field, axis=0) != 0.0, axis=1)
    assert set(np.diff(np.flatnonzero(changes))) == {5}  # a reading every 100 ms, five samples


def test_a_fix_that_is_late_comes_and_is_stamped_later(stream):
    after = with_errors(stream, latency_s=0.03)
    for kind in (VelocitySample, PositionSample):
        late = [a.t_ns - b.t_ns for a, b in zip(of(kind, after), of(kind, stream), strict=True)]
        assert set(late) == {30_000_000}
    newest_ms = 0
    for sample in after:
        if isinstance(sample, ImuSample):
            newest_ms = sample.t_ns // 1_000_000
        elif isinstance(sample, VelocitySample):
            # Read at 0 ms it is due at 30; the samples of 0 and 20 have passed by then, that of 40 has not.
            assert newest_ms % 200 == 20


def test_velocity_errors_are_white_and_correlated(stream):
    fixes = of(VelocitySample, stream)
    white, slow = [], []
    for seed in range(40):
        for errors, found in (({"velocity": 0.2}, white), ({"velocity_correlated": 0.2}, slow)):
            after = of(VelocitySample, with_errors(fixes, seed, **errors))
            found.append([a.v_ned[0] - b.v_ned[0] for a, b in zip(after, fixes, strict=True)])
    assert np.std(white) == pytest.approx(0.2, rel=0.1)
    assert np.std(slow) == pytest.approx(0.2, rel=0.3)
    # From one fix to the next, 0.2 s, the correlated part keeps exp(-0.2 / 5) of itself.
    assert np.corrcoef(np.ravel(np.array(slow)[:, :-1]), np.ravel(np.array(slow)[:, 1:]))[0, 1] > 0.9
    assert abs(np.corrcoef(np.ravel(np.array(white)[:, :-1]), np.ravel(np.array(white)[:, 1:]))[0, 1]) < 0.1


def test_a_fix_that_is_sent_again_has_the_error_that_it_had(stream):
    fixes = [one for one in of(VelocitySample, stream) for _ in range(2)]
    after = with_errors(fixes, velocity=0.2, velocity_correlated=0.2)
    assert [one.v_ned for one in after[::2]] == [one.v_ned for one in after[1::2]]
    assert len({one.v_ned for one in after}) == len(after) // 2
