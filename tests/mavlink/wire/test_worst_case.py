"""Bytes that are made to be candidates everywhere: they cost little, and no frame among them is lost."""

import time
from random import Random

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.wire.checksum import checksum
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.mavlink.wire.running_checksum import MAX_LENGTH, RunningChecksum

SIZE = 60_000
HOSTILE = {
    "FE": b"\xfe",
    "FE F8": b"\xfe\xf8",
    "FE FE F8": b"\xfe\xfe\xf8",
    "FE 83": b"\xfe\x83",
    "FD FF 00 00": b"\xfd\xff\x00\x00",
    "FD FD": b"\xfd\xfd\x00\x00\x00\xfe\xfd\x00\x00\x00",
    "FILE_TRANSFER_PROTOCOL": b"\xfd\xff\x00\x00\x00\x01\x01\x6e\x00\x00",
}


def cost(dialect, data):
    """Processor time of one pass, s; the best of five."""
    times = []
    for _ in range(5):
        framer = Framer(dialect, None)
        begin = time.process_time()
        framer.feed(data, 0)
        times.append(time.process_time() - begin)
    return min(times)


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_bytes_cost_at_most_ten_times_heartbeats(dialect, sender, name):
    pattern = HOSTILE[name]
    beat = sender.pack(pymav.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3))
    normal = cost(dialect, beat * (SIZE // len(beat)))
    assert cost(dialect, pattern * (SIZE // len(pattern))) < 10.0 * normal


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("chunk", [64, SIZE])
def test_no_frame_among_hostile_bytes_is_lost(dialect, sender, name, chunk):
    noise = HOSTILE[name] * (6000 // len(HOSTILE[name]))
    frames = [sender.pack(pymav.MAVLink_attitude_message(number, 0.1, 0.2, 0.3, 0, 0, 0)) for number in range(20)]
    data = b"".join(noise + frame for frame in frames) + bytes(600)
    framer = Framer(dialect, None)
    found = [one for at in range(0, len(data), chunk) for one in framer.feed(data[at : at + chunk], 0)]
    sequences = [one.sequence for one in found if one.message_id == pymav.MAVLINK_MSG_ID_ATTITUDE]
    assert sequences == list(range(20))


def test_the_running_checksum_is_pymavlinks():
    random = Random(1)
    data = random.randbytes(3000)
    running = RunningChecksum(data, [None] * MAX_LENGTH)
    for _ in range(300):
        start = random.randrange(2700)
        stop = start + random.randrange(1, MAX_LENGTH)
        extra = random.randrange(256)
        assert running.crc(start, stop, extra) == pymav.x25crc(data[start:stop] + bytes([extra])).crc
        assert running.crc(start, stop, extra) == checksum(data, start, stop, extra)


def test_a_mavlink_1_frame_longer_than_its_message_is_none_and_the_next_one_is_found(dialect, sender):
    beat = sender.pack(pymav.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3), "v1")
    framer = Framer(dialect, None)
    assert len(framer.feed(b"\xfe\xff\x00\x01\x01\x00" + beat + bytes(10), 0)) == 1
