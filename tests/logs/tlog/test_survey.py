from collections import Counter
from math import isnan

import pytest

from attest_mav.logs.tlog.message_counter import EVERY, FIRST
from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.logs.tlog.survey import Survey
from attest_mav.logs.windows import read_windows
from attest_mav.vehicle_reports import FirmwareSample, HeartbeatSample, ParameterSample
from attest_mav.vehicle_settings import Setting

INT16 = 4


def survey_of(data, dialect):
    survey, given = Survey(dialect), []
    for frames in read_windows(data, survey.counter):
        survey.take(frames)
        given += frames
    return survey, given


def summary_of(log):
    return TlogSource(log.data, log.dialect).summary()


def test_counts_and_times_equal_those_of_reading_every_frame(data_cut, dialect):
    damaged = data_cut[:70_000] + b"\xfd garbage" + data_cut[70_000:-3]
    survey, _ = survey_of(damaged, dialect)
    summary = TlogSource(damaged, dialect).summary()
    reader = TlogReader(damaged, dialect)
    frames = list(reader)
    counted = Counter(dialect.name_of(frame.message_id) for frame in frames)
    assert summary.vehicles.keys() == {(1, 1)}
    assert summary.vehicles[1, 1].counts == counted
    assert summary.duration_s == (frames[-1].rx_ns - frames[0].rx_ns) * 1e-9
    assert (summary.messages, summary.bad_bytes) == (reader.frames, reader.bad_bytes)
    for counter in ("frames", "bad_bytes", "bad_crc", "unknown", "lost"):
        assert getattr(survey.counter, counter) == getattr(reader, counter)


def test_few_frames_are_made_but_the_first_of_each_sender_are(log):
    for k in range(1000):
        log.heartbeat(k)
        if k % 10 == 0:
            log.heartbeat(k, sender=(7, 1))
    _, given = survey_of(log.data, log.dialect)
    assert summary_of(log).vehicles[1, 1].count("HEARTBEAT") == 1000
    by_sender = Counter(frame.system for frame in given)
    assert by_sender[1] == FIRST + (1000 - FIRST + EVERY - 1) // EVERY
    assert by_sender[7] == FIRST + (100 - FIRST + EVERY - 1) // EVERY


def test_only_what_flies_is_an_autopilot(log):
    log.heartbeat(autopilot=8, sender=(255, 190))
    log.heartbeat(autopilot=12, sender=(3, 1))
    survey, _ = survey_of(log.data, log.dialect)
    assert list(survey.heartbeats) == [(3, 1)]
    assert survey.autopilots == {3: 12}
    assert {one.vehicle: one.is_autopilot for one in summary_of(log).vehicles.values()} == {
        (3, 1): True,
        (255, 190): False,
    }


FIX = {"fix_type": 3, "lat": 480_000_000, "lon": 110_000_000, "vel": 500, "cog": 9000}


@pytest.mark.parametrize(
    ("fields", "found"),
    [
        ({}, {1}),
        ({"fix_type": 2}, set()),
        ({"vel": 65535}, set()),
        ({"cog": 65535}, set()),
        ({"vel": 0, "cog": 65535}, {1}),  # a vehicle that stands has no course, but a velocity
    ],
)
def test_a_velocity_needs_a_fix_a_speed_and_a_course(log, fields, found):
    log.add("GPS_RAW_INT", 0, FIX | fields)
    survey, _ = survey_of(log.data, log.dialect)
    assert survey.velocities == found


def test_a_velocity_may_come_after_the_position(log):
    log.add("GPS_RAW_INT", 0, FIX | {"vel": 65535})
    log.add("GPS_RAW_INT", 1, FIX)
    survey, _ = survey_of(log.data, log.dialect)
    assert survey.velocities == {1}


def test_fixes_in_unix_time_count_once_the_vehicle_has_told_when_it_booted(log):
    unix_us = 1_780_000_000_000_000
    log.add("GPS_RAW_INT", 0, FIX | {"time_usec": unix_us})
    survey, _ = survey_of(log.data, log.dialect)
    assert (survey.velocities, survey.positions.keys()) == (set(), {1})
    log.add("SYSTEM_TIME", 1, {"time_unix_usec": unix_us, "time_boot_ms": 5000})
    log.add("GPS_RAW_INT", 2, FIX | {"time_usec": unix_us + 1})
    survey, _ = survey_of(log.data, log.dialect)
    assert (survey.velocities, survey.positions.keys()) == ({1}, {1})


def test_the_first_position_with_a_fix_is_kept(log):
    log.add("GPS_RAW_INT", 0, {"fix_type": 1, "lat": 1, "lon": 1})
    log.add("GPS_RAW_INT", 1, {"fix_type": 3, "lat": 480_000_000, "lon": 110_000_000})
    log.add("GPS_RAW_INT", 2, {"fix_type": 3, "lat": 490_000_000, "lon": 120_000_000})
    survey, _ = survey_of(log.data, log.dialect)
    assert (survey.positions[1].latitude_deg, survey.positions[1].longitude_deg) == (48.0, 11.0)


def tell(log, name, value, sender=(1, 1)):
    log.add("PARAM_VALUE", 0, {"param_id": name, "param_value": value, "param_type": INT16}, sender)


