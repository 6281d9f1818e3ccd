"""tlogs against pymavlink, cut, stamped wrongly, and in windows of any size."""

import collections
import mmap
import random
import struct
import tracemalloc

import pytest
from pymavlink import mavutil

from attest_mav.logs.tlog.reader import TlogReader, tlog_record
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.logs.tlog.walker import MARGIN, TlogWalker
from attest_mav.replay.plan import make_plan
from attest_mav.samples import ImuSample

TOTALS = {
    "sitl/copter_square.tlog": 158210,
    "sitl/plane_circles.tlog": 185668,
    "public/vtol_4hz.tlog": 23894,
}
"""Messages that pymavlink's recv_match gives, counted once with pymavlink 2.4.50."""


def raw(log, frames):
    return [log[frame.offset : frame.offset + frame.size] for frame in frames]


@pytest.mark.parametrize("name", TOTALS)
def test_frame_totals_of_the_flights_equal_pymavlinks(dialect, data_folder, name):
    with (data_folder / name).open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as log:
        reader = TlogReader(log, dialect, frozenset())
        assert list(reader) == []
        assert (reader.frames, reader.bad_bytes, reader.bad_crc, reader.unknown) == (TOTALS[name], 0, 0, 0)


@pytest.mark.parametrize("name", ["copter_start", "plane_turn"])
def test_every_message_and_time_is_pymavlinks(dialect, request, tmp_path, name):
    log = request.getfixturevalue(name)
    path = tmp_path / "cut.tlog"
    path.write_bytes(log)
    oracle = mavutil.mavlogfile(str(path))
    theirs = []
    while (message := oracle.recv_match()) is not None:
        if message.get_type() != "BAD_DATA":
            theirs.append((bytes(message.get_msgbuf()), round(message._timestamp * 1e6)))
    oracle.close()
    frames = list(TlogReader(log, dialect))
    assert list(zip(raw(log, frames), (frame.rx_ns // 1000 for frame in frames), strict=True)) == theirs


def test_the_vtol_flight_agrees_with_mavlogfile_type_by_type(dialect, data_folder):
    """Version 1 frames, from the autopilot and the ground station."""
    path = data_folder / "public" / "vtol_4hz.tlog"
    oracle = mavutil.mavlogfile(str(path))
    theirs = collections.Counter()
    while (message := oracle.recv_match()) is not None:
        theirs[message.get_type(), message.get_srcSystem()] += 1
    oracle.close()
    ours = collections.Counter(
        (dialect.name_of(frame.message_id), frame.system) for frame in TlogReader(path.read_bytes(), dialect)
    )
    assert ours == theirs


def test_raw_records_make_the_log_again(dialect, copter_start):
    reader = TlogReader(copter_start, dialect)
    assert b"".join(reader.raw_record(frame) for frame in reader) == copter_start


def test_tlog_record_is_stamp_and_frame():
    assert tlog_record(1_700_000_000_123_456_999, b"frame") == struct.pack(">Q", 1_700_000_000_123_456) + b"frame"


def test_a_log_cut_anywhere_gives_every_whole_frame(dialect, copter_start, copter_start_records):
    rng = random.Random(3)
    for _ in range(40):
        cut = rng.randrange(len(copter_start))
        log = copter_start[:cut]
        whole = [end for _, _, end in copter_start_records if end <= cut]
        reader = TlogReader(log, dialect)
        frames = list(reader)
        assert [frame.offset + frame.size for frame in frames] == whole
        assert reader.bad_bytes == cut - (whole[-1] if whole else 0)


def test_an_empty_log_has_no_frames(dialect):
    reader = TlogReader(b"", dialect)
    assert list(reader) == []
    assert (reader.frames, reader.bad_bytes) == (0, 0)


def test_a_log_that_starts_in_the_middle_of_a_record(dialect, copter_start, copter_start_records):
    _, frame, _ = copter_start_records[10]
    for start in (frame - 3, frame, frame + 5):
        log = copter_start[start:]
        ends = [end - start for _, begin, end in copter_start_records if begin >= start]
        assert [f.offset + f.size for f in TlogReader(log, dialect)] == ends


@pytest.mark.parametrize("size", [MARGIN + 400, 5000, 30000])
def test_windows_do_not_change_what_is_found(dialect, plane_turn, size):
    damaged = bytearray(plane_turn[:90000])
    rng = random.Random(size)
    for _ in range(60):
        damaged[rng.randrange(len(damaged))] ^= rng.randint(1, 255)
    damaged[40000:40000] = rng.randbytes(3000)
    log = bytes(damaged)
    whole = TlogWalker(dialect, None)
    expected = whole.walk(log, True)
    windows = TlogWalker(dialect, None)
    found = []
    final = False
    while not final:
        final = windows.position + size >= len(log)
        found += windows.walk(log[windows.position : windows.position + size], final)
    assert [(f.offset, f.size, f.rx_ns) for f in found] == [(f.offset, f.size, f.rx_ns) for f in expected]
    for counter in ("frames", "bad_bytes", "unknown", "lost", "bad_stamps"):
        assert getattr(windows, counter) == getattr(whole, counter)


def test_unknown_ids_between_records_are_passed_over(dialect, copter_start, copter_start_records):
    stamp, _, _ = copter_start_records[5]
    covered = struct.pack("<BBBBBBHB", 30, 0, 0, 0, 1, 1, 59999, 0) + b"\xfd" * 30
    foreign = (
        copter_start[stamp : stamp + 8] + b"\xfd" + covered + struct.pack("<H", mavutil.x25crc(covered + b"M").crc)
    )
    log = copter_start[:stamp] + foreign + copter_start[stamp:]
    reader = TlogReader(log, dialect)
    assert len(list(reader)) == len(copter_start_records)
    assert (reader.unknown, reader.bad_bytes, reader.bad_crc) == (1, 0, 0)


# --- times ---------------------------------------------------------------------------------------------------------


def stamped(log, records, stamps):
    """The log with other times, us."""
    return b"".join(
        struct.pack(">Q", stamp) + log[frame:end] for stamp, (_, frame, end) in zip(stamps, records, strict=True)
    )


def times(dialect, log):
    reader = TlogReader(log, dialect)
    return [frame.rx_ns // 1000 for frame in reader], reader.bad_stamps


@pytest.fixture(scope="module")
def few(copter_start, copter_start_records):
    return copter_start, copter_start_records[:40]


def test_one_damaged_time_is_replaced_by_the_one_before(dialect, few):
    log, records = few
    good = [1_700_000_000_000_000 + 20_000 * i for i in range(40)]
    for damaged in (0, 5, (1 << 64) - 1, good[7] + 3_600_000_000, good[7] - 3_600_000_000):
        stamps = [*good[:7], damaged, *good[8:]]
        assert times(dialect, stamped(log, records, stamps)) == ([*good[:7], good[6], *good[8:]], 1)


def test_a_true_step_of_the_recorders_clock_is_followed(dialect, few):
    log, records = few
    for step in (86_400_000_000, -86_400_000_000, 11_000_000, -2_000_000):
        good = [1_700_000_000_000_000 + 20_000 * i + (step if i >= 20 else 0) for i in range(40)]
        assert times(dialect, stamped(log, records, good)) == (good, 0)


def test_a_damaged_first_time_harms_no_other(dialect, few):
    log, records = few
    good = [1_700_000_000_000_000 + 20_000 * i for i in range(40)]
    got, bad = times(dialect, stamped(log, records, [12345, *good[1:]]))
    assert got[1:] == good[1:]
    assert bad == 1


def test_a_recorder_without_a_clock_is_believed(dialect, few):
    log, records = few
    good = [20_000 * i for i in range(40)]
    assert times(dialect, stamped(log, records, good)) == (good, 0)


def test_a_log_of_one_record_has_its_time(dialect, few):
    log, records = few
    assert times(dialect, stamped(log, records[:1], [1_700_000_000_000_000])) == ([1_700_000_000_000_000], 0)


# --- memory --------------------------------------------------------------------------------------------------------


class Repeated:
    """A log many times over, without being in memory many times."""

    def __init__(self, log: bytes, times: int) -> None:
        self._log = log
        self._times = times

    def __len__(self) -> int:
        return len(self._log) * self._times

    def __getitem__(self, part: slice) -> bytes:
        start = part.start % len(self._log)
        length = min(part.stop, len(self)) - part.start
        copies = self._log * (2 + length // len(self._log))
        return copies[start : start + length]


def test_memory_does_not_grow_with_the_log(dialect, copter_start, copter_start_records):
    def peak(times: int) -> int:
        reader = TlogReader(Repeated(copter_start, times), dialect)
        tracemalloc.start()
        try:
            assert sum(1 for _ in reader) == times * len(copter_start_records)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    assert peak(10) < 1.2 * peak(5)


def test_intact_frames_are_the_same_without_their_checksums(dialect, copter_start):
    checked = TlogReader(copter_start, dialect)
    frames = raw(copter_start, checked)
    assert checked.bad_bytes == checked.unknown == 0
    taken = TlogReader(copter_start, dialect, intact=True)
    assert raw(copter_start, taken) == frames
    assert (taken.frames, taken.bad_bytes, taken.lost) == (checked.frames, 0, checked.lost)


def test_bytes_that_change_behind_the_reader_end_as_frames_or_as_bad_bytes(dialect, copter_start):
    rng = random.Random(5)
    log = bytearray(copter_start[:60_000])
    for _ in range(2000):
        log[rng.randrange(len(log))] = rng.choice((0xFD, 0xFE, rng.randrange(256)))
    reader = TlogReader(bytes(log), dialect, intact=True)
    covered = sum(frame.size for frame in reader)
    assert 0 < covered <= len(log)
    assert reader.bad_bytes > 0


@pytest.mark.parametrize("is_damaged", [False, True])
def test_one_damaged_frame_has_the_second_pass_check_all(dialect, copter_start, is_damaged):
    imu = dialect.id_of("RAW_IMU")
    place = next(frame.offset for frame in TlogReader(copter_start, dialect, frozenset([imu]))) + 12
    log = copter_start[:place] + bytes([copter_start[place] ^ is_damaged]) + copter_start[place + 1 :]
    source = TlogSource(log, dialect)
    summary = source.summary()
    assert (summary.bad_bytes > 0) == is_damaged
    plan = make_plan(summary, "RAW_IMU", None)
    count = sum(isinstance(one, ImuSample) for batch in source.samples(plan) for one in batch.samples)
    assert count == summary.vehicles[plan.vehicle].counts["RAW_IMU"]
