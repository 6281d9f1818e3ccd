"""Trims in recorded flights: the autopilot's attitudes are compared in the frame of the inertial messages."""

from math import radians

import pytest
from scipy.spatial.transform import Rotation

from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window

TRIM = (4.0, 2.0)
"""Degrees."""
TAKEN_OFF = "AHRS_TRIM 4.0, 2.0 deg taken off "


def report(data, dialect, one=None, skip_s=0.0, **options):
    request = Request((one or GradientDescent(),), window=Window(skip_s=skip_s), **options)
    return as_json("log", replay(TlogSource(data, dialect), request, Outputs()))


def tell(log, name, value, t_ms=0):
    log.add("PARAM_VALUE", t_ms, {"param_id": name, "param_value": value, "param_type": 9})


def tell_trim(log, trim=TRIM, t_ms=0):
    for name, angle in zip((b"AHRS_TRIM_X", b"AHRS_TRIM_Y"), trim, strict=True):
        tell(log, name, radians(angle), t_ms)


def say(log, text, t_ms=0):
    log.add("STATUSTEXT", t_ms, {"severity": 6, "text": text})


def stand(log, start_ms, seconds, roll_deg=0.0, pitch_deg=0.0, sent="ATTITUDE", truth=False):
    """A level vehicle whose autopilot sends these angles, 20 times a second."""
    for t_ms in range(start_ms, start_ms + int(1000 * seconds), 50):
        log.imu(t_ms)
        angles = {"roll": radians(roll_deg), "pitch": radians(pitch_deg)}
        if sent == "ATTITUDE_QUATERNION":
            vector = Rotation.from_rotvec([angles["roll"], angles["pitch"], 0.0])
            x, y, z, w = vector.as_quat()
            log.add(sent, t_ms, {"time_boot_ms": t_ms, "q1": w, "q2": x, "q3": y, "q4": z})
        else:
            log.add(sent, t_ms, angles | ({"time_boot_ms": t_ms} if sent == "ATTITUDE" else {}))
        if truth:
            log.truth(t_ms)


def trims_in(notes):
    return [note for note in notes if "taken off" in note]


@pytest.mark.parametrize("sent", ["ATTITUDE", "ATTITUDE_QUATERNION"])
def test_a_told_trim_is_taken_off_the_reference_and_named(log, dialect, sent):
    log.heartbeat()
    say(log, b"ArduCopter V4.6.1 (0a1b2c3d)")
    stand(log, 1000, 5.0, -4.0, -2.0, sent)
    tell_trim(log, t_ms=6000)
    result = report(log.data, dialect)
    assert result["filters"][0]["tilt_deg"]["max"] < 0.02
    assert trims_in(result["notes"]) == [TAKEN_OFF + sent]


def test_a_trim_that_nobody_told_stays_in(log, dialect):
    log.heartbeat()
    stand(log, 1000, 5.0, -4.0, 0.0)
    result = report(log.data, dialect)
    assert result["filters"][0]["tilt_deg"]["rms"] == pytest.approx(4.0, abs=0.01)
    assert trims_in(result["notes"]) == []


def test_px4_has_no_such_trim(log, dialect):
    log.heartbeat(autopilot=12)
    for t_ms in range(1000, 6000, 20):
        log.imu(t_ms, "HIGHRES_IMU")
        log.attitude(t_ms, 3.0)
    tell_trim(log)
    result = report(log.data, dialect)
    assert result["filters"][0]["tilt_deg"]["rms"] == pytest.approx(3.0, abs=0.01)


def test_a_trim_that_changes_in_flight_counts_from_its_parameter_on(log, dialect):
    log.heartbeat()
    tell_trim(log, (0.0, 0.0))
    stand(log, 1000, 5.0, 0.0, 0.0)
    tell_trim(log, t_ms=5999)
    stand(log, 6000, 5.0, -4.0, -2.0)
    result = report(log.data, dialect)
    assert result["filters"][0]["tilt_deg"]["max"] < 0.02
    tell_trim(log, (0.0, 0.0), t_ms=10999)
    stand(log, 11000, 5.0, 0.0, 0.0)
    result = report(log.data, dialect)
    assert result["filters"][0]["tilt_deg"]["max"] < 0.02
    assert trims_in(result["notes"]) == [TAKEN_OFF + "ATTITUDE, part of the time"]


def test_truth_is_of_the_board_and_the_autopilot_is_not(log, dialect):
    log.heartbeat()
    tell_trim(log)
    stand(log, 1000, 5.0, -4.0, -2.0, truth=True)
    result = report(log.data, dialect)
    assert result["reference"]["message"] == "SIM_STATE"
    assert result["filters"][0]["tilt_deg"]["max"] < 0.02
    assert result["autopilot"]["tilt_deg"]["max"] < 0.02
    assert trims_in(result["notes"]) == [TAKEN_OFF + "ATTITUDE"]


