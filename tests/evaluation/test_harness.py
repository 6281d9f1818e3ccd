"""What an outcome says, which scenarios a name means, and that processes change nothing."""

import json
from math import inf, nan, sqrt

import pytest

from attest_mav.errors import UsageError
from attest_mav.evaluation.harness import Outcome, Scenario
from attest_mav.evaluation.papers.scenarios import all_scenarios, select
from attest_mav.runtime.processes import processes


def outcome(value, bounds=(1.0, 2.0)):
    return Outcome("P9-z", "a test", {"x": value, "free": 5.0}, {"x": bounds}, {"x": 1.4}, 7, 3)


@pytest.mark.parametrize(("value", "passed"), [(1.0, True), (2.0, True), (0.999, False), (2.001, False), (nan, False)])
def test_an_outcome_passes_within_its_bounds_only(value, passed):
    assert outcome(value).passed is passed


def test_the_record_has_the_keys_scripts_depend_on():
    assert outcome(1.5).as_json() == {
        "id": "P9-z",
        "measured": {"x": 1.5, "free": 5.0},
        "bounds": {"x": [1.0, 2.0]},
        "paper": {"x": 1.4},
        "runs": 7,
        "seed": 3,
        "pass": True,
    }


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_a_figure_that_is_no_number_is_null_and_a_miss(value):
    record = json.loads(json.dumps(outcome(value).as_json(), allow_nan=False))
    assert record["measured"]["x"] is None
    assert record["pass"] is False


def test_a_scenario_takes_its_default_number_of_runs():
    scenario = Scenario("P9-z", "a test", 12, {}, lambda runs, seed, _: {"runs": runs, "seed": seed})
    assert scenario.evaluate(None, 5, map).measured == {"runs": 12, "seed": 5}
    assert scenario.evaluate(2, 5, map).measured == {"runs": 2, "seed": 5}


def test_every_scenario_has_an_id_of_its_own_and_bounds():
    ids = [scenario.id for scenario in all_scenarios()]
    assert len(set(ids)) == len(ids)
    assert {f"P1-{letter}" for letter in "abcdefg"} <= set(ids)
    for scenario in all_scenarios():
        assert scenario.bounds
        assert all(low <= high for low, high in scenario.bounds.values())


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["P1-b"], ["P1-b"]),
        (["p1-B"], ["P1-b"]),
        (["P1"], [f"P1-{letter}" for letter in "abcdefg"]),
        (["P1-c", "P1-a", "P1-a"], ["P1-a", "P1-c"]),
    ],
)
def test_a_name_is_an_id_or_the_beginning_of_some(names, expected):
    assert [scenario.id for scenario in select(names)] == expected


def test_no_name_means_all():
    assert select([]) == list(all_scenarios())


@pytest.mark.parametrize("name", ["P7", "P1-h", "P1-a-b", "", "x"])
def test_an_unknown_name_is_refused_with_the_ids(name):
    with pytest.raises(UsageError, match=r"P1-a, .*P1-g"):
        select(["P1-a", name])


def test_processes_give_the_results_of_the_built_in_map_in_the_same_order():
    numbers = [float(number) for number in range(20)]
    with processes(2) as over_two, processes(1) as in_this_one:
        assert list(over_two(sqrt, numbers)) == list(in_this_one(sqrt, numbers)) == list(map(sqrt, numbers))


def test_an_error_in_a_trial_is_not_lost():
    with processes(2) as trial_map, pytest.raises(ValueError, match=r"math domain|nonnegative"):
        list(trial_map(sqrt, [1.0, -1.0]))


@pytest.mark.parametrize("workers", [0, -1])
def test_less_than_one_process_is_refused(workers):
    with pytest.raises(UsageError, match="expected 1 or more"), processes(workers):
        pytest.fail("it began")
