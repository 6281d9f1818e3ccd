"""The evaluate command: names, table, JSON and exit codes."""

import json

import pytest
from click.testing import CliRunner

from attest_mav.cli.evaluate import command as evaluate
from attest_mav.cli.evaluate import figures, show
from attest_mav.errors import UsageError
from attest_mav.evaluation.harness import Outcome


@pytest.fixture
def run():
    def invoke(*arguments):
        return CliRunner().invoke(evaluate, ["--workers", "1", *arguments])

    return invoke


def test_without_numpy_the_command_to_give_is_said(run, monkeypatch):
    monkeypatch.setattr("attest_mav.cli.evaluate.find_spec", lambda _name: None)
    assert "pip install numpy" in str(run("P1-f").exception)


def test_json_is_a_list_of_records(run):
    result = run("P1-f", "--runs", "20", "--seed", "9", "--json")
    assert result.exit_code == 0, result.output
    (record,) = json.loads(result.stdout)
    assert set(record) == {"id", "measured", "bounds", "paper", "runs", "seed", "pass"}
    assert (record["id"], record["runs"], record["seed"], record["pass"]) == ("P1-f", 20, 9, True)
    assert set(record["measured"]) == set(record["bounds"]) == {"identity", "jacobian"}
    assert record["paper"] is None


def test_the_table_shows_every_figure_with_its_bounds_and_verdict(run):
    result = run("P1-f", "--runs", "20")
    assert result.exit_code == 0, result.output
    for text in ("P1-f", "identity", "jacobian", "1e-12", "1e-06", "within", "1 of 1 within their bounds, seed 1"):
        assert text in result.stdout
    assert "MISSED" not in result.stdout


def test_the_same_seed_gives_the_same_text(run):
    arguments = ("P1-f", "--runs", "5", "--json", "--seed")
    assert run(*arguments, "2").stdout == run(*arguments, "2").stdout != run(*arguments, "3").stdout


def test_a_missed_bound_ends_with_one(run, monkeypatch):
    def missed(*_):
        return [Outcome("P1-f", "a test", {"x": 3.0}, {"x": (0.0, 1.0)}, None, 1, 1)]

    monkeypatch.setattr("attest_mav.cli.evaluate.measure", missed)
    result = run("P1-f")
    assert result.exit_code == 1
    assert "MISSED" in result.stdout
    assert "0 of 1" in result.stdout


def test_an_unknown_name_is_a_usage_error_that_lists_the_ids(run):
    result = run("P8-q")
    assert isinstance(result.exception, UsageError)
    assert "'P8-q'" in str(result.exception)
    assert "P1-a, P1-b" in str(result.exception)


@pytest.mark.parametrize("arguments", [("--runs", "0"), ("--runs", "x"), ("--seed", "-1"), ("--workers", "0")])
def test_a_number_that_cannot_be_meant_is_refused(run, arguments):
    result = run("P1-f", *arguments)
    assert result.exit_code == 2
    assert arguments[0] in result.stderr


def test_the_papers_figure_is_shown_where_there_is_one():
    outcome = Outcome("P3-a", "a test", {"x": 0.5, "free": 2.0}, {"x": (0.0, 1.0)}, {"x": 0.46}, 1, 1)
    assert figures(outcome, "x")[:4] == ["0.5", "0", "1", "0.46"]
    assert figures(outcome, "free") == ["2", "-", "-", "-", ""]


def test_the_table_fits_eighty_columns(capsys):
    show(
        [
            Outcome(
                "P1-d",
                "a rather long title " * 4,
                {"total_deg_fast": 6.062},
                {"total_deg_fast": (5.6, 6.8)},
                None,
                20,
                1,
            )
        ]
    )
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= 80 for line in lines)
    assert any("total_deg_fast" in line and "6.062" in line for line in lines)
