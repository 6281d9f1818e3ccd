"""``attest-mav replay`` as a user meets it: what it prints, what it writes, and one line for every wrong input."""

import csv
import json
import subprocess
from pathlib import Path
from random import Random

import pytest

CUTS = Path(__file__).parent.parent / "data"
LAPS = CUTS / "copter_square_laps.tlog"
START = CUTS / "copter_square_start.tlog"
ON_BRIEF_LOGS = ("--skip", "2")


@pytest.fixture
def wrong_file(tmp_path):
    """Makes a file that is no readable log."""

    def make(kind):
        path = tmp_path / f"{kind}.tlog"
        contents = {
            "empty": b"",
            "png": b"\x89PNG\r\n\x1a\n" + bytes(100),
            "text": b"not a log at all\n" * 50,
            "zip": b"PK\x03\x04" + bytes(100),
            "zeros": bytes(300_000),
            "dataflash": b"\xa3\x95\x80\x80\x59FMT\0" + bytes(200),
            "ulog": b"ULog\x01\x12\x35\x01" + bytes(200),
        }
        path.write_bytes(contents[kind])
        return path

    return make


def assert_one_line(err, *parts):
    assert err.count("\n") == 1, err
    assert err.startswith("attest-mav: error: ")
    for part in parts:
        assert str(part) in err


def test_table_shows_the_autopilots_own_row_and_what_everything_refers_to(attest_mav):
    code, out, err = attest_mav("replay", LAPS, *ON_BRIEF_LOGS)
    assert code == 0
    assert err == ""
    for part in (
        "SIM_STATE, 1000 samples",
        "RAW_IMU, 1000 samples at 50.0 Hz",
        "true; declination +0.66 deg, the table of ArduPilot",
    ):
        assert part in out
    assert "velocity-aided" in out
    own = next(line for line in out.splitlines() if "autopilot's ATTITUDE" in line)
    tilt_rms = float(own.split()[2])
    assert 0.1 < tilt_rms < 0.3


def test_json_is_one_object_a_log_one_a_line(attest_mav):
    code, out, _ = attest_mav("replay", LAPS, START, "--json", *ON_BRIEF_LOGS)
    assert code == 0
    laps, start = map(json.loads, out.splitlines())
    assert laps["log"] == str(LAPS)
    assert start["reference"]["message"] == "SIMSTATE"
    keys = {"log", "format", "frames", "bad_bytes", "duration_s", "imu", "reference", "filters", "autopilot"}
    assert keys <= laps.keys()
    assert set(laps["imu"]) == {"message", "samples", "rate_hz", "gaps"}
    assert set(laps["reference"]) == {"message", "samples", "sigma"}
    assert set(laps["filters"][0]) == {
        "name",
        "samples",
        "tilt_deg",
        "heading_deg",
        "valid",
        "consistency",
        "not_compared",
    }
    peak = {"max_at_s", "max_at_unix_s", "max_phase"}
    assert set(laps["autopilot"]["heading_deg"]) == {"rms", "p95", "max"} | peak


def test_a_vehicle_is_named_and_all_are_listed(attest_mav, tmp_path, log):
    for sender in ((1, 1), (2, 1)):
        log.heartbeat(sender=sender)
        for k in range(300):
            log.imu(1000 + 20 * k, sender=sender)
            log.attitude(1000 + 20 * k, sender=sender)
    path = tmp_path / "two.tlog"
    path.write_bytes(log.data)
    _, out, _ = attest_mav("replay", path, "--json", "--vehicle", "2/1", "--skip", "1")
    result = json.loads(out)
    assert result["vehicle"] == {"system": 2, "component": 1}
    assert result["vehicles"] == [
        {"system": 1, "component": 1, "samples": 300},
        {"system": 2, "component": 1, "samples": 300},
    ]
    _, table, _ = attest_mav("replay", path, "--skip", "1")
    assert "the log has other vehicles too (2/1); this is 1/1 (--vehicle names another)" in table


def test_without_a_velocity_both_outputs_say_so(attest_mav, tmp_path, without):
    path = tmp_path / "no_gps.tlog"
    path.write_bytes(without(LAPS.read_bytes(), 24))
    _, out, _ = attest_mav("replay", path, "--filter", "auto", "--json", *ON_BRIEF_LOGS)
    _, table, _ = attest_mav("replay", path, *ON_BRIEF_LOGS)
    result = json.loads(out)
    assert [one["name"] for one in result["filters"]] == ["velocity-aided"]
    assert any(note.startswith("no velocity in the log: it has no GPS_RAW_INT") for note in result["notes"])
    assert "no velocity in the log: it has no GPS_RAW_INT" in table
    assert "\n velocity-aided " in table


