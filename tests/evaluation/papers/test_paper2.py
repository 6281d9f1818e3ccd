"""The scenarios of paper 2: the stand moves and errs as specified, and the figures come out."""

from dataclasses import replace
from math import degrees

import numpy as np
import pytest

from attest_mav.evaluation.papers import paper2
from attest_mav.evaluation.papers.paper2 import Trial, run_trial
from attest_mav.evaluation.papers.rotation_stand import (
    CLEAN,
    GROSS,
    LOGIC,
    MAGNETIC,
    PAPER_LEVEL,
    PLAIN,
    PRINTED,
    RECOMMENDED,
    ROBUST,
    SPARSE,
    WRONG_START,
    Setting,
    angle_errors,
    peaks,
    stand_run,
)
from attest_mav.evaluation.papers.scenarios import select
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
from attest_mav.runtime.processes import processes
from attest_mav.types import G_MPS2


@pytest.fixture(scope="module")
def trial_map():
    with processes(1) as mapped:
        yield mapped


def heading_errors(setting, seed=1):
    run = stand_run(setting, np.random.default_rng(seed))
    supplied = np.array([inputs.heading for inputs in run.inputs])
    return np.degrees((supplied - run.truth[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)


def test_the_stand_turns_as_far_and_as_slowly_as_specified():
    truth = np.degrees(stand_run(CLEAN, np.random.default_rng(1)).truth)
    assert len(truth) == 4000
    assert np.abs(truth).max(axis=0) == pytest.approx([45.0, 45.0, 180.0], abs=0.01)
    assert degrees(stand_run(PAPER_LEVEL, np.random.default_rng(1)).truth[:, 0].max()) == pytest.approx(5.0, abs=0.01)


def test_readings_without_contamination_have_the_noise_of_the_paper():
    run = stand_run(replace(CLEAN, amplitude_deg=0.0), np.random.default_rng(2))
    gyro = np.degrees([sample.gyro for sample in run.samples])
    accel = np.array([sample.accel for sample in run.samples]) / G_MPS2
    assert gyro[:, :2].std() == pytest.approx(0.05, rel=0.05)
    assert accel.mean(axis=0) == pytest.approx([0.0, 0.0, -1.0], abs=3e-4)
    assert accel.std(axis=0) == pytest.approx([0.004] * 3, rel=0.05)
    assert np.radians(heading_errors(CLEAN)).std() == pytest.approx(1e-3, rel=0.05)


def test_bursts_have_their_size_length_and_rate():
    hit = np.abs(heading_errors(SPARSE)) > 1.0
    begins = np.flatnonzero(hit[1:] & ~hit[:-1])
    lengths = [int(np.argmin(hit[k + 1 : k + 20])) for k in begins if hit[k + 1 : k + 4].all() and not hit[k + 4]]
    assert lengths
    assert set(lengths) == {3}
    assert np.abs(heading_errors(SPARSE)[hit]).min() == pytest.approx(3.5, abs=0.5)
    counts = [np.sum(np.abs(heading_errors(SPARSE, seed)) > 1.0) / 3 for seed in range(40)]
    assert np.mean(counts) == pytest.approx(0.4 * 40.0, rel=0.15)


def test_outliers_of_the_force_are_sideways_and_as_frequent_as_specified():
    shares = []
    for seed in range(10):
        run = stand_run(replace(GROSS, amplitude_deg=0.0), np.random.default_rng(seed))
        accel = np.array([sample.accel for sample in run.samples]) / G_MPS2
        assert np.abs(accel[:, 0]).max() < 0.03
        shares.append(np.mean(np.abs(accel[:, 1]) > 0.1))
    # 92 % of a normal distribution of 1 g lies beyond 0.1 g.
    assert np.mean(shares) == pytest.approx(0.03 * 0.92, rel=0.1)


def test_the_magnetic_setting_supplies_a_field_and_no_heading():
    run = stand_run(MAGNETIC, np.random.default_rng(1))
    assert all(inputs.heading is None for inputs in run.inputs)
    field = np.array([sample.mag for sample in run.samples])
    assert np.linalg.norm(field, axis=1).mean() == pytest.approx(1.0, abs=1e-3)
    assert stand_run(CLEAN, np.random.default_rng(1)).samples[0].mag is None


def test_a_wrong_start_is_wrong_in_heading_alone():
    run = stand_run(WRONG_START, np.random.default_rng(1))
    errors = angle_errors(RobustAdaptive(reacquire_s=1e9), run)
    assert np.abs(errors[:100, 2]) == pytest.approx(np.full(100, 30.0), abs=0.1)
    assert np.abs(errors[:100, :2]).max() < 0.3


def test_errors_are_wrapped_and_the_first_seconds_do_not_count():
    errors = np.zeros((4000, 3))
    errors[150], errors[2000] = 90.0, (1.0, -2.0, 0.5)
    assert peaks(errors) == pytest.approx([1.0, 2.0, 0.5])
    assert np.abs(angle_errors(RECOMMENDED, stand_run(CLEAN, np.random.default_rng(4)))).max() < 1.0


def test_variants_differ_from_the_paper_only_in_what_they_are_named_for():
    assert (PRINTED.c, PRINTED.r_accel, PRINTED.r_heading, PRINTED.q_step, PRINTED.p0) == (0.9, 1e-3, 1e-6, 1e-8, 1e-10)
    assert replace(ROBUST, adaptive=True) == PRINTED
    assert replace(PLAIN, adaptive=True, robust=True) == PRINTED
    noise = {"r_heading": 1e-6, "q_step": 1e-8, "p0": 1e-10, "gyro_noise": 0.0, "c": 0.9}
    assert replace(RobustAdaptive(), **noise) == LOGIC
    assert RobustAdaptive() == RECOMMENDED


def test_a_trial_depends_on_its_seed_and_its_number_alone():
    trial = Trial(SPARSE, ("recommended",), 3, 1)
    assert run_trial(trial) == run_trial(trial)
    assert run_trial(trial) != run_trial(replace(trial, run=2))
    assert run_trial(trial) != run_trial(replace(trial, seed=4))
    assert run_trial(replace(trial, variants=("plain", "recommended")))[1:] == run_trial(trial)


def test_the_number_of_processes_changes_nothing():
    """What a trial carries must survive the way to another process, compiled too."""
    (scenario,) = select(["P2-d"])
    with processes(2) as over_two, processes(1) as in_this_one:
        assert scenario.evaluate(2, 1, over_two) == scenario.evaluate(2, 1, in_this_one)


def test_recovery_is_the_end_of_the_last_large_heading_error():
    errors = np.zeros((4000, 3))
    errors[:751, 2] = 30.0
    assert paper2._last_off_s(errors[:, 2]) == pytest.approx(7.51)
    assert paper2._last_off_s(np.zeros(10)) == 0.0


@pytest.mark.parametrize("name", ["P2-a", "P2-d", "P2-e", "P2-f", "P2-g"])
def test_few_runs_are_within_the_bounds(name, trial_map):
    (scenario,) = select([name])
    outcome = scenario.evaluate(3, 1, trial_map)
    assert outcome.passed, outcome.measured


@pytest.mark.parametrize("name", ["P2-h", "P2-i"])
def test_equations_are_within_the_bounds(name, trial_map):
    (scenario,) = select([name])
    outcome = scenario.evaluate(100, 1, trial_map)
    assert outcome.passed, outcome.measured


def test_the_printed_filter_fails_where_its_parts_succeed(trial_map):
    campaign = paper2.Campaign(2, 1, trial_map)
    printed, robust, logic = campaign.results(GROSS, "printed", "robust", "logic")
    assert np.median(printed[:, 0]) > 5.0
    assert robust[:, :3].max() < 0.2
    assert logic[:, :3].max() < 0.2


def test_all_settings_are_those_of_the_specification():
    assert Setting(heading_deg=3.5, heading_rate_hz=0.4, heading_samples=3) == SPARSE
    assert (PAPER_LEVEL.side_g, PAPER_LEVEL.side_share, PAPER_LEVEL.heading_samples) == (1.25, 0.0107, 4)
    assert [scenario.id for scenario in select(["P2"])] == [f"P2-{letter}" for letter in "abcdefghi"]
