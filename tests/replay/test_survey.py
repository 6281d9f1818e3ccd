from collections import Counter

import pytest

from attest_mav.logs.tlog.census import EVERY, FIRST
from attest_mav.logs.tlog.reader import TlogReader, read_windows
from attest_mav.logs.tlog.survey import Survey


def survey_of(data, dialect):
    survey, given = Survey(dialect), []
    for frames in read_windows(data, survey.census):
        survey.take(frames)
        given += frames
    return survey, given


def test_counts_and_times_equal_those_of_reading_every_frame(data_cut, dialect):
    damaged = data_cut[:70_000] + b"\xfd garbage" + data_cut[70_000:-3]
    survey, _ = survey_of(damaged, dialect)
    reader = TlogReader(damaged, dialect)
    frames = list(reader)
    counted = Counter(dialect.name_of(frame.message_id) for frame in frames)
    assert {name: survey.count((1, 1), name) for name in counted} == counted
    assert survey.senders() == [(1, 1)]
    assert survey.duration_s == (frames[-1].rx_ns - frames[0].rx_ns) * 1e-9
    for counter in ("frames", "bad_bytes", "bad_crc", "unknown", "lost"):
        assert getattr(survey.census, counter) == getattr(reader, counter)


def test_few_frames_are_made_but_the_first_of_each_sender_are(log):
    for k in range(1000):
        log.heartbeat(k)
        if k % 10 == 0:
            log.heartbeat(k, sender=(7, 1))
    survey, given = survey_of(log.data, log.dialect)
    assert survey.count((1, 1), "HEARTBEAT") == 1000
    by_sender = Counter(frame.system for frame in given)
    assert by_sender[1] == FIRST + (1000 - FIRST + EVERY - 1) // EVERY
    assert by_sender[7] == FIRST + (100 - FIRST + EVERY - 1) // EVERY


def test_only_what_flies_is_an_autopilot(log):
    log.heartbeat(autopilot=8, sender=(255, 190))
    log.heartbeat(autopilot=12, sender=(3, 1))
    survey, _ = survey_of(log.data, log.dialect)
    assert list(survey.heartbeats) == [(3, 1)]
    assert survey.autopilot((3, 1)) == 12
    assert survey.autopilot((255, 190)) is None


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
    assert (survey.velocities, survey.positions) == (set(), {})
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
