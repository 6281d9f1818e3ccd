"""The table of tools/accuracy, in its short form, and its bounds."""

from pathlib import Path

import pytest

from attest_mav.evaluation.accuracy import CASES, SHORT, run

DATA = Path(__file__).parents[1] / "data"


def logs(name):
    path = DATA / f"{name}.tlog"
    return path.read_bytes() if path.exists() else None


def test_the_short_form_keeps_its_bounds():
    lines = list(run(SHORT, logs))
    assert len(lines) == len(SHORT)
    assert [line.label for line in lines if not line.passed] == []
    assert all(set(line.limits) <= set(line.figures) for line in lines)


def test_a_log_that_is_not_there_has_no_row():
    assert list(run(SHORT, lambda _name: None)) == []


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.log} {case.condition}")
def test_every_disturbance_has_its_place(case):
    assert case.bounds
    assert case.edits
    assert len(case.within_s) in (0, len(case.edits))
