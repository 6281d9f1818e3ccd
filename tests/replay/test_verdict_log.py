"""The verdict over a recorded flight: intervals in log time, beside each filter."""

import json
from itertools import pairwise

import pytest
from click.testing import CliRunner

from attest_mav.cli.replay import command as replay_command
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

SECOND = 1_000_000_000
START_US = 1_750_000_000_000_000


def recording(dialect, faults, seconds):
    """A tlog of the fake autopilot, as a ground station records it."""
    settings = SimSettings(scenario="square", fast_rate_hz=50.0, faults=parse_faults(faults))
    vehicle = FakeAutopilot(settings, 1, dialect)
    data = b""
    for step in range(seconds * 50):
        now_ns = step * SECOND // 50
        stamp = (START_US + now_ns // 1000).to_bytes(8, "big")
        data += b"".join(stamp + frame for frame in vehicle.frames_until(now_ns))
    return data


def intervals_of(data, dialect, *filters):
    request = Request(filters, None, None, None, Window(skip_s=5.0))
    report = as_json("log", replay(TlogSource(data, dialect), request, Outputs()))
    return report["verdict"]["intervals"]


@pytest.fixture(scope="module")
def wrong_twice(dialect):
    return recording(dialect, ["attitude-offset-north=12@20+8", "gyro1-bias-x=5@36+1.9"], 50)


def test_a_wrong_attitude_is_an_interval_with_its_numbers(wrong_twice, dialect):
    verdicts = intervals_of(wrong_twice, dialect, VelocityAided())
    off = next(one for one in verdicts if one["state"] == "disagree")
    assert 20.4 < off["start_s"] + first_sample_s(wrong_twice, dialect) < 21.2, "the fault and the hold time"
    assert 28.0 < off["end_s"] + first_sample_s(wrong_twice, dialect) < 28.8
    assert off["reason"] == "tilt"
    assert off["peak_tilt_deg"] == pytest.approx(12.0, abs=0.5)
    assert off["sensors"] == ["RAW_IMU used", "SCALED_IMU2 used"]
    assert off["autopilot_reports"] == []


def test_a_sensor_set_aside_is_a_fault_of_its_stream(dialect):
    data = recording(dialect, ["gyro1-bias-x=5@20+8"], 40)
    report = as_json("log", replay(TlogSource(data, dialect), Request((), None, None, None, Window()), Outputs()))
    first, second = report["lanes"]
    assert (first["message"], second["message"], second["faults"]) == ("RAW_IMU", "SCALED_IMU2", [])
    assert first["samples"] == second["samples"] > 1900
    (fault,) = first["faults"]
    assert fault["kind"] == "set-aside"
    assert "gyro x" in fault["text"]
    assert 20.0 < fault["start_s"] + first_sample_s(data, dialect) < 22.0
    assert 28.0 < fault["end_s"] + first_sample_s(data, dialect) < 38.0


def first_sample_s(data, dialect):
    """The vehicle's time at the first inertial sample, where log time begins."""
    source = TlogSource(data, dialect)
    request = Request((GradientDescent(),), None, None, None, Window())
    plan = replay(source, request, Outputs()).plan
    sample = next(one for batch in source.samples(plan) for one in batch.samples if one.source == "RAW_IMU")
    return sample.t_ns * 1e-9


def test_intervals_follow_each_other_to_the_end_of_the_log(wrong_twice, dialect):
    verdicts = intervals_of(wrong_twice, dialect, VelocityAided())
    assert verdicts[0]["start_s"] < 1.0
    assert verdicts[-1]["end_s"] > 49.0
    for earlier, later in pairwise(verdicts):
        assert later["start_s"] == earlier["end_s"]
        assert later["state"] != earlier["state"]


def test_the_flight_filter_judges_whatever_its_company(wrong_twice, dialect):
    alone = intervals_of(wrong_twice, dialect, VelocityAided())
    both = intervals_of(wrong_twice, dialect, GradientDescent(), VelocityAided())
    assert both == alone
    assert intervals_of(wrong_twice, dialect, GradientDescent()) != alone


def test_what_the_autopilot_said_of_itself_stands_beside_the_interval(dialect):
    data = recording(dialect, ["gyro1-bias-x=5@20+15"], 30)
    verdicts = intervals_of(data, dialect, VelocityAided())
    assert any('said "EKF3 lane switch 1"' in text for one in verdicts for text in one["autopilot_reports"])


def test_attitudes_that_stop_leave_the_verdict_undecided(dialect, without):
    whole = recording(dialect, [], 40)
    half = whole.index((START_US + 20_000_000).to_bytes(8, "big"))
    data = whole[:half] + without(whole[half:], 30)
    verdicts = intervals_of(data, dialect, VelocityAided())
    assert [one["state"] for one in verdicts][-2:] == ["agree", "undecided"]
    assert verdicts[-1]["reason"] == "no-reference"
    assert (verdicts[-1]["peak_tilt_deg"], verdicts[-1]["peak_heading_deg"]) == (None, None)


def test_a_log_without_an_attitude_of_the_autopilot_has_no_verdicts(dialect, without):
    data = without(recording(dialect, [], 10), 30)
    assert intervals_of(data, dialect, VelocityAided()) == []


def test_the_table_shows_the_flight_filters_verdict(wrong_twice, tmp_path):
    path = tmp_path / "wrong.tlog"
    path.write_bytes(wrong_twice)
    table = CliRunner().invoke(replay_command, [str(path), "--filter", "gradient-descent,velocity-aided"]).stdout
    assert "verdict beside" in table
    (line,) = [line for line in table.splitlines() if "DISAGREE" in line and " 12." in line]
    assert line.endswith("  tilt")
    report = json.loads(CliRunner().invoke(replay_command, ["--json", str(path)]).stdout)
    assert [one["state"] for one in report["verdict"]["intervals"]].count("disagree") >= 1
