"""Frames that are read and changed on their way."""

from typing import Final

from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.mavlink.wire.frame import CHECKSUM_BYTES, HEADER_V2

TIMES: Final = {"time_boot_ms": 1, "time_usec": 1000}
"""Fields with a time of the vehicle's clock: units in a millisecond."""
MILLISECONDS: Final = 2**32
"""time_boot_ms begins again after so many."""


def message_id(frame: bytes) -> int:
    """The message id of a frame of MAVLink 2."""
    return int.from_bytes(frame[7:10], "little")


def edited(dialect: Dialect, frame: bytes, **values: float) -> bytes:
    """The frame with other values in these fields."""
    layout = dialect.by_id[message_id(frame)]
    payload = layout.from_dict(layout.as_dict(frame[HEADER_V2:-CHECKSUM_BYTES]) | values)
    payload = payload.rstrip(b"\0") or payload[:1]
    head = frame[:1] + bytes((len(payload),)) + frame[2:HEADER_V2]
    return with_checksum(head + payload, layout.crc_extra)


def with_sender(dialect: Dialect, frame: bytes, system: int, skipped: int = 0) -> bytes:
    """The frame under another system id, and with another sequence number."""
    head = bytearray(frame[:-CHECKSUM_BYTES])
    head[4] = (head[4] + skipped) % 256
    head[5] = system
    return with_checksum(bytes(head), dialect.by_id[message_id(frame)].crc_extra)


def shifted(dialect: Dialect, frame: bytes, shift_ms: int) -> bytes:
    """The frame with another time of the vehicle's clock."""
    values = dialect.by_id[message_id(frame)].as_dict(frame[HEADER_V2:-CHECKSUM_BYTES])
    changes: dict[str, int] = {}
    for field, units in TIMES.items():
        old = values.get(field)
        if isinstance(old, int):
            moved = old + shift_ms * units
            changes[field] = moved % MILLISECONDS if units == 1 else max(0, moved)
    return edited(dialect, frame, **changes) if changes else frame