def test_filters_with_a_sigma_are_held_to_it(attest_mav):
    names = ("gradient-descent", "robust-adaptive", "leveling", "velocity-aided")
    arguments = ("replay", LAPS, "--filter", ",".join(names), *ON_BRIEF_LOGS)
    code, out, _ = attest_mav(*arguments, "--json")
    assert code == 0
    without, *sure = json.loads(out)["filters"]
    assert (without["valid"], without["consistency"]) == (None, None)
    for one in sure:
        consistency = one["consistency"]
        assert set(one["valid"]) == {"share", "tilt_deg"}
        assert set(consistency) == {"tilt", "heading", "nis"}
        assert set(consistency["nis"]) == {"velocity", "magnetometer"}
        for shares in (consistency["tilt"], consistency["heading"]):
            assert set(shares) == {"within_1", "within_2", "within_3", "rms"}
    _, out, _ = attest_mav(*arguments)
    table = out.partition("its own")[2]
    sigmas = [line for line in table.partition("mean NIS")[0].splitlines() if line.strip()]
    assert [line.split()[0] for line in sigmas[-4:]] == [*names[1:], "if"]
    assert max(len(line.rstrip()) for line in out.partition("rms")[2].splitlines()) <= 80


def test_without_a_sigma_there_is_no_table_of_sigmas(attest_mav):
    _, out, _ = attest_mav("replay", LAPS, "--filter", "gradient-descent", *ON_BRIEF_LOGS)
    assert "its own" not in out


def test_what_is_named_is_used(attest_mav):
    arguments = ("--imu", "SCALED_IMU2", "--reference", "AHRS2", "--declination", "-4.5")
    code, out, _ = attest_mav("replay", START, "--json", *ON_BRIEF_LOGS, *arguments)
    result = json.loads(out)
    assert code == 0
    assert result["imu"]["message"] == "SCALED_IMU2"
    assert result["reference"]["message"] == "AHRS2"
    assert result["north"]["declination_deg"] == -4.5
    assert result["autopilot"]["message"] == "ATTITUDE"


def test_csv_has_a_row_for_every_attitude_and_figures_agree_with_it(attest_mav, tmp_path):
    target = tmp_path / "rows.csv"
    code, out, _ = attest_mav("replay", LAPS, START, "--json", "--csv", target, *ON_BRIEF_LOGS)
    assert code == 0
    result = json.loads(out.splitlines()[0])
    with target.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["log"] == str(LAPS)]
    ours = [row for row in rows if row["filter"] == "velocity-aided"]
    counted = [float(row["tilt_error_deg"]) for row in ours if row["counted"] == "1"]
    assert len(counted) == result["filters"][0]["samples"]
    assert max(counted) == pytest.approx(result["filters"][0]["tilt_deg"]["max"], abs=1e-5)
    assert {row["north"] for row in rows} == {"true"}
    q = [float(ours[-1][name]) for name in ("q_w", "q_x", "q_y", "q_z")]
    assert sum(part * part for part in q) == pytest.approx(1.0, abs=1e-7)


def test_annotated_log_replays_like_the_original(attest_mav, tmp_path):
    annotated = tmp_path / "annotated.tlog"
    options = ("--filter", "gradient-descent", "--json", *ON_BRIEF_LOGS)  # it has an attitude after half a second
    code, original, _ = attest_mav("replay", LAPS, "--tlog", annotated, *options)
    assert code == 0
    code, again, _ = attest_mav("replay", annotated, *options)
    before, after = json.loads(original), json.loads(again)
    assert after["frames"] > before["frames"] + 900
    for key in ("imu", "reference", "filters", "autopilot", "bad_bytes"):
        assert after[key] == before[key]


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("empty", "is empty"),
        ("png", "PNG picture"),
        ("text", "no log that is known here"),
        ("zip", "the zip archive is damaged"),
        ("zeros", "no log that is known here"),
        ("dataflash", "no IMU or IMU2"),
        ("ulog", "this ULog has no message"),
    ],
)
def test_files_that_are_no_tlog_are_named_for_what_they_are(attest_mav, wrong_file, kind, words):
    path = wrong_file(kind)
    code, out, err = attest_mav("replay", path)
    assert code == 65
    assert out == ""
    assert_one_line(err, path, words)


def test_a_missing_file_and_a_folder(attest_mav, tmp_path):
    code, _, err = attest_mav("replay", tmp_path / "missing.tlog")
    assert code == 65
    assert_one_line(err, "missing.tlog", "no such file")
    code, _, err = attest_mav("replay", tmp_path)
    assert code == 65
    assert_one_line(err, tmp_path)


def test_a_log_cut_in_the_middle_of_a_frame_is_read(attest_mav, tmp_path):
    path = tmp_path / "cut.tlog"
    path.write_bytes(LAPS.read_bytes()[:-20])
    code, out, err = attest_mav("replay", path, "--json", *ON_BRIEF_LOGS)
    assert code == 0
    assert err == ""
    assert json.loads(out)["frames"] == 3040


