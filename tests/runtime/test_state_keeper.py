"""The state file: written where it must be, read back, and told about when that fails."""

import errno
import json
import os
import threading
from pathlib import Path

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.errors import ConfigError
from attest_mav.filters.calibration import SensorCalibration, UncertainVector
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.runtime.state_keeper import StateKeeper, state_path
from attest_mav.service.assembly import service_settings
from attest_mav.service.service import Service
from attest_mav.types import EarthField

CONFIG = '[[link]]\nurl = "sim:"\nsigning = "sign"\nkey_file = "k"\n'
FAR = 20_000_000_000_000_0
"""A timestamp of the year 2078, later than any clock that runs this."""


@pytest.fixture
def service():
    settings = service_settings(parse_config(CONFIG, "test"), {"k": bytes(range(32))})
    return Service(settings, ["sim:"], load_dialect(), lambda *_: (EarthField(), "none"), 0)


def kept(path):
    return json.loads(path.read_text())["signing_timestamp"]


def test_the_time_of_signatures_is_written_at_once_and_again_within_a_minute(tmp_path, service):
    path = tmp_path / "new" / "folder" / "state.json"
    keeper = StateKeeper(service.persistence, path, 0)
    first = kept(path)
    assert first > 3 * 10**13, "after 2024"
    for _ in range(10):
        keeper.due(keeper.next_deadline_ns)
        keeper.settle()
    assert keeper.next_deadline_ns <= 60_000_000_000
    assert kept(path) - first >= 29 * 100_000
    assert [one.name for one in path.parent.iterdir()] == ["state.json"]


def test_a_kept_time_that_is_ahead_of_the_clock_is_gone_on_from(tmp_path, service):
    path = tmp_path / "state.json"
    path.write_text(json.dumps({"signing_timestamp": FAR}))
    StateKeeper(service.persistence, path, 0)
    assert kept(path) > FAR


@pytest.mark.parametrize("text", ["", "{", '{"signing_timestamp": -1}', '{"signing_timestamp": 281474976710655}', "[]"])
def test_a_file_that_holds_no_state_is_told_and_replaced(tmp_path, service, caplog, text):
    path = tmp_path / "state.json"
    path.write_text(text)
    StateKeeper(service.persistence, path, 0)
    assert 3 * 10**13 < kept(path) < FAR
    assert [one for one in caplog.messages if f"{path} holds no state" in one]


def test_a_folder_that_cannot_be_had_ends_the_start_with_its_name(tmp_path, service):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match=r"state\.folder: cannot .*file"):
        StateKeeper(service.persistence, tmp_path / "file" / "state.json", 0)


def test_a_disk_that_is_full_at_the_start_is_told_and_tried_again(tmp_path, service, caplog, monkeypatch):
    def full(*_arguments, **_options):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    path = tmp_path / "new" / "state.json"
    caplog.set_level("INFO", "attest_mav")
    with monkeypatch.context() as patch:
        patch.setattr(Path, "mkdir", full)
        keeper = StateKeeper(service.persistence, path, 0)
        keeper.due(30_000_000_000)
        keeper.settle()
    keeper.due(60_000_000_000)
    keeper.finish()
    assert kept(path) > 3 * 10**13
    told = [one for one in caplog.messages if "new" in one]
    assert len(told) == 2
    assert "No space left on device; a restart would lose" in told[0]
    assert "is written again" in told[1]


def test_a_failure_later_is_told_once_and_so_is_its_end(tmp_path, service, caplog):
    caplog.set_level("INFO", "attest_mav")
    folder = tmp_path / "state"
    keeper = StateKeeper(service.persistence, folder / "state.json", 0)
    (folder / "state.json").unlink()
    folder.rmdir()
    folder.write_text("")
    keeper.due(30_000_000_000)
    keeper.settle()
    keeper.due(60_000_000_000)
    keeper.settle()
    folder.unlink()
    keeper.due(90_000_000_000)
    keeper.settle()
    told = [one for one in caplog.messages if "state.json" in one]
    assert len(told) == 2
    assert "cannot write" in told[0]
    assert "is written again" in told[1]


def test_a_disk_that_does_not_answer_holds_up_nothing_and_gets_one_write_at_a_time(tmp_path, service, monkeypatch):
    keeper = StateKeeper(service.persistence, tmp_path / "state.json", 0)
    answers, begun = threading.Event(), []

    def slow(path, _state):
        begun.append(path)
        answers.wait(30.0)

    monkeypatch.setattr("attest_mav.runtime.state_keeper._write", slow)
    for now_s in (30, 60, 90):
        keeper.due(now_s * 1_000_000_000)
    answers.set()
    keeper.settle()
    assert len(begun) == 1
    keeper.finish()
    assert len(begun) == 2


@pytest.mark.parametrize(
    ("folder", "environment", "path"),
    [
        ("/a", {"STATE_DIRECTORY": "/b"}, "/a/state.json"),
        ("", {"STATE_DIRECTORY": "/b:/c", "XDG_STATE_HOME": "/d"}, "/b/state.json"),
        ("", {"XDG_STATE_HOME": "/d"}, "/d/attest-mav/state.json"),
        ("", {}, f"{Path.home()}/.local/state/attest-mav/state.json"),
    ],
)
def test_the_folder_is_the_configured_one_or_systemds_or_the_users(folder, environment, path):
    assert state_path(folder, environment) == Path(path)


def test_without_signatures_the_file_is_written_when_something_is_learned(tmp_path, service):
    path = tmp_path / "state.json"
    keeper = StateKeeper(service.persistence, path, 0, keeps_time=False)
    path.write_text("untouched")
    for _ in range(20):
        keeper.due(keeper.next_deadline_ns)
        keeper.settle()
    assert path.read_text() == "untouched"
    vector = UncertainVector((0.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    service.persistence.calibrations.take(1, {"RAW_IMU": SensorCalibration(vector, vector)})
    for _ in range(8):
        keeper.due(keeper.next_deadline_ns)
        keeper.settle()
    assert json.loads(path.read_text())["calibrations"].keys() == {"1/RAW_IMU"}


def test_calibrations_that_make_no_sense_cost_nothing_else(tmp_path, service, caplog):
    path = tmp_path / "state.json"
    path.write_text(json.dumps({"signing_timestamp": FAR, "calibrations": {"1/RAW_IMU": {"accel_bias": None}}}))
    StateKeeper(service.persistence, path, 0)
    assert kept(path) > FAR
    assert [one for one in caplog.messages if "the calibrations make no sense" in one]


def test_what_stays_the_same_is_not_written_again(tmp_path, service):
    path = tmp_path / "state.json"
    keeper = StateKeeper(service.persistence, path, 0, keeps_time=False)
    vector = UncertainVector((0.01, 0.0, 0.0), ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01)))
    nearly = UncertainVector((0.015, 0.0, 0.0), ((0.0104, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01)))
    for shown in (vector, nearly):
        service.persistence.calibrations.take(1, {"RAW_IMU": SensorCalibration(shown, vector)})
        for _ in range(8):
            keeper.due(keeper.next_deadline_ns)
            keeper.settle()
        assert json.loads(path.read_text())["calibrations"]["1/RAW_IMU"]["accel_bias"]["mean"][0] == 0.01
        path.write_text(path.read_text())
