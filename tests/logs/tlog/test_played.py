"""A tlog as a vehicle that sends its frames again."""

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.tlog.played import LONGEST_PAUSE_NS, PlayedLog

SECOND = 1_000_000_000


def test_frames_come_at_their_times_and_in_their_order(dialect, log):
    for k in range(10):
        log.imu(1000 + 100 * k)
    played = PlayedLog(log.data, dialect)
    assert played.next_deadline_ns == 0
    first = played.frames_until(0)
    assert len(first) == 1
    due = played.next_deadline_ns
    assert played.frames_until(due - 1) == []
    rest = played.frames_until(100 * SECOND)
    assert played.next_deadline_ns is None
    assert played.frames_until(200 * SECOND) == []
    assert b"".join([*first, *rest]) == bytes(
        byte for start in range(0, len(log.data), len(log.data) // 10) for byte in record(log.data, start, 10)
    )
    assert played.sent == 10


def record(data, start, count):
    """The frame of a record: all but its eight bytes of time."""
    return data[start + 8 : start + len(data) // count]


def test_ground_stations_and_our_own_frames_are_left_out(dialect, log):
    log.heartbeat()
    log.heartbeat(sender=(255, 190))
    log.heartbeat(sender=(1, 193))
    log.imu(1000)
    played = PlayedLog(log.data, dialect)
    assert len(played.frames_until(100 * SECOND)) == 2


def test_a_clock_that_was_set_stops_nothing(dialect, log):
    log.imu(1000)
    one = log.data
    back = (int.from_bytes(one[:8], "big") - 5_000_000).to_bytes(8, "big") + one[8:]
    ahead = (int.from_bytes(one[:8], "big") + 86_400_000_000).to_bytes(8, "big") + one[8:]
    played = PlayedLog(one + back + ahead, dialect)
    assert len(played.frames_until(0)) == 2
    assert 0 < played.next_deadline_ns <= LONGEST_PAUSE_NS
    assert len(played.frames_until(LONGEST_PAUSE_NS)) == 1


def test_a_log_without_a_vehicle_is_refused(dialect, log):
    log.heartbeat(sender=(255, 190))
    with pytest.raises(UnreadableDataError, match="no frame of a vehicle"):
        PlayedLog(log.data, dialect)
