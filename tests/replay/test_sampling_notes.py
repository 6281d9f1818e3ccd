"""Remarks on slow streams, on what could not be compared, on unfit attitudes and on a trim that nobody told."""

from math import cos, pi, radians, sin

import pytest

from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window

PERIOD_S = 5.0
ATTITUDE = 30
"""Message id."""
START_NS = 1_780_000_000_000_000_000
"""Arrival at time 0 of the logs that the fixture makes."""
BANK = radians(15.0)


def rolling(t_s, amplitude):
    """Roll (rad) and roll rate (rad/s)."""
    pulse = 2.0 * pi / PERIOD_S
    return amplitude * sin(pulse * t_s), amplitude * pulse * cos(pulse * t_s)


def flight(log, imu_hz, attitude_hz=10.0, amplitude=BANK, seconds=60.0, unit=1.0, trim_deg=0.0):
    """A vehicle that rolls to and fro in place. unit: of the attitude's angles, in radians."""
    log.heartbeat()
    log.place()
    for k in range(int(seconds * imu_hz)):
        t_ms = 1000 + 1000 * k / imu_hz
        roll, rate = rolling(t_ms * 1e-3, amplitude)
        g_mg = 1000.0
        values = {"yacc": round(-g_mg * sin(roll)), "zacc": round(-g_mg * cos(roll)), "xgyro": round(1000 * rate)}
        field = {"xmag": 200, "ymag": round(440 * sin(roll)), "zmag": round(440 * cos(roll))}
        log.add("RAW_IMU", t_ms, {"time_usec": round(1000 * t_ms), **values, **field})
    begin = log.data
    for k in range(int(seconds * attitude_hz)):
        t_ms = 1000 + 1000 * k / attitude_hz
        roll, rate = rolling(t_ms * 1e-3, amplitude)
        sent = {"roll": (roll + radians(trim_deg)) / unit, "rollspeed": rate}
        log.add("ATTITUDE", t_ms, {"time_boot_ms": round(t_ms), **sent})
    log.data = in_order(begin, log.data[len(begin) :])


def records_of(data):
    """The records of a log."""
    at = 0
    while at < len(data):
        end = at + 20 + data[at + 9]
        yield data[at:end]
        at = end


def in_order(*parts):
    """The records of some logs in order of arrival."""
    found = [record for part in parts for record in records_of(part)]
    return b"".join(sorted(found, key=lambda record: record[:8]))


def report(log, **options):
    request = Request((GradientDescent(),), window=Window(skip_s=5.0), **options)
    return as_json("log", replay(TlogSource(log.data, log.dialect), request, Outputs()))


def notes(result, part):
    return [note for note in result["notes"] if part in note]


@pytest.mark.parametrize(
    ("hz", "amplitude", "said"),
    [
        (50.0, radians(15.0), None),
        (20.0, radians(15.0), "RAW_IMU comes at 20.0 Hz: below about 50 Hz fast motion aliases, which"),
        (1.0, radians(15.0), "RAW_IMU comes at 1.0 Hz: motion is lost between samples, and the figures are no verdict"),
        (4.0, radians(130.0), "RAW_IMU comes at 4.0 Hz: motion is lost between samples"),
        (1.0, 0.0, "RAW_IMU comes at 1.0 Hz: below about 50 Hz fast motion aliases; this vehicle stands"),
    ],
)
def test_a_rate_too_low_to_judge_by_is_told(log, hz, amplitude, said):
    flight(log, hz, amplitude=amplitude)
    found = notes(report(log), "RAW_IMU comes at")
    assert len(found) == (0 if said is None else 1)
    assert said is None or found[0].startswith(said)


def test_all_estimates_between_slow_attitudes_are_compared_where_the_motion_allows(log):
    flight(log, 4.0, attitude_hz=2.7, amplitude=radians(5.0))
    result = report(log)
    (one,) = result["filters"]
    assert one["not_compared"]["uneven_reference"] == 0
    assert one["samples"] > 200
    assert notes(result, " were compared: ") == []


def test_estimates_that_are_not_compared_are_counted_and_explained(log):
    flight(log, 4.0, attitude_hz=0.4, amplitude=radians(40.0))
    result = report(log)
    (one,) = result["filters"]
    missed = one["not_compared"]["uneven_reference"]
    assert missed > 80
    (note,) = notes(result, " were compared: ")
    total = one["samples"] + missed + one["not_compared"]["no_reference"]
    assert note.startswith(f"{one['samples']} of {total} estimates of gradient-descent were compared")
    assert f"at {missed} ATTITUDE turns too unevenly between its samples" in note


def test_attitudes_that_end_early_are_named_as_the_reason(log):
    flight(log, 20.0, seconds=40.0)
    middle_us = START_NS // 1000 + 21_000_000
    log.data = b"".join(
        record
        for record in records_of(log.data)
        if int.from_bytes(record[15:18], "little") != ATTITUDE or int.from_bytes(record[:8], "big") < middle_us
    )
    result = report(log)
    assert notes(result, "there is no ATTITUDE")
    assert result["filters"][0]["not_compared"]["no_reference"] == pytest.approx(400, abs=5)


def test_an_attitude_in_degrees_is_named_and_not_compared(log):
    flight(log, 20.0, unit=radians(1.0))
    result = report(log)
    assert result["reference"] is None
    assert notes(result, "the angles of ATTITUDE are no radians (up to 15): they may be degrees; not compared")
    named = report(log, reference="ATTITUDE")
    assert named["reference"]["message"] == "ATTITUDE"
    assert notes(named, "the angles of ATTITUDE are no radians")


def test_a_steady_tilt_is_named_where_the_trim_is_not_told(log):
    flight(log, 20.0, trim_deg=2.5)
    (note,) = notes(report(log), "steady tilt")
    assert note.startswith("steady tilt of 2.5 deg against ATTITUDE, of the kind that AHRS_TRIM makes")


def test_no_steady_tilt_is_named_without_one(log):
    flight(log, 20.0)
    assert notes(report(log), "steady tilt") == []