def banked(log, start_ms, seconds, matrix_form):
    """A vehicle that stands with 40 degrees of roll, and its attitude in one of two forms of a trim about y."""
    imu, trim = Rotation.from_euler("ZYX", [0.0, 0.0, 40.0], degrees=True), radians(8.0)
    if matrix_form:
        yaw, pitch, roll = (imu * Rotation.from_euler("y", trim).inv()).as_euler("ZYX")
    else:
        yaw, pitch, roll = 0.0, -trim, radians(40.0)
    _, y, z = imu.inv().apply([0.0, 0.0, -1000.0])
    north, _, down = 200.0, 0.0, 440.0
    x_mag, y_mag, z_mag = imu.inv().apply([north, 0.0, down])
    for t_ms in range(start_ms, start_ms + int(1000 * seconds), 50):
        fields = {"yacc": round(y), "zacc": round(z), "xmag": round(x_mag), "ymag": round(y_mag), "zmag": round(z_mag)}
        log.add("RAW_IMU", t_ms, {"time_usec": 1000 * t_ms, **fields})
        log.add("ATTITUDE", t_ms, {"time_boot_ms": t_ms, "roll": roll, "pitch": pitch, "yaw": yaw})


def test_the_form_follows_the_estimator_that_the_autopilot_names(log, dialect):
    log.heartbeat()
    tell_trim(log, (0.0, 8.0))
    banked(log, 1000, 4.0, matrix_form=False)
    say(log, b"AHRS: DCM active", 4999)
    banked(log, 5000, 4.0, matrix_form=True)
    say(log, b"AHRS: EKF3 active", 8999)
    banked(log, 9000, 4.0, matrix_form=False)
    result = report(log.data, dialect)
    assert result["filters"][0]["tilt_deg"]["max"] < 0.1
    silent = log.data.replace(b"AHRS: DCM active", b"AHRS: XXX active")
    assert report(silent, dialect)["frames"] < result["frames"], "the text with a wrong checksum is no frame"
    assert report(silent, dialect)["filters"][0]["tilt_deg"]["max"] > 1.0


def test_ahrs2_is_compared_in_the_form_of_the_secondary_estimator(log, dialect):
    log.heartbeat()
    tell_trim(log, (4.0, 0.0))
    for t_ms in range(1000, 6000, 50):
        log.imu(t_ms)
        log.attitude(t_ms, -4.0)
        log.add("AHRS2", t_ms, {"roll": radians(-4.0)})
    result = report(log.data, dialect, reference="AHRS2")
    assert result["filters"][0]["tilt_deg"]["max"] < 0.02
    assert "AHRS_TRIM 4.0, 0.0 deg taken off AHRS2" in trims_in(result["notes"])


def test_the_gyro_filter_that_a_ground_station_recorded_is_named(log, dialect):
    log.heartbeat()
    stand(log, 1000, 3.0)
    values = {"param_id": b"INS_GYRO_FILTER", "param_value": 4.0, "param_type": 4}
    log.add("PARAM_VALUE", 0, values, sender=(1, 190))
    notes = report(log.data, dialect, VelocityAided())["notes"]
    assert "velocity-aided takes the gyro low-pass from the log's INS_GYRO_FILTER: 4 Hz instead of 20 Hz" in notes


@pytest.mark.parametrize(
    ("name", "tilt_deg", "heading_deg", "note"),
    [
        ("copter_trim_told", 0.4, 1.0, "AHRS_TRIM 4.0, 2.0 deg taken off ATTITUDE"),
        ("copter_standing_trim", 0.5, 1.0, "AHRS_TRIM -2.7, -0.2 deg taken off ATTITUDE"),
        ("px4_tailsitter_repr_offset", 0.5, 1.0, None),
    ],
)
def test_flights_whose_bodies_differ(cuts, dialect, name, tilt_deg, heading_deg, note):
    """A rocking copter with a trim; a real one that stands, its trim told by a ground station; a tailsitter."""
    result = report((cuts / f"{name}.tlog").read_bytes(), dialect, VelocityAided(), skip_s=20.0)
    (ours,) = result["filters"]
    assert ours["samples"] > 200
    assert ours["tilt_deg"]["rms"] < tilt_deg
    assert ours["tilt_deg"]["max"] < 2.0 * tilt_deg
    assert ours["heading_deg"]["rms"] < heading_deg
    assert trims_in(result["notes"]) == ([] if note is None else [note])
