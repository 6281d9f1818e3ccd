"""``attest-mav replay`` over many logs: folders, processes, the summary, and work that goes on where it ended."""

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from attest_mav.cli.replay import command
from attest_mav.errors import UsageError

CUTS = Path(__file__).parent.parent / "data"
GOOD = ("copter_gyro_step", "copter_square_laps", "plane_circles_turn")
OPTIONS = ("--skip", "2")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three logs, of which one has a DISAGREE, and two that are none."""
    path = tmp_path_factory.mktemp("flights")
    for name in GOOD:
        shutil.copy(CUTS / f"{name}.tlog", path)
    (path / "bad.bin").write_bytes(b"not a log at all\n" * 50)
    (path / "empty.tlog").write_bytes(b"")
    return path


def replay(*arguments):
    return CliRunner().invoke(command, [*map(str, arguments), *OPTIONS])


def test_the_summary_has_the_worst_log_first_and_bad_ones_stop_nothing(folder):
    done = replay(folder, "--workers", 1)
    assert done.exit_code == 65
    assert "2 of 5 logs could not be read" in done.stdout
    summary = done.stdout.partition("worst first")[2]
    places = [summary.index(name) for name in GOOD]
    assert places[0] == min(places), "the one with a wrong autopilot"
    for name in ("bad.bin", "empty.tlog"):
        assert name in done.stderr
    assert max(len(line.rstrip()) for line in summary.splitlines()) <= 80


def test_the_number_of_processes_changes_nothing(folder):
    alone = replay(folder, "--json", "--workers", 1)
    spread = replay(folder, "--json", "--workers", 2)
    assert spread.stdout == alone.stdout
    assert spread.stderr == alone.stderr
    assert [json.loads(line)["log"] for line in spread.stdout.splitlines()] == [str(folder / f"{n}.tlog") for n in GOOD]


def test_kept_results_are_not_made_again_and_look_the_same(folder, tmp_path):
    kept = tmp_path / "results.jsonl"
    first = replay(folder, "--json", "--workers", 1, "--results", kept)
    lines = kept.read_text().splitlines()
    assert len(lines) == 5
    kept.write_text("\n".join([*lines[:3], lines[3][:50]]))  # ended in the middle of the fourth
    second = replay(folder, "--json", "--workers", 1, "--results", kept)
    assert (second.exit_code, second.stdout, second.stderr) == (first.exit_code, first.stdout, first.stderr)
    assert kept.read_text().splitlines() == lines
    replay(folder, "--workers", 1, "--results", kept, "--filter", "leveling")
    assert len(kept.read_text().splitlines()) == 10, "other work on the same logs"


@pytest.mark.parametrize(
    "arguments",
    [(CUTS / f"{GOOD[0]}.tlog", "--workers", 2), (CUTS, "--workers", 0)],
)
def test_a_number_of_processes_that_cannot_be_meant_is_refused(arguments):
    assert isinstance(replay(*arguments).exception, UsageError)


def test_many_logs_are_shown_by_their_summary_alone(folder):
    logs = [folder / f"{GOOD[1]}.tlog", *[folder / f"missing{k}.tlog" for k in range(8)]]
    done = replay(*logs, "--workers", 1)
    assert "inertial" not in done.stdout
    assert "8 of 9 logs could not be read" in done.stdout
