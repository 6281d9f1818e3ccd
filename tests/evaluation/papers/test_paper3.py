"""The scenarios of paper 3: the vehicle's mechanics are exact, and the figures come out."""

from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from attest_mav.evaluation.papers.paper3 import (
    LOOSE_LENGTH,
    NAVIGATION,
    NO_BIASES,
    PAPER,
    Trial,
    covariance_setting,
    down_sigma,
    ensemble,
    final_figures,
    run_trial,
)
from attest_mav.evaluation.papers.scenarios import select
from attest_mav.evaluation.papers.underwater import (
    DEG_PER_HOUR,
    GRAVITY,
    STANDING,
    STRAIGHT,
    WINDING,
    WINDING_LEVEL,
    Sensors,
    Setting,
    angle_errors,
    course_angles,
    states,
    voyage,
)
from attest_mav.runtime.processes import processes

PERFECT = Sensors((0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def trial_map():
    with processes(1) as mapped:
        yield mapped


def test_with_perfect_sensors_and_start_the_filter_stays_at_the_truth():
    """Turning, pitching, on a turning Earth: any slip in rates, Coriolis or gravity would show."""
    setting = Setting(sensors=PERFECT, start_deg=0.0)
    run = voyage(setting, np.random.default_rng(1))
    after = states(LOOSE_LENGTH, run)
    assert np.abs(angle_errors(after, run.truth)).max() < 1e-4
    assert np.array([state.level.velocity for state in after])[-1] == pytest.approx([4.0, 0.0, 0.0], abs=1e-3)


def test_the_winding_course_turns_and_pitches_as_specified():
    t = np.arange(0.0, 50.0, 0.01)
    roll, pitch, yaw = np.degrees(course_angles(WINDING, t)).T
    assert not roll.any()
    assert pitch.max() == pytest.approx(3.0, abs=1e-3)
    assert np.gradient(yaw, t).max() == pytest.approx(8.6, rel=1e-3)
    assert yaw[-1] == pytest.approx(0.0, abs=0.1)


def test_a_standing_vehicle_feels_gravity_and_the_earth():
    run = voyage(Setting(course=STANDING, sensors=PERFECT, stationary=True), np.random.default_rng(1))
    assert run.samples[0].accel == pytest.approx((0.0, 0.0, -GRAVITY), abs=1e-12)
    assert degrees(np.linalg.norm(run.samples[0].gyro)) * 3600.0 == pytest.approx(15.04, abs=0.01)


def test_sensor_errors_are_those_of_the_paper():
    setting = Setting(course=STANDING, stationary=True)
    clean = voyage(replace(setting, sensors=PERFECT), np.random.default_rng(1))
    run = voyage(setting, np.random.default_rng(1))
    gyro = (np.array([s.gyro for s in run.samples]) - clean.samples[0].gyro) / DEG_PER_HOUR
    accel = (np.array([s.accel for s in run.samples]) - clean.samples[0].accel) / GRAVITY * 1e3
    speed = np.array([inputs.body_velocity.forward for inputs in run.inputs])
    assert gyro.mean(axis=0) == pytest.approx([1.0] * 3, abs=0.03)
    assert gyro.std(axis=0) == pytest.approx([0.3] * 3, rel=0.05)
    assert accel.mean(axis=0) == pytest.approx([1.0] * 3, abs=0.005)
    assert accel.std(axis=0) == pytest.approx([0.05] * 3, rel=0.05)
    assert (speed.mean(), speed.std()) == (pytest.approx(0.1, abs=0.01), pytest.approx(0.1, rel=0.05))
    assert [inputs.body_velocity.is_new for inputs in run.inputs[:6]] == [True, False, False, False, False, True]


def test_starts_are_wrong_by_45_degrees_and_pitch_no_further_than_the_vertical():
    downs = [voyage(Setting(), np.random.default_rng([5, k])).start.q_nb for k in range(60)]
    pitches = np.degrees([np.arcsin(np.clip(2.0 * (q[0] * q[2] - q[1] * q[3]), -1.0, 1.0)) for q in downs])
    assert np.std(pitches) == pytest.approx(45.0, rel=0.25)
    rolls = [np.arctan2(2 * (q[0] * q[1] + q[2] * q[3]), 1 - 2 * (q[1] ** 2 + q[2] ** 2)) for q in downs]
    assert np.std(np.degrees(rolls)) == pytest.approx(45.0, rel=0.25)
    assert all(abs(q[3]) < 0.8 for q in downs)


def test_a_trial_depends_on_its_seed_and_its_number_alone():
    trial = Trial("paper", Setting(), 3, 1)
    assert (run_trial(trial) == run_trial(trial)).all()
    assert (run_trial(trial) != run_trial(replace(trial, run=2))).any()
    assert (run_trial(trial) != run_trial(replace(trial, seed=4))).any()


def test_the_number_of_processes_changes_nothing():
    """What a trial carries must survive the way to another process, compiled too."""
    (scenario,) = select(["P3-d"])
    with processes(2) as over_two, processes(1) as in_this_one:
        assert scenario.evaluate(2, 1, over_two) == scenario.evaluate(2, 1, in_this_one)


def test_figures_are_taken_over_the_runs_at_their_end():
    errors = np.zeros((4, 10, 3))
    errors[:, -1, 0], errors[:, -1, 1] = [1.0, 3.0, 1.0, 3.0], [-0.5, -0.5, -0.5, -0.5]
    assert final_figures(errors) == pytest.approx(
        {"mean_roll_deg": 2.0, "mean_pitch_deg": -0.5, "std_roll_deg": 1.0, "std_pitch_deg": 0.0, "worst_deg": 3.0}
    )


@pytest.mark.parametrize(
    ("course", "stationary", "at_5_s", "at_30_s"),
    [
        pytest.param(STANDING, True, (0.0007, 0.0007, 0.0007), (0.0002, 0.0002, 0.0002), id="standing"),
        pytest.param(STRAIGHT, False, (0.0008, 0.905, 0.042), (0.0003, 0.158, 0.019), id="straight"),
        pytest.param(STANDING, False, (0.0008, 0.905, 0.042), (0.0003, 0.158, 0.019), id="standing, moving model"),
        pytest.param(WINDING_LEVEL, False, (0.0048, 0.0142, 0.041), (0.0003, 0.0005, 0.017), id="winding, level"),
        pytest.param(WINDING, False, (0.0048, 0.0159, 0.038), (0.0003, 0.0007, 0.0024), id="winding and pitching"),
    ],
)
def test_covariances_are_the_published_ones(course, stationary, at_5_s, at_30_s):
    """The paper's claim: at rest all is seen at once, a straight run leaves roll open, turning closes it."""
    sigma = down_sigma(LOOSE_LENGTH, covariance_setting(course, stationary=stationary))
    assert sigma[499] == pytest.approx(at_5_s, rel=0.05, abs=6e-5)
    # What a straight run shows of roll comes through the noise that the unit-length row picks up.
    assert sigma[-1] == pytest.approx(at_30_s, rel=0.12, abs=6e-5)


def test_few_runs_come_near_the_figures(trial_map):
    winding = final_figures(ensemble("no sideslip", Setting(), 6, 1, trial_map))
    assert winding["mean_roll_deg"] == pytest.approx(0.0245, abs=0.003)
    assert winding["mean_pitch_deg"] == pytest.approx(0.036, abs=0.004)
    unbiased = final_figures(ensemble("no sideslip", Setting(sensors=NO_BIASES), 4, 1, trial_map))
    assert abs(unbiased["mean_roll_deg"]) < 0.004


@pytest.mark.parametrize("name", ["P3-d", "P3-e", "P3-g"])
def test_few_runs_are_within_the_bounds(name, trial_map):
    (scenario,) = select([name])
    outcome = scenario.evaluate(4, 1, trial_map)
    assert outcome.passed, outcome.measured


def test_the_tunings_are_those_of_the_specification():
    assert (PAPER.q_velocity, PAPER.q_down, PAPER.r_speed, PAPER.r_length, PAPER.p0_down) == (
        1e-5,
        3e-9,
        0.01,
        0.5,
        1.0,
    )
    assert (NAVIGATION.r_sideslip, NAVIGATION.r_length_start, NAVIGATION.r_length) == (0.09, 0.7, 0.1)
    assert radians(1.0) / 3600.0 == pytest.approx(DEG_PER_HOUR)
    assert [scenario.id for scenario in select(["P3"])] == [f"P3-{letter}" for letter in "abcdefg"]
