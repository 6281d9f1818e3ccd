"""``attest-mav compare``: two files of results side by side."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from attest_mav.cli.compare import command
from attest_mav.cli.replay import command as replay
from attest_mav.errors import UnreadableDataError

START = Path(__file__).parent.parent / "data" / "copter_square_start.tlog"


def compare(*arguments):
    return CliRunner().invoke(command, [*map(str, arguments)])


def line(log, tilt, disagree_s, *, size=10, work="w", name="velocity-aided"):
    """A result with the parts that count."""
    spread = None if tilt is None else {"rms": tilt, "p95": tilt, "max": tilt}
    report = {
        "filters": [{"name": name, "tilt_deg": spread, "heading_deg": None}],
        "verdict": {"filter": name, "intervals": [1], "disagree_s": disagree_s, "undecided_s": 2.0},
    }
    return {"of": {"log": log, "bytes": size, "work": work}, "report": report, "error": None}


def unread(log):
    return {"of": {"log": log, "bytes": 1, "work": "w"}, "report": None, "error": "why"}


@pytest.fixture
def files(tmp_path):
    before = [line("same", 1.0, 0.0), line("old", 1.0, 0.0), line("worse", 1.0, 0.0), line("accused", 2.0, 0.0)]
    before += [unread("bad"), line("better", 3.0, 5.0)]
    after = [line("better", 2.0, 1.0), line("same", 9.0, 9.0), line("same", 1.0, 0.0), line("worse", 1.5, 0.0, size=11)]
    after += [line("accused", 2.0, 7.5, work="v"), unread("bad"), line("new", 1.0, 0.0)]
    paths = [tmp_path / "a.jsonl", tmp_path / "b.jsonl"]
    for path, lines in zip(paths, (before, after), strict=True):
        path.write_text("".join(json.dumps(one) + "\n" for one in lines))
    return paths


def test_the_worst_log_comes_first_and_what_cannot_be_compared_is_named(files):
    done = compare(*files, "--json")
    assert done.exit_code == 0
    result = json.loads(done.stdout)
    assert [one["log"] for one in result["changes"]] == ["accused", "worse", "same", "better"]
    assert result["changes"][0]["disagree_s"] == {"before": 0.0, "after": 7.5, "change": 7.5}
    assert result["changes"][1]["tilt_rms_deg"]["change"] == 0.5
    assert result["changes"][1]["heading_rms_deg"] == {"before": None, "after": None, "change": None}
    assert (result["only_before"], result["only_after"], result["not_compared"]) == (["old"], ["new"], ["bad"])
    assert (result["other_size"], result["other_work"]) == (["worse"], ["accused"])


def test_the_table_fits_and_says_how_much_is_left_out(files):
    done = compare(*files, "--rows", 2)
    assert "2 of 4 rows" in done.stdout
    assert "1 logs: only in BEFORE: old" in done.stdout
    assert max(len(one.rstrip()) for one in done.stdout.splitlines()) <= 80
    rows = [one.split() for one in compare(*files).stdout.splitlines()]
    assert ["accused", "velocity-aided", "0", "-", "+7.5", "0"] in rows
    assert ["better", "velocity-aided", "-1.000", "-", "-4.0", "0"] in rows


@pytest.mark.parametrize(
    ("limit", "missed"),
    [
        ("verdict.disagree_s=7.5", []),
        ("verdict.disagree_s=7", ["accused: velocity-aided: growth of verdict.disagree_s is 7.500; at most 7 is"]),
        ("tilt.rms=0.4", ["worse: velocity-aided: growth of tilt.rms is 0.500; at most 0.4 is allowed"]),
        ("heading.rms=0", []),
    ],
)
def test_a_figure_that_has_grown_by_more_than_its_limit_ends_with_1(files, limit, missed):
    done = compare(*files, "--limit", limit)
    assert done.exit_code == bool(missed)
    found = [one for one in done.stdout.splitlines() if "MISSED" in one]
    assert len(found) == len(missed)
    assert all(text in one for text, one in zip(missed, found, strict=True))
    told = json.loads(compare(*files, "--limit", limit, "--json").stdout)["limits"]
    assert [one["pass"] for one in told].count(False) == len(missed)


def test_a_figure_that_is_gone_and_results_without_a_common_log_miss_a_limit(tmp_path):
    paths = [tmp_path / "a.jsonl", tmp_path / "b.jsonl", tmp_path / "c.jsonl"]
    for path, one in zip(paths, (line("a", 1.0, 0.0), line("a", None, 0.0), line("b", 1.0, 0.0)), strict=True):
        path.write_text(json.dumps(one) + "\n")
    gone = compare(paths[0], paths[1], "--limit", "tilt.rms=5")
    assert (gone.exit_code, "growth of tilt.rms: nothing was compared" in gone.stdout) == (1, True)
    assert compare(paths[0], paths[2], "--limit", "tilt.rms=5").exit_code == 1
    assert compare(paths[0], paths[0], "--limit", "tilt.rms=5").exit_code == 0
    assert compare(paths[0], paths[2]).exit_code == 0
    error = compare(paths[0], paths[1], "--limit", "autopilot.tilt.max=1").exception
    assert "expected NAME=VALUE with NAME one of tilt.rms, heading.rms, verdict.disagree_s" in str(error)


def test_results_that_a_replay_has_kept_are_read(tmp_path):
    kept = [tmp_path / "a.jsonl", tmp_path / "b.jsonl"]
    for path, beta in zip(kept, ("0.033", "0.1"), strict=True):
        options = ("--filter", "gradient-descent", "--skip", "2", "--set", f"filter.gradient-descent.beta={beta}")
        assert CliRunner().invoke(replay, [str(START), *options, "--results", str(path)]).exit_code == 0
    result = json.loads(compare(*kept, "--json").stdout)
    assert [one["filter"] for one in result["changes"]] == ["gradient-descent"]
    assert result["other_work"] == [str(START)]


@pytest.mark.parametrize("text", ["", "not json\n", "[1]\n", '{"of": {"log": "a"}}\n'])
def test_a_file_of_something_else_is_refused(files, tmp_path, text):
    path = tmp_path / "missing" if not text else tmp_path / "other"
    if text:
        path.write_text(text)
    error = compare(files[0], path).exception
    assert isinstance(error, UnreadableDataError)
    assert str(path) in str(error)
