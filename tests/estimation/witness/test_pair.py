from math import radians

import numpy as np
import pytest

from attest_mav.estimation.witness.pair import Difference, PairedReading, RunningDifference, contrast

ZERO = (0.0, 0.0, 0.0)


@pytest.fixture
def differences():
    """Two seconds of differences at 50 Hz with a mean and a scatter of their own on each axis."""
    rng = np.random.default_rng(3)
    return [
        (20_000_000 * k, tuple(rng.normal([0.1, 0.0, -0.2], 0.01)), tuple(rng.normal([0.0, 1.0, 2.0], 0.3)))
        for k in range(100)
    ]


def test_mean_and_scatter_are_those_of_the_last_half_second(differences):
    running = RunningDifference(0.5)
    for t_ns, gyro, accel in differences:
        running.take(PairedReading(t_ns, gyro, accel))
    found = running.difference()
    gyros = np.array([gyro for _, gyro, _ in differences[-26:]])
    accels = np.array([accel for _, _, accel in differences[-26:]])
    assert found.count == 26
    assert found.gyro == pytest.approx(gyros.mean(axis=0))
    assert found.accel == pytest.approx(accels.mean(axis=0))
    assert found.accel_scatter == pytest.approx(accels.std(axis=0))


def test_nothing_is_compared_before_most_of_the_time_is_there(differences):
    running = RunningDifference(0.5)
    spans = []
    for t_ns, gyro, accel in differences[:30]:
        running.take(PairedReading(t_ns, gyro, accel))
        spans.append(running.spans)
    assert not any(spans[:20])
    assert all(spans[25:])


def test_a_clock_that_goes_back_begins_anew(differences):
    running = RunningDifference(0.5)
    for t_ns, gyro, accel in differences:
        running.take(PairedReading(t_ns, gyro, accel))
    running.take(PairedReading(0, (1.0, 0.0, 0.0), ZERO))
    assert running.difference().count == 1
    assert running.difference().gyro == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(("rate", "differs"), [(0.7, False), (0.9, True)])
def test_gyros_differ_beyond_their_biases(rate, differs):
    excess = (0.01 + radians(rate), 0.0, 0.0)
    found = contrast(Difference(excess, ZERO, ZERO, 25), (0.01, 0.0, 0.0), ZERO)
    assert found.gyros_differ is differs


def test_accelerometers_that_scatter_may_differ_by_more():
    quiet = Difference(ZERO, (0.8, 0.0, 0.0), (0.05, 0.05, 0.05), 25)
    shaken = Difference(ZERO, (0.8, 0.0, 0.0), (1.0, 1.0, 1.0), 25)
    assert contrast(quiet, ZERO, ZERO).accels_differ
    assert not contrast(shaken, ZERO, ZERO).accels_differ