@pytest.mark.parametrize("garbage", [bytes(70_000), Random(1).randbytes(70_000), b"some text\n" * 7000])
def test_a_log_behind_garbage_is_read(attest_mav, tmp_path, garbage):
    path = tmp_path / "damaged.tlog"
    path.write_bytes(garbage + LAPS.read_bytes())
    code, out, err = attest_mav("replay", path, "--json", *ON_BRIEF_LOGS)
    assert (code, err) == (0, "")
    damaged = json.loads(out)
    assert damaged["bad_bytes"] > 0.99 * len(garbage), "one checksum in 65536 fits by chance"
    assert damaged["imu"]["samples"] >= 999


def test_a_log_without_inertial_messages(attest_mav, tmp_path):
    # The first record of the cut is its heartbeat: 8 bytes of time and 21 of frame.
    path = tmp_path / "heartbeat.tlog"
    path.write_bytes(LAPS.read_bytes()[:29])
    code, _, err = attest_mav("replay", path)
    assert code == 65
    assert_one_line(err, path, "no RAW_IMU")


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("--filter", "kalman"), 2, "unknown filter 'kalman'; known filters: gradient-descent"),
        (("--filter", "gradient-descent,gradient-descent"), 2, "named twice"),
        (("--filter", "auto,leveling"), 2, "auto stands alone"),
        (("--imu", "ATTITUDE"), 2, "unknown inertial message 'ATTITUDE'"),
        (("--reference", "TRUTH"), 2, "unknown reference 'TRUTH'"),
        (("--reference", "SIMSTATE"), 65, "no SIMSTATE in it to compare with; it has SIM_STATE, ATTITUDE"),
        (("--imu", "HIGHRES_IMU"), 65, "no HIGHRES_IMU in it"),
        (("--vehicle", "9"), 65, "no vehicle 9 in it; it has 1/1"),
        (("--vehicle", "1/x"), 2, "--vehicle 1/x: expected SYSTEM or SYSTEM/COMPONENT"),
        (("--vehicle", "256"), 2, "--vehicle 256"),
        (("--vehicle", "1/"), 2, "--vehicle 1/"),
        (("--skip", "-1"), 2, "--skip -1"),
        (("--start", "nan"), 2, "--start nan"),
        (("--start", "20", "--end", "10"), 2, "--end 10"),
        (("--start", "1000"), 65, "the part to be read has none"),
        (("--declination", "200"), 2, "--declination 200"),
        (("--csv", str(LAPS)), 2, "would replace the log"),
        (("--tlog", str(CUTS / ".." / "data" / LAPS.name)), 2, "would replace the log"),
        (("--csv", "/nonexistent/rows.csv"), 65, "cannot write /nonexistent/rows.csv"),
    ],
)
def test_wrong_arguments_are_one_line(attest_mav, arguments, code, words):
    result, out, err = attest_mav("replay", LAPS, *arguments)
    assert result == code
    assert out == ""
    assert_one_line(err, words)


def test_outputs_that_cannot_hold_what_is_asked(attest_mav, tmp_path):
    code, _, err = attest_mav("replay", LAPS, START, "--tlog", tmp_path / "annotated.tlog")
    assert code == 2
    assert_one_line(err, "--tlog takes one LOG")
    same = tmp_path / "same"
    code, _, err = attest_mav("replay", LAPS, "--csv", same, "--tlog", same)
    assert code == 2
    assert_one_line(err, "expected two files")


def test_one_bad_log_does_not_stop_the_others(attest_mav, wrong_file, tmp_path):
    bad, target = wrong_file("png"), tmp_path / "rows.csv"
    code, out, err = attest_mav("replay", bad, LAPS, "--json", "--csv", target, *ON_BRIEF_LOGS)
    assert code == 65
    assert_one_line(err, bad)
    assert [json.loads(line)["log"] for line in out.splitlines()] == [str(LAPS)]
    assert target.read_text().count("\n") > 1000


def test_a_failed_replay_leaves_no_output(attest_mav, wrong_file, tmp_path):
    bad, rows, annotated = wrong_file("text"), tmp_path / "rows.csv", tmp_path / "annotated.tlog"
    code, _, _ = attest_mav("replay", bad, "--csv", rows, "--tlog", annotated)
    assert code == 65
    assert sorted(path.name for path in tmp_path.iterdir()) == [bad.name]


def test_as_a_process_it_is_silent_in_a_pipe_and_shows_no_traceback(command, tmp_path):
    done = subprocess.run([*command, "replay", str(LAPS), "--json"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.splitlines()) == 1
    failed = subprocess.run(
        [*command, "replay", str(tmp_path / "none.tlog")], capture_output=True, text=True, check=False
    )
    assert failed.returncode == 65
    assert_one_line(failed.stderr, "none.tlog")
