"""Every row of the table of disturbed flights keeps its bounds; tools/disturbed_flights prints the table."""

import dataclasses
from math import inf

import pytest

from attest_mav.estimation.events import Agreement
from attest_mav.evaluation.disturbed_flights.flight import Outcome, fly, misses
from attest_mav.evaluation.disturbed_flights.row import Disturbance
from attest_mav.evaluation.disturbed_flights.table import ROWS, line_of

pytestmark = pytest.mark.campaign

GOOD = Outcome(1.0, inf, 0.0, ((Agreement.AGREE, "agrees"),), 20.0, 0.02, 0.3, 0.1, 3)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_disturbed_flight(row):
    assert misses(row, fly(row)) == []


def test_the_names_tell_the_rows_apart():
    assert len({row.name for row in ROWS}) == len(ROWS)


@pytest.mark.parametrize(
    ("change", "missed"),
    [
        ({}, ""),
        ({"detected_s": inf}, "detected"),
        ({"accused_s": inf}, "accused"),
        ({"recovered_s": 1.5}, "recovered"),
        ({"oldest_s": 0.6}, "oldest sent"),
        ({"worst_tilt_deg": 1.6}, "tilt error sent"),
        ({"lines": 30}, "lines a minute"),
        ({"sent_hz": 21.0}, "sent"),
        ({"unsound": 1}, "unsound attitudes sent"),
        ({"verdicts": ((Agreement.UNDECIDED, "doubted"),)}, "verdict UNDECIDED"),
    ],
)
def test_each_bound_can_be_missed(change, missed):
    row = Disturbance("any", sign="a sign", sent_hz=20.0, accused_s=inf if "accused_s" not in change else 1.0)
    found = misses(row, dataclasses.replace(GOOD, **change))
    assert [text.startswith(missed) for text in found] == ([True] if missed else [])


def test_a_line_of_the_table_says_what_was_missed():
    row = Disturbance("any", sign="a sign")
    assert line_of(row, GOOD) == "| any | AGREE | 20 | 1.0 |  | 0.0 | 0.3 |"
    assert "MISSED: recovered" in line_of(row, dataclasses.replace(GOOD, recovered_s=inf))
