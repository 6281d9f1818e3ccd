"""Logs made to cost: each is read or refused within bounds of memory and time."""

import struct
import time
import tracemalloc
from contextlib import suppress

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.formats import open_source
from attest_mav.mavlink.wire.checksum import with_checksum

MOST_BYTES = 60_000_000
MOST_S = 20.0
"""Without the bounds that these logs are for, minutes or gigabytes."""
FMT = struct.Struct("<3sBB4s16s64s")
ULOG = b"ULog\x01\x12\x35\x01" + bytes(8)


def fmt(kind, length, name, letters, columns):
    return FMT.pack(b"\xa3\x95\x80", kind, length, name, letters, columns)


def message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def ulog_with(*messages):
    return ULOG + message("B", bytes(40)) + b"".join(messages)


def nested():
    """Formats of empty ones, ten to the fortieth of them, in 400 bytes."""
    formats = [message("F", b"z0:")]
    formats += [message("F", b"z%d:z%d[99999] a;" % (k, k - 1)) for k in range(1, 8)]
    return ulog_with(*formats, message("A", b"\0\1\0z7"))


def wide():
    """Topics of 60,000 fields, each in thirty bytes."""
    topics = ((message("F", b"t%d:uint8_t[60000] x;" % k), message("A", b"\0\1\0t%d" % k)) for k in range(100))
    return ulog_with(*[one for both in topics for one in both])


def descriptions():
    return b"".join(fmt(k % 255, 11, b"A%03d" % (k % 1000), b"Q", b"TimeUS,%d" % k) for k in range(5_000))


def text_descriptions():
    return b"".join(b"FMT, %d, 11, N%d, Q, TimeUS\n" % (k % 255, k) for k in range(5_000))


LOGS = {
    "formats inside formats": nested,
    "wide topics": wide,
    "giant lengths": lambda: ulog_with((struct.pack("<HB", 65535, ord("M")) + b"\0\0") * 10_000),
    "texts everywhere": lambda: ulog_with(b"FFF:" + b"FFFFF" * 8_000),
    "many descriptions": descriptions,
    "many descriptions in text": text_descriptions,
    "headers inside records": lambda: fmt(10, 255, b"ABC", b"", b"") + b"\xa3\x95\x0a" * 20_000,
    "one line": lambda: b"FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n" + b"," * 300_000,
    "magic everywhere": lambda: bytes(8) + b"\xfd\xff\0\0\0\1\1\0\0\0" * 4_000,
}


@pytest.mark.parametrize("name", LOGS)
def test_a_hostile_log_costs_little(name):
    data = LOGS[name]()
    tracemalloc.start()
    begin = time.monotonic()
    with suppress(UnreadableDataError):
        open_source(data, name).summary()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < MOST_BYTES
    assert time.monotonic() - begin < MOST_S


def test_a_crowd_of_senders_is_counted_but_not_remembered(dialect):
    layout = dialect.layout("HEARTBEAT")
    payload = layout.from_dict({"type": 2, "autopilot": 3})
    data = b""
    for sender in range(9_000):
        head = bytes((0xFE, len(payload), 0, 1 + sender % 255, sender // 255, 0))
        data += struct.pack(">Q", 1_700_000_000_000_000 + sender) + with_checksum(head + payload, layout.crc_extra)
    summary = open_source(data, "crowd").summary()
    assert summary.messages == 9_000
    assert len(summary.vehicles) == 8192