def test_of_a_whole_download_only_the_settings_are_decoded(log):
    log.heartbeat()
    for index in range(1200):
        tell(log, b"OTHER_%d" % index, 1.0)
    # The settings stand near the end, where few frames of a kind are sampled.
    tell(log, b"INS_GYRO_FILTER", 42.0)
    tell(log, b"GPS_DELAY_MS", 220.0)
    tell(log, b"LAST", 1.0)
    tell(log, b"LAST", 1.0, sender=(2, 1))
    _, given = survey_of(log.data, log.dialect)
    assert [frame.message_id for frame in given].count(log.dialect.id_of("PARAM_VALUE")) == 2
    vehicle = summary_of(log).vehicles[1, 1]
    assert vehicle.count("PARAM_VALUE") == 1203
    assert [(one.setting, one.name, one.value) for one in vehicle.parameters] == [
        (Setting.LOW_PASS_HZ, "INS_GYRO_FILTER", 42.0),
        (Setting.FIX_DELAY_S, "GPS_DELAY_MS", pytest.approx(0.22)),
    ]
    assert (vehicle.settings.low_pass_hz, vehicle.settings.fix_delay_s) == (42.0, pytest.approx(0.22))
    assert summary_of(log).vehicles[2, 1].parameters == ()


def test_a_name_that_fills_its_field_and_one_that_is_cut_are_no_settings(log):
    tell(log, b"INS_GYRO_FILTERS", 42.0)
    tell(log, b"INS_GYRO_FILTE", 42.0)
    log.add("PARAM_VALUE", 0, {})
    assert survey_of(log.data, log.dialect)[0].parameters == {}


@pytest.mark.parametrize(("autopilot", "low_pass_hz"), [(12, 0.0), (3, None), (8, None)])
def test_the_firmware_tells_a_setting_too(log, autopilot, low_pass_hz):
    log.heartbeat(autopilot=autopilot)
    settings = summary_of(log).vehicles[1, 1].settings
    assert settings.low_pass_hz == low_pass_hz if low_pass_hz is not None else isnan(settings.low_pass_hz)
    assert isnan(settings.fix_delay_s)


def trims_of(log, vehicle=(1, 1)):
    return [one.value for one in summary_of(log).vehicles[vehicle].parameters if one.setting == Setting.TRIM_X]


@pytest.mark.parametrize("sender", [(1, 190), (255, 190), (255, 230)])
def test_parameters_that_a_ground_station_recorded_are_the_vehicles_where_it_tells_none(log, sender):
    log.heartbeat()
    tell(log, b"AHRS_TRIM_X", 0.25, sender=sender)
    tell(log, b"INS_GYRO_FILTER", 4.0, sender=sender)
    assert trims_of(log) == [0.25]
    assert summary_of(log).vehicles[1, 1].settings.low_pass_hz == 4.0
    assert summary_of(log).vehicles[sender].parameters != (), "its own words stay its own"


@pytest.mark.parametrize("own_first", [True, False])
def test_the_autopilots_own_word_wins(log, own_first):
    log.heartbeat()
    for sender in sorted([(1, 1), (1, 190), (255, 190)], reverse=not own_first):
        tell(log, b"AHRS_TRIM_X", 0.5 if sender == (1, 1) else 0.25, sender=sender)
    assert trims_of(log) == [0.5]


def test_a_ground_station_that_may_mean_another_vehicle_is_not_believed(log):
    log.heartbeat()
    log.heartbeat(sender=(2, 1))
    tell(log, b"AHRS_TRIM_X", 0.25, sender=(255, 190))
    assert trims_of(log) == []
    tell(log, b"AHRS_TRIM_X", 0.125, sender=(2, 190))
    assert (trims_of(log), trims_of(log, (2, 1))) == ([], [0.125])


def test_the_opening_holds_first_values_the_firmware_and_the_first_heartbeat(log):
    for number in range(100):
        log.add("STATUSTEXT", number, {"severity": 6, "text": b"nothing new"})
    log.add("STATUSTEXT", 100, {"severity": 6, "text": b"ArduCopter V4.1.1 (0a1b2c3d)"})
    log.heartbeat()
    tell(log, b"AHRS_TRIM_X", 0.25)
    tell(log, b"AHRS_TRIM_X", 0.5)
    opening = summary_of(log).vehicles[1, 1].opening
    assert [one.value for one in opening if isinstance(one, ParameterSample)] == [0.25]
    assert [one.version for one in opening if isinstance(one, FirmwareSample)] == [(4, 1, 1)]
    assert [(one.autopilot, one.vehicle_type) for one in opening if isinstance(one, HeartbeatSample)] == [(3, 2)]


def test_a_change_tells_nothing_of_the_time_before_and_a_ground_stations_list_does(log):
    log.heartbeat()
    change = {"param_id": b"AHRS_TRIM_X", "param_value": 0.5, "param_type": 9, "param_index": 65535}
    log.add("PARAM_VALUE", 0, change)
    tell(log, b"AHRS_TRIM_X", 0.5)
    assert [one for one in summary_of(log).vehicles[1, 1].opening if isinstance(one, ParameterSample)] == []
    tell(log, b"AHRS_TRIM_X", 0.25, sender=(1, 190))
    vehicle = summary_of(log).vehicles[1, 1]
    assert [one.value for one in vehicle.opening if isinstance(one, ParameterSample)] == [0.25]
    assert trims_of(log) == [0.5]
