"""Damaged logs: every intact frame is found, and nothing that is none."""

import random

import pytest
from pymavlink import mavutil

from attest_mav.logs.tlog.reader import TlogReader

REPLACED = -1
"""The origin of a byte that is not the log's own."""


class Damage:
    """Edits a log and remembers, byte by byte, where what is left came from."""

    def __init__(self, log: bytes) -> None:
        self.data = bytearray(log)
        self.origin = list(range(len(log)))

    def overwrite(self, at: int, new: bytes) -> None:
        for index, byte in enumerate(new, at):
            if index < len(self.data) and self.data[index] != byte:
                self.data[index] = byte
                self.origin[index] = REPLACED

    def insert(self, at: int, new: bytes) -> None:
        self.data[at:at] = new
        self.origin[at:at] = [REPLACED] * len(new)

    def delete(self, at: int, count: int) -> None:
        del self.data[at : at + count]
        del self.origin[at : at + count]

    def intact(self, records: list[tuple[int, int, int]]) -> list[tuple[int, int]]:
        """(start, size) in the damaged log of every frame that still has all its bytes in a row."""
        where = {origin: index for index, origin in enumerate(self.origin) if origin != REPLACED}
        found = []
        for _, start, end in records:
            at = where.get(start)
            if at is not None and self.origin[at : at + end - start] == list(range(start, end)):
                found.append((at, end - start))
        return found


def random_bytes(rng: random.Random, log: bytes, count: int) -> bytes:
    """What damage looks like: noise, one value, many magic bytes, or another part of the log."""
    kind = rng.randrange(4)
    if kind == 0:
        return rng.randbytes(count)
    if kind == 1:
        return bytes([rng.choice((0, 0xFF, 0xFD, 0xFE))]) * count
    if kind == 2:
        return bytes(rng.choice((0xFD, 0xFE, 0, 1, 27, 30)) for _ in range(count))
    start = rng.randrange(len(log) - count)
    return log[start : start + count]


def damaged(log: bytes, rng: random.Random) -> Damage:
    damage = Damage(log)
    for _ in range(rng.randint(20, 120)):
        at = rng.randrange(len(damage.data))
        count = rng.choice((1, 1, 2, 5, 20, 100, 700))
        what = rng.randrange(3)
        if what == 0:
            damage.overwrite(at, random_bytes(rng, log, count))
        elif what == 1:
            damage.insert(at, random_bytes(rng, log, count))
        else:
            damage.delete(at, count)
    return damage


def spans(frames):
    return [(frame.offset, frame.size) for frame in frames]


@pytest.mark.parametrize("name", ["copter_start", "plane_turn"])
@pytest.mark.parametrize("seed", range(8))
def test_every_intact_frame_is_found_and_no_other(dialect, request, name, seed):
    log = request.getfixturevalue(name)
    damage = damaged(log, random.Random(seed))
    expected = set(damage.intact(request.getfixturevalue(f"{name}_records")))
    found = set(spans(TlogReader(bytes(damage.data), dialect)))
    assert expected - found == set()
    # Copies of other parts of the log bring whole frames with them: anything more must be one of the log's own.
    extra = [bytes(damage.data[at : at + size]) for at, size in found - expected]
    assert [frame for frame in extra if frame not in log] == []


def test_what_poisons_pymavlinks_search_loses_nothing_here(dialect, copter_start, copter_start_records, tmp_path):
    """A magic byte, a length and an unknown id in front of the log: pymavlink believes the length."""
    damage = Damage(copter_start)
    for _, _, end in copter_start_records[10:1000:20]:
        damage.overwrite(end + 8, bytes.fromhex("fd ff 00 00 00 01 01 5f ea 00"))
    expected = damage.intact(copter_start_records)
    log = bytes(damage.data)
    path = tmp_path / "damaged.tlog"
    path.write_bytes(log)
    oracle = mavutil.mavlogfile(str(path))
    theirs = 0
    while (message := oracle.recv_match()) is not None:
        theirs += not message.get_type().startswith(("BAD_DATA", "UNKNOWN"))
    oracle.close()
    assert spans(TlogReader(log, dialect)) == expected
    assert theirs < len(expected), "if pymavlink has mended this, say so in the documents"


def test_every_frame_of_the_flight_survives_heavy_damage(dialect, data_folder):
    log = (data_folder / "sitl" / "copter_square.tlog").read_bytes()[: 1 << 20]
    damage = damaged(log, random.Random(99))
    records = []
    start = 0
    while start + 20 < len(log):
        end = start + 20 + log[start + 9]
        records.append((start, start + 8, end))
        start = end
    found = set(spans(TlogReader(bytes(damage.data), dialect)))
    assert set(damage.intact(records)) - found == set()


def test_noise_alone_gives_nothing_and_is_all_bad(dialect):
    rng = random.Random(4)
    noise = rng.randbytes(100_000)
    reader = TlogReader(noise, dialect)
    assert len(list(reader)) <= 1  # one checksum in 65536 fits by chance
    assert reader.bad_bytes >= 99_700
