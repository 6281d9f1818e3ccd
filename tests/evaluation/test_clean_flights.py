"""Short flights of the whole service beside a healthy autopilot; tools/clean_flights flies them for hours."""

import pytest

from attest_mav.errors import UsageError
from attest_mav.evaluation.clean_flights import CleanFigures, CleanFlight, flights, fly, summary


@pytest.mark.parametrize(("scenario", "personality"), [("square", "ardupilot"), ("coordinated-turns", "px4")])
def test_a_healthy_autopilot_is_not_accused_and_rarely_doubted(scenario, personality):
    found = fly(CleanFlight(scenario, personality, 5, 75.0))
    assert found.flown_s == pytest.approx(45.0, abs=0.2)
    assert found.disagree_s == 0.0
    assert found.undecided_s <= 0.02 * found.flown_s
    assert found.silent_s == 0.0
    assert 0.0 < found.worst_tilt_deg < 1.0
    assert found.meets


def test_accusations_and_much_doubt_miss_the_bounds():
    assert not CleanFigures("any", 100.0, 0.1, 0.0, 0.0, 0.1).meets
    assert not CleanFigures("any", 100.0, 0.0, 2.1, 0.0, 0.1).meets
    assert CleanFigures("any", 100.0, 0.0, 1.9, 0.0, 0.1).meets


def test_flights_fill_the_hours_with_all_kinds_and_new_seeds():
    chosen = flights(5.0, 600.0, 7)
    assert len(chosen) == 30
    assert len({(one.scenario, one.personality) for one in chosen}) == 12
    assert {one.seed for one in chosen} == {7, 8, 9}


def test_the_summary_adds_times_and_keeps_the_largest_error():
    a, b = CleanFigures("x", 10.0, 1.0, 2.0, 3.0, 0.5), CleanFigures("x", 20.0, 0.0, 1.0, 0.0, 0.7)
    assert summary([a, b, CleanFigures("y", 5.0, 0.0, 0.0, 0.0, 0.1)]) == [
        CleanFigures("x", 30.0, 1.0, 3.0, 3.0, 0.7),
        CleanFigures("y", 5.0, 0.0, 0.0, 0.0, 0.1),
    ]


@pytest.mark.parametrize(("hours", "seconds"), [(0.0, 600.0), (-1.0, 600.0), (float("nan"), 600.0), (1.0, 30.0)])
def test_flights_without_figures_are_refused(hours, seconds):
    with pytest.raises(UsageError, match="expected"):
        flights(hours, seconds, 1)
