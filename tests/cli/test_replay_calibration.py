"""``attest-mav replay`` with sensor errors of earlier flights: from a file, and into one."""

import json
from pathlib import Path

import pytest

from attest_mav.logs.tlog.reader import tlog_record
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.dialect import load_dialect

CUTS = Path(__file__).parent.parent / "data"
FLOWN = CUTS / "copter_receiver_noise.tlog"
NO_FILE = "expected a file that --save-calibration has written, or the state file of a service"
START = CUTS / "copter_square_start.tlog"


@pytest.fixture
def kept(attest_mav, tmp_path):
    """The file after a flight with manoeuvres."""
    path = tmp_path / "copter.json"
    code, _, err = attest_mav("replay", FLOWN, "--skip", "2", "--json", "--save-calibration", path)
    assert (code, err) == (0, "")
    return path


def test_the_errors_of_both_sensors_go_from_one_flight_to_the_next(attest_mav, kept):
    """The simulator's sensors have none: the truth is zero."""
    sensors = json.loads(kept.read_text())["calibrations"]
    assert sensors.keys() == {"1/RAW_IMU", "1/SCALED_IMU2"}
    for sensor in sensors.values():
        for name in ("accel_bias", "hard_iron"):
            mean, covariance = sensor[name]["mean"], sensor[name]["covariance"]
            assert all(abs(mean[axis]) < 3.0 * covariance[axis][axis] ** 0.5 for axis in range(3))
    code, out, _ = attest_mav("replay", START, "--skip", "2", "--json", "--calibration", kept)
    assert code == 0
    (note,) = [one for one in json.loads(out)["notes"] if "earlier flights" in one]
    assert note == (
        "the filter begins with sensor errors of earlier flights: RAW_IMU 0 days old, SCALED_IMU2 0 days old"
    )


def test_errors_of_another_sensor_are_not_used(attest_mav, tmp_path):
    """The log tells the accelerometer of its second sensor; of the first one nothing."""
    values = {"param_id": b"INS_ACC2_ID", "param_value": 7.0, "param_type": 6, "param_index": 0, "param_count": 900}
    first = START.read_bytes()
    told = tlog_record(
        int.from_bytes(first[:8], "big") * 1000, Encoder(load_dialect(), 1, 1).message("PARAM_VALUE", values)
    )
    log, known = tmp_path / "told.tlog", tmp_path / "known.json"
    log.write_bytes(told + first)
    vector = {"mean": [0.0, 0.0, 0.0], "covariance": [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]]}
    sensor = {"accel_bias": vector, "hard_iron": vector, "learned_unix_s": None, "accelerometer": {"device": 5}}
    known.write_text(json.dumps({"calibrations": {"1/RAW_IMU": sensor, "1/SCALED_IMU2": sensor}}))
    for how in ((), ("--as-it-came",)):
        code, out, _ = attest_mav("replay", log, "--skip", "2", "--json", "--calibration", known, *how)
        assert code == 0
        first, second = json.loads(out)["lanes"]
        (fault,) = second["faults"]
        assert (fault["kind"], first["faults"]) == ("uncalibrated", [])
        assert fault["text"] == "INS_ACC2_ID is 7 instead of 5: the accelerometer bias of before counts as unknown"


def test_a_second_process_begins_with_the_same(attest_mav, kept):
    """``--workers`` gives what one process gives."""
    outcomes = [
        attest_mav("replay", START, FLOWN, "--skip", "2", "--json", "--calibration", kept, "--workers", number)[1]
        for number in (1, 2)
    ]
    assert outcomes[0] == outcomes[1]
    assert outcomes[0].count("earlier flights") == 2


def test_a_flight_that_shows_nothing_leaves_what_was_known(attest_mav, kept, tmp_path):
    path = tmp_path / "next.json"
    code, _, err = attest_mav(
        "replay", START, "--end", "8", "--json", "--calibration", kept, "--save-calibration", path
    )
    assert code == 0
    assert err == "attest-mav: the flight has not shown the errors of its sensors: none is added\n"
    assert json.loads(path.read_text()) == json.loads(kept.read_text())


def test_a_flight_that_shows_nothing_replaces_no_file(attest_mav, tmp_path):
    path = tmp_path / "good.json"
    path.write_text("as it was")
    code, _, _ = attest_mav("replay", START, "--end", "8", "--json", "--save-calibration", path)
    assert code == 0
    assert path.read_text() == "as it was"


def test_a_file_of_another_vehicle_is_told(attest_mav, kept, tmp_path):
    path = tmp_path / "other.json"
    path.write_text(kept.read_text().replace("1/", "7/"))
    code, out, _ = attest_mav("replay", START, "--skip", "2", "--json", "--calibration", path)
    assert code == 0
    expected = "the calibration has neither 1/RAW_IMU nor another sensor used here: it has 7/RAW_IMU, 7/SCALED_IMU2"
    assert expected in json.loads(out)["notes"]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "cannot be read: no such file or directory"),
        (b"", NO_FILE),
        (b"\x93NUMPY", NO_FILE),
        (b'{"calibrations": {}}', "holds the errors of no sensor; leave the option out"),
        (
            b'{"x":' + b"[" * 100_000,
            NO_FILE,
        ),
        (b" " * 2_000_000, NO_FILE),
    ],
)
def test_a_wrong_file_is_one_line(attest_mav, tmp_path, content, says):
    path = tmp_path / "wrong.json"
    if content is not None:
        path.write_bytes(content)
    code, out, err = attest_mav("replay", START, "--calibration", path)
    assert (code, out) == (78, "")
    assert err.startswith(f"attest-mav: error: --calibration {path}: ")
    assert err.endswith(f"{says}\n")
    assert err.count("\n") == 1


@pytest.mark.parametrize("option", ["--save-calibration", "--junit", "--csv", "--parquet", "--tlog", "--report"])
@pytest.mark.parametrize(
    ("name", "reason"),
    [("no/such.json", "no such file or directory"), ("folder", "it is a directory; expected a file")],
)
def test_an_output_that_cannot_be_written_is_told_before_the_log_is_read(attest_mav, tmp_path, option, name, reason):
    (tmp_path / "folder").mkdir()
    empty = tmp_path / "empty.tlog"
    empty.touch()
    code, out, err = attest_mav("replay", empty, option, tmp_path / name)
    assert (code, out, err) == (65, "", f"attest-mav: error: cannot write {tmp_path / name}: {reason}\n")
    assert {path.name for path in tmp_path.iterdir()} == {"folder", "empty.tlog"}


@pytest.mark.parametrize(
    ("others", "says"),
    [
        ((START,), "--save-calibration takes one LOG: the errors of the sensors are those at the end of a flight"),
        (("--results", "r"), "--save-calibration and --results: a result that is kept has no errors of sensors"),
        (("--dask", "localhost:1"), "--dask and --save-calibration: "),
        (("--csv", "c.json"), "--csv and --save-calibration are both c.json: expected two files"),
    ],
)
def test_options_that_do_not_go_together_are_one_line(attest_mav, others, says):
    code, _, err = attest_mav("replay", FLOWN, *others, "--save-calibration", "c.json")
    assert code == 2
    assert says in err
    assert err.count("\n") == 1
