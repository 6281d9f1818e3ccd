from collections import Counter

from attest_mav.evaluation.replay.survey import Survey
from attest_mav.logs.tlog import TlogReader, read_windows
from attest_mav.mavlink.census import EVERY, FIRST


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


def test_the_first_position_with_a_fix_is_kept(log):
    log.add("GPS_RAW_INT", 0, {"fix_type": 1, "lat": 1, "lon": 1})
    log.add("GPS_RAW_INT", 1, {"fix_type": 3, "lat": 480_000_000, "lon": 110_000_000})
    log.add("GPS_RAW_INT", 2, {"fix_type": 3, "lat": 490_000_000, "lon": 120_000_000})
    survey, _ = survey_of(log.data, log.dialect)
    assert (survey.positions[1].latitude_deg, survey.positions[1].longitude_deg) == (48.0, 11.0)
