"""``attest-mav replay --limit`` and ``--junit``: figures that decide on the exit code."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from click.testing import CliRunner

from attest_mav.cli.replay import command
from attest_mav.errors import UsageError

LAPS = str(Path(__file__).parent.parent / "data" / "copter_square_laps.tlog")


def replay(*arguments):
    return CliRunner().invoke(command, [LAPS, "--skip", "2", *arguments])


def test_a_limit_that_is_kept_ends_with_0_and_one_that_is_missed_with_1():
    kept = replay("--limit", "tilt.rms=5")
    assert (kept.exit_code, "limit kept" in kept.stdout) == (0, True)
    missed = replay("--limit", "tilt.rms=5", "--limit", "autopilot.tilt.max=0.01")
    assert missed.exit_code == 1
    (line,) = [line for line in missed.stdout.splitlines() if "MISSED" in line]
    assert "autopilot.tilt.max is 0." in line
    assert "at most 0.01 is allowed" in line


def test_json_has_every_limit_for_every_filter():
    both = ("--filter", "gradient-descent,velocity-aided", "--limit", "tilt.rms=0.5", "--limit", "verdict.disagree_s=0")
    report = json.loads(replay("--json", *both).stdout)
    names = ["gradient-descent: tilt.rms", "velocity-aided: tilt.rms", "verdict.disagree_s"]
    assert [one["name"] for one in report["limits"]] == names
    by_name = {one["name"]: one for one in report["limits"]}
    assert by_name["velocity-aided: tilt.rms"]["value"] == report["filters"][1]["tilt_deg"]["rms"]
    assert by_name["gradient-descent: tilt.rms"]["pass"] is False
    assert by_name["verdict.disagree_s"] == {"name": "verdict.disagree_s", "value": 0, "limit": 0.0, "pass": True}


def test_a_figure_that_was_not_measured_misses_its_limit(tmp_path, without):
    path = tmp_path / "alone.tlog"
    path.write_bytes(without(without(Path(LAPS).read_bytes(), 30), 108))
    done = CliRunner().invoke(command, [str(path), "--limit", "tilt.rms=5", "--limit", "verdict.disagree_s=5"])
    assert done.exit_code == 1
    assert "tilt.rms: nothing was compared" in done.stdout
    assert "verdict.disagree_s: nothing was compared" in done.stdout


@pytest.mark.parametrize("text", ["tilt.rms", "tilt.rms=", "tilt.rms=two", "tilt.rms=-1", "tilt.rms=nan", "roll.rms=1"])
def test_a_wrong_limit_says_what_is_expected(text):
    error = replay("--limit", text).exception
    assert isinstance(error, UsageError)
    assert f"--limit {text}: expected" in str(error)


def test_junit_has_a_suite_a_log_with_its_limits_and_its_error(tmp_path):
    empty = tmp_path / "bad\x01.tlog"
    empty.write_bytes(b"")
    target = tmp_path / "junit.xml"
    done = replay(str(empty), "--limit", "tilt.rms=0.001", "--junit", str(target))
    assert done.exit_code == 65
    good, bad = ET.parse(target).getroot()  # noqa: S314  # written by the command itself
    assert (good.get("tests"), good.get("failures"), good.get("errors")) == ("2", "1", "0")
    assert "tilt.rms is 0." in good.find("testcase/failure").get("message")
    assert (bad.get("tests"), bad.get("failures"), bad.get("errors")) == ("1", "0", "1")
    assert "is empty" in bad.find("testcase/error").get("message")


def test_junit_is_written_also_if_no_log_can_be_read(tmp_path):
    empty = tmp_path / "empty.tlog"
    empty.write_bytes(b"")
    target = tmp_path / "junit.xml"
    done = CliRunner().invoke(command, [str(empty), "--junit", str(target)])
    assert done.exit_code == 65
    (suite,) = ET.parse(target).getroot()  # noqa: S314  # as above
    assert suite.get("errors") == "1"


def test_a_configuration_and_single_values_decide_on_filters_and_thresholds(tmp_path):
    file = tmp_path / "a.toml"
    file.write_text("[verdict]\ntilt_deg = 7.0\n[filter]\nname = 'gradient-descent'\n")
    report = json.loads(replay("--json", "--config", str(file)).stdout)
    assert [one["name"] for one in report["filters"]] == ["gradient-descent"]
    assert report["verdict"]["thresholds"]["tilt_deg"] == 7.0
    named = ("--filter", "velocity-aided", "--set", "verdict.tilt_deg=4")
    report = json.loads(replay("--json", "--config", str(file), *named).stdout)
    assert [one["name"] for one in report["filters"]] == ["velocity-aided"]
    assert report["verdict"]["thresholds"]["tilt_deg"] == 4.0


def test_a_parameter_changes_the_figures_of_its_filter():
    def rms(*changes):
        report = json.loads(replay("--json", "--filter", "gradient-descent", *changes).stdout)
        return report["filters"][0]["tilt_deg"]["rms"]

    assert rms("--set", "filter.gradient-descent.beta=0.5") != rms()
