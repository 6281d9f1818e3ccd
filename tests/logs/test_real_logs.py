"""Real logs of all formats: each is read, or refused for a true reason."""

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.formats import open_source
from attest_mav.replay.engine import replay
from attest_mav.replay.plan import make_plan
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request
from attest_mav.runtime.files import open_log

REFUSED = {"px4_sdlog2_2016.px4log": "a PX4 log of before 2017"}
ENOUGH = 0.9
"""Share of the inertial messages that give a sample; the rest are zeros, or of a sensor that starts."""
SUFFIXES = {".bin", ".log", ".ulg", ".px4log", ".tlog"}


@pytest.fixture
def logs(data_folder):
    found = [path for path in sorted((data_folder / "public").rglob("*")) if path.suffix.lower() in SUFFIXES]
    if not found:
        pytest.skip(f"no public logs under {data_folder}")
    return found


def test_each_log_is_read_or_refused_for_a_reason(logs):
    for path in logs:
        with open_log(path) as data:
            if path.name in REFUSED:
                with pytest.raises(UnreadableDataError, match=REFUSED[path.name]):
                    open_source(data, path.name)
                continue
            source = open_source(data, path.name)
            summary = source.summary()
            plan = make_plan(summary, None, None)
            samples = sum(sum(one.source == plan.imu for one in batch.samples) for batch in source.samples(plan))
            count = summary.vehicles[plan.vehicle].count(plan.imu)
            assert ENOUGH * count <= samples <= count, (path.name, samples, count, source.refusals(plan))


def report_on(path):
    with open_log(path) as data:
        return as_json("flight", replay(open_source(data, "flight"), Request(), Outputs()))


def tilt_rms(path):
    (ours,) = report_on(path)["filters"]
    return ours["tilt_deg"]["rms"]


@pytest.mark.campaign
@pytest.mark.parametrize("name", ["copter_v344_crash.bin", "copter_v33_2015.tlog", "copter_v411_1hz_clock_steps.tlog"])
def test_an_autopilot_that_flies_by_its_attitude_is_not_accused(logs, name):
    (path,) = [path for path in logs if path.name == name]
    assert report_on(path)["verdict"]["disagree_s"] == 0.0


def test_the_autopilots_own_log_is_the_better_one(data_folder):
    """One flight of the simulator, recorded by the ground station and by the autopilot."""
    telemetry = tilt_rms(data_folder / "sitl" / "copter_square.tlog")
    own = tilt_rms(data_folder / "sitl" / "copter_square.BIN")
    assert telemetry < 0.1
    assert own < telemetry
