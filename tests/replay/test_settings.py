"""Settings of the vehicle in a log, and the filters that take them."""

from math import nan

import pytest

from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window

INT16 = 4


def tell(log, name, value, t_ms=0, sender=(1, 1)):
    log.add("PARAM_VALUE", t_ms, {"param_id": name, "param_value": value, "param_type": INT16}, sender)


def report(log, *filters):
    result = replay(TlogSource(log.data, log.dialect), Request(filters, window=Window(skip_s=0.0)), Outputs())
    return result, [note for note in as_json("log", result)["notes"] if " takes the " in note]


def test_a_filter_is_informed_from_the_start_and_a_note_says_so(log):
    log.heartbeat()
    log.still_flight(3.0)
    tell(log, b"INS_GYRO_FILTER", 42.0)
    tell(log, b"GPS1_DELAY_MS", 220.0)
    result, notes = report(log, VelocityAided(), GradientDescent())
    assert notes == [
        "velocity-aided takes the gyro low-pass from the log's INS_GYRO_FILTER: 42 Hz instead of 20 Hz",
        "velocity-aided takes the GPS delay from the log's GPS1_DELAY_MS: 0.22 s instead of 0.1 s",
    ]
    assert [run.comparison.name for run in result.flight.runs] == ["velocity-aided", "gradient-descent"]


def test_the_last_word_counts(log):
    log.heartbeat()
    log.still_flight(1.0)
    for value in (30.0, 80.0, 42.0):
        tell(log, b"INS_GYRO_FILTER", value)
    assert "42 Hz" in report(log, VelocityAided())[1][0]


@pytest.mark.parametrize(
    ("name", "value"), [(b"INS_GYRO_FILTER", 20.0), (b"GPS_DELAY_MS", 0.0), (b"GPS_DELAY_MS", 100.0)]
)
def test_what_changes_nothing_needs_no_note(log, name, value):
    log.heartbeat()
    log.still_flight(1.0)
    tell(log, name, value)
    assert report(log, VelocityAided())[1] == []


def test_neither_a_fixed_parameter_nor_a_filter_that_has_none_needs_a_note(log):
    log.heartbeat()
    log.still_flight(1.0)
    tell(log, b"INS_GYRO_FILTER", 42.0)
    fixed = VelocityAided(FlightParameters(), low_pass_from_vehicle=False)
    assert report(log, fixed, GradientDescent())[1] == []


def test_parameters_of_others_are_not_taken(log):
    log.heartbeat()
    log.heartbeat(sender=(2, 1))
    log.still_flight(1.0)
    for sender in ((2, 1), (1, 100), (255, 190)):
        tell(log, b"INS_GYRO_FILTER", 42.0, sender=sender)
    assert report(log, VelocityAided())[1] == []


def test_a_value_that_cannot_be_meant_is_not_taken(log):
    log.heartbeat()
    log.still_flight(1.0)
    for value in (nan, -5.0, 1e9):
        tell(log, b"INS_GYRO_FILTER", value)
    assert report(log, VelocityAided())[1] == []


def test_the_informed_filter_shows_a_turn_earlier_or_later(log):
    """A vehicle that turns at 0.3 rad/s: a low-pass of 2 Hz delays its gyro by 112.5 ms, one of 20 Hz by 11.25 ms."""
    headings = {}
    for hz in (2.0, 20.0):
        log.data = b""
        log.heartbeat()
        tell(log, b"INS_GYRO_FILTER", hz)
        for k in range(200):
            turning = k >= 150
            log.add(
                "RAW_IMU",
                1000 + 20 * k,
                {"time_usec": 1_000_000 + 20_000 * k, "zacc": -1000, "zmag": 440, "zgyro": 300 if turning else 0},
            )
        result = replay(
            TlogSource(log.data, log.dialect), Request((VelocityAided(),), window=Window(skip_s=0.0)), Outputs()
        )
        q = result.flight.runs[0].pipeline.estimate.q_nb
        headings[hz] = 2.0 * q[3] / q[0]
    assert headings[2.0] - headings[20.0] == pytest.approx(0.3 * (0.1125 - 0.01125), rel=0.05)
