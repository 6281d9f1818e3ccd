"""The scenarios of paper 1: their conditions are those of the specification, and their figures come out."""

from math import degrees, radians

import numpy as np
import pytest

from attest_mav.evaluation.papers import paper1
from attest_mav.evaluation.papers.paper1 import (
    ERRORS,
    HANDHELD,
    NO_BIAS,
    PLATFORM,
    Trial,
    handled,
    lowest_at,
    run_trial,
)
from attest_mav.evaluation.papers.scenarios import select
from attest_mav.runtime.processes import processes
from attest_mav.types import G_MPS2


@pytest.fixture(scope="module")
def trial_map():
    with processes(1) as mapped:
        yield mapped


def test_sensor_errors_are_those_of_the_paper():
    assert degrees(ERRORS.gyro_noise) == pytest.approx(0.06)
    assert degrees(ERRORS.gyro_bias) == pytest.approx(0.15)
    assert pytest.approx(0.004 * G_MPS2) == ERRORS.accel_noise
    assert ERRORS.mag_noise == 0.008
    assert (NO_BIAS.gyro_bias, NO_BIAS.gyro_noise) == (0.0, ERRORS.gyro_noise)


def test_the_platform_turns_slowly_and_is_not_accelerated():
    truth = handled(PLATFORM, np.random.default_rng(1))
    assert len(truth.q_nb) == 12_000
    assert truth.dt_s == pytest.approx(0.01)
    assert np.linalg.norm(truth.force, axis=1) == pytest.approx(np.full(12_000, G_MPS2))
    # Amplitude times 2 pi / period of roll, pitch and yaw, if all come together.
    assert np.linalg.norm(truth.rate, axis=1).max() < radians(3.0 + 3.0 + 3.2)


def test_a_hand_shakes():
    truth = handled(HANDHELD, np.random.default_rng(1))
    assert np.linalg.norm(truth.rate, axis=1).max() > radians(50.0)
    spread = np.linalg.norm(truth.force, axis=1).std()
    # Mostly the acceleration along gravity counts: one axis of 0.7 m/s^2.
    assert spread == pytest.approx(0.7, rel=0.15)


def test_a_trial_depends_on_its_seed_and_its_number_alone():
    trial = Trial(PLATFORM, ERRORS, (0.05,), 3, 1)
    assert run_trial(trial) == run_trial(trial)
    assert run_trial(trial) != run_trial(Trial(PLATFORM, ERRORS, (0.05,), 3, 2))
    assert run_trial(trial) != run_trial(Trial(PLATFORM, ERRORS, (0.05,), 4, 1))
    assert run_trial(trial) == run_trial(Trial(PLATFORM, ERRORS, (0.5, 0.05), 3, 1))[1:]


def test_the_number_of_processes_changes_nothing():
    (scenario,) = select(["P1-g"])
    with processes(2) as over_two, processes(1) as in_this_one:
        assert scenario.evaluate(2, 1, over_two) == scenario.evaluate(2, 1, in_this_one)


def test_the_lowest_point_is_the_bottom_of_the_parabola():
    betas = (0.01, 0.02, 0.05, 0.1)
    totals = [(np.log(beta) - np.log(0.03)) ** 2 + 0.2 for beta in betas]
    assert lowest_at(betas, totals) == pytest.approx(0.03)
    assert lowest_at(betas, [4.0, 3.0, 2.0, 1.0]) == 0.1
    assert lowest_at(betas, [1.0, 2.0, 3.0, 4.0]) == 0.01


@pytest.mark.parametrize("name", ["P1-a", "P1-b", "P1-c", "P1-d", "P1-f", "P1-g"])
def test_a_scenario_is_within_its_bounds(name, trial_map):
    """Five runs, as the bounds were set for; P1-e takes 70 runs of the filter and is left to the command."""
    (scenario,) = select([name])
    outcome = scenario.evaluate(5, 1, trial_map)
    assert outcome.passed, outcome.measured


def test_all_of_the_paper_is_covered():
    assert [scenario.id for scenario in paper1.SCENARIOS] == [f"P1-{letter}" for letter in "abcdefg"]
