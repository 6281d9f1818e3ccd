"""Settings in a log: a ground station's download of all parameters, among which two matter."""

from math import nan

import pytest

from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.logs.tlog.reader import read_windows
from attest_mav.logs.tlog.survey import Survey
from attest_mav.replay.engine import Request, replay
from attest_mav.replay.facts import facts_of
from attest_mav.replay.flight import Window
from attest_mav.replay.report import as_json
from attest_mav.types import Setting

INT16 = 4


def tell(log, name, value, t_ms=0, sender=(1, 1)):
    log.add("PARAM_VALUE", t_ms, {"param_id": name, "param_value": value, "param_type": INT16}, sender)


def download(log, settings, count=1200, sender=(1, 1)):
    """All parameters; those named in ``settings`` stand near the end, where few frames of a kind are sampled."""
    for index in range(count):
        tell(log, b"OTHER_%d" % index, 1.0, sender=sender)
    for name, value in settings.items():
        tell(log, name, value, sender=sender)
    tell(log, b"LAST", 1.0, sender=sender)


def survey_of(log):
    survey, given = Survey(log.dialect), []
    for frames in read_windows(log.data, survey.census):
        survey.take(frames)
        given += frames
    return survey, given


def report(log, *filters):
    result = replay(log.data, log.dialect, Request(filters, window=Window(skip_s=0.0)), log.outputs)
    return result, [note for note in as_json("log", "tlog", result)["notes"] if " takes the " in note]


@pytest.fixture
def log(log):
    from attest_mav.replay.engine import Outputs  # noqa: PLC0415

    log.outputs = Outputs()
    return log


def test_of_a_whole_download_only_the_settings_are_decoded(log):
    log.heartbeat()
    download(log, {b"INS_GYRO_FILTER": 42.0, b"GPS_DELAY_MS": 220.0})
    survey, given = survey_of(log)
    assert [frame.message_id for frame in given].count(log.dialect.id_of("PARAM_VALUE")) == 2
    assert survey.count((1, 1), "PARAM_VALUE") == 1203
    told = {sample.setting: (sample.name, sample.value) for sample in survey.told((1, 1))}
    assert told == {
        Setting.LOW_PASS_HZ: ("INS_GYRO_FILTER", 42.0),
        Setting.FIX_DELAY_S: ("GPS_DELAY_MS", pytest.approx(0.22)),
    }
    assert survey.told((2, 1)) == []


def test_a_name_that_fills_its_field_and_one_that_is_cut_are_no_settings(log):
    tell(log, b"INS_GYRO_FILTERS", 42.0)
    tell(log, b"INS_GYRO_FILTE", 42.0)
    log.add("PARAM_VALUE", 0, {})
    assert survey_of(log)[0].parameters == {}


def test_a_filter_is_informed_from_the_start_and_a_note_says_so(log):
    log.heartbeat()
    log.still_flight(3.0)
    download(log, {b"INS_GYRO_FILTER": 42.0, b"GPS1_DELAY_MS": 220.0})
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
    fixed = VelocityAided(FlightParameters(), low_pass_open=False)
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


@pytest.mark.parametrize(("autopilot", "hz"), [(12, 0.0), (3, nan), (None, nan)])
def test_the_firmware_tells_too(autopilot, hz):
    facts = facts_of(autopilot, [])
    assert repr((facts.low_pass_hz, facts.fix_delay_s)) == repr((hz, nan))


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
        result = replay(log.data, log.dialect, Request((VelocityAided(),), window=Window(skip_s=0.0)), log.outputs)
        q = result.flight.runs[0].pipeline.estimate.q_nb
        headings[hz] = 2.0 * q[3] / q[0]
    assert headings[2.0] - headings[20.0] == pytest.approx(0.3 * (0.1125 - 0.01125), rel=0.05)
