"""The filter beside other people's filters on one simulated run: handheld motion, 100 Hz, 60 s."""

from math import degrees, radians, sqrt

import ahrs
import imufusion
import numpy as np
import pytest
import vqf

from attest_mav.algebra import heading_between, q_mul, tilt_between
from attest_mav.evaluation.motion import mean_rate, motion, times, waves
from attest_mav.evaluation.papers.paper1 import FIELD, HANDHELD, NO_BIAS
from attest_mav.evaluation.simulation import SensorErrors, imu_samples, run_filter
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North

DT_S = 0.01
SETTLED = 2000
"""Samples after which the others have found their attitude: they start from the readings, not from the truth."""

NED_OF_ENU = (0.0, sqrt(0.5), sqrt(0.5), 0.0)


@pytest.fixture(scope="module")
def truth():
    rng = np.random.default_rng(20)
    t = times(60.0, 1.0 / DT_S)
    angles = [waves(t, parts, rng) for parts in (HANDHELD.roll, HANDHELD.pitch, HANDHELD.yaw)]
    return motion(tuple(angles), np.zeros((len(t), 3)), DT_S)


@pytest.fixture(scope="module")
def perfect(truth):
    return imu_samples(truth, (FIELD.b_x, 0.0, FIELD.b_z), SensorErrors(), np.random.default_rng(21))


@pytest.fixture(scope="module")
def noisy(truth):
    return imu_samples(truth, (FIELD.b_x, 0.0, FIELD.b_z), NO_BIAS, np.random.default_rng(22))


def ours(truth, samples):
    return run_filter(GradientDescent(), truth.start, samples, DT_S).tolist()


def by_vqf(samples):
    """Without bias estimation and rejection of disturbances: what is left is what this filter does, too."""
    other = vqf.VQF(DT_S, motionBiasEstEnabled=False, restBiasEstEnabled=False, magDistRejectionEnabled=False)
    attitudes = []
    for sample in samples:
        other.update(np.array(sample.gyro), np.array(sample.accel), np.array(sample.mag))
        attitudes.append(q_mul(NED_OF_ENU, tuple(other.getQuat9D().tolist())))
    return attitudes


def by_imufusion(samples):
    """It takes the accelerometer at rest for +g along down."""
    other = imufusion.Ahrs()
    other.set_settings(imufusion.AhrsSettings(1.0 / DT_S, imufusion.CONVENTION_NED, 0.5, 2000.0, 0.0, 0.0, 0.0))
    attitudes = []
    for sample in samples:
        other.update(np.degrees(sample.gyro), -np.array(sample.accel) / G_MPS2, np.array(sample.mag))
        attitudes.append(tuple(map(float, other.get_quaternion())))
    return attitudes


def apart(a, b):
    """Differences of tilt and heading after settling, degrees, shape (n, 2)."""
    pairs = list(zip(a, b, strict=True))[SETTLED:]
    return np.degrees([(tilt_between(tuple(p), tuple(q)), heading_between(tuple(p), tuple(q))) for p, q in pairs])


def rms(columns):
    return np.sqrt(np.mean(np.square(columns), axis=0))


def test_the_printed_form_is_the_filter_of_ahrs(truth, noisy):
    """The same equations with the accelerometer's sign turned; nothing but rounding may differ."""
    beta, part = 0.033, noisy[:1000]
    other = ahrs.filters.Madgwick(frequency=1.0 / DT_S, gain=beta)
    q, theirs = np.array(truth.start), []
    for sample in part:
        q = other.updateMARG(q, np.array(sample.gyro), -np.array(sample.accel), np.array(sample.mag))
        theirs.append(q)
    printed = run_filter(GradientDescent(beta=beta, exponential=False), truth.start, part, DT_S)
    assert np.max(np.abs(printed - np.array(theirs))) < 1e-12


def test_perfect_sensors_give_the_truth(truth, perfect):
    """Rates are exact means and the turn is exact: no error can arise, and none be corrected."""
    assert np.max(apart(ours(truth, perfect), truth.q_nb.tolist())) < 1e-6


def test_the_printed_form_leads_the_truth_by_one_interval(truth, perfect):
    """It compares the attitude before the turn with readings after it, so it settles up to one turn ahead."""
    printed = run_filter(GradientDescent(beta=0.5, exponential=False), truth.start, perfect, DT_S)
    error = np.degrees(2.0 * np.linalg.norm((printed - truth.q_nb)[SETTLED:], axis=1))
    turn = np.degrees(DT_S * np.linalg.norm(truth.rate[SETTLED:], axis=1))
    assert np.mean(error) == pytest.approx(np.mean(turn), rel=0.2)


def test_vqf_agrees_on_perfect_sensors(truth, perfect):
    assert np.max(np.abs(apart(ours(truth, perfect), by_vqf(perfect)))) < 1e-3


def test_imufusion_agrees_on_perfect_sensors_to_one_interval(truth, perfect):
    """It, too, corrects before it turns, in single precision: it may lead by the largest turn in one interval."""
    largest_turn = degrees(DT_S * np.max(np.linalg.norm(truth.rate, axis=1)))
    assert np.max(np.abs(apart(ours(truth, perfect), by_imufusion(perfect)))) < 1.1 * largest_turn


@pytest.mark.parametrize("other", [by_vqf, by_imufusion])
def test_others_agree_on_noisy_sensors_better_than_the_readings_alone(truth, noisy, other):
    """One reading gives a tilt to 4 mg per axis and a heading to 0.008 of the field by its horizontal half.

    A filter of 10 s memory at 100 Hz must bring both well down; half is left to the rougher of the two.
    """
    tilt, heading = rms(apart(ours(truth, noisy), other(noisy)))
    assert tilt < 0.5 * degrees(0.004 * sqrt(2.0))
    assert heading < 0.5 * degrees(0.008 / FIELD.b_x)


def test_irregular_time_steps_and_a_gap_cost_nothing_with_the_exact_turn():
    """Intervals of 5 to 15 ms and a gap of a second while yawing at 1.2 rad/s, without magnetometer.

    Euler's rule turns by 2 atan(0.6) instead of 1.2 rad in the gap and is 6.8 degrees behind afterwards.
    """
    t = times(60.0, 1000.0)
    fine = motion((0.17 * np.sin(0.3 * t), 0.14 * np.sin(0.4 * t), 1.2 * t), np.zeros((len(t), 3)), 0.001)
    steps = np.random.default_rng(3).integers(5, 16, 5000)
    steps[2500] = 1000
    rows = np.cumsum(steps)
    q, dt_s = fine.q_nb[rows], np.diff(rows) * 0.001
    rates = mean_rate(q, 1.0) / dt_s[:, np.newaxis]
    assert peak_error(True, q, rates, fine.force[rows], dt_s) < radians(0.001)
    assert radians(6.0) < peak_error(False, q, rates, fine.force[rows], dt_s) < radians(8.0)


def peak_error(exact, q, rates, force, dt_s):
    """Largest heading error in the run, rad."""
    filter_ = GradientDescent(beta=0.05, exponential=exact)
    state = filter_.initial(Start(tuple(q[0].tolist()), (0.0, 0.0, 0.0), North.TRUE, (0.0, 0.0, -G_MPS2), None))
    worst = 0.0
    for k, step in enumerate(dt_s.tolist()):
        sample = ImuSample("RAW_IMU", 1, 1, 0, 0, tuple(rates[k].tolist()), tuple(force[k + 1].tolist()), None)
        state = filter_.step(state, step, sample, FilterInputs())
        worst = max(worst, abs(heading_between(state.q_nb, tuple(q[k + 1].tolist()))))
    return worst
