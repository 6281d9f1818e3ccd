"""MAVLink's checksum, CRC-16/MCRF4XX, which the guide calls X.25; the library that pymavlink uses too computes it."""

from struct import Struct
from typing import Final

from fastcrc.crc16 import mcrf4xx
from mypy_extensions import i64

_LITTLE_ENDIAN: Final = Struct("<H")

_CRC: Final = mcrf4xx
"""A constant of the module is found faster than an imported name once compiled."""

_STEP: Final = [mcrf4xx(bytes([byte]), 0) for byte in range(256)]
"""One step of the CRC from zero, for a byte that is known as a number."""


def checksum(data: bytes, start: i64, stop: i64, extra: i64) -> i64:
    """Checksum of the bytes start to stop, and of the message's CRC extra."""
    return stepped(_CRC(data[start:stop]), extra)


def stepped(crc: i64, byte: i64) -> i64:
    """The register ``crc`` after one more byte."""
    index: i64 = (crc ^ byte) & 0xFF
    step: i64 = _STEP[index]
    return (crc >> 8) ^ step


def explaining_extra(data: bytes, start: i64, stop: i64) -> i64:
    """The CRC extra with which bytes start to stop fit the checksum at stop, or -1 when none does.

    One in 256 random candidates is explained by some extra.
    """
    crc: i64 = _CRC(data[start:stop])
    needed: i64 = checksum_at(data, stop) ^ (crc >> 8)
    index: i64 = 0
    while index < 256:
        step: i64 = _STEP[index]
        if step == needed:
            return index ^ (crc & 0xFF)
        index += 1
    return -1


def checksum_at(data: bytes, at: i64) -> i64:
    """The checksum that was received with a frame, low byte first."""
    return data[at] | (data[at + 1] << 8)


def with_checksum(frame: bytes, crc_extra: i64) -> bytes:
    """A frame, given from its magic to the end of its payload, with its checksum behind it."""
    return frame + _LITTLE_ENDIAN.pack(checksum(frame, 1, len(frame), crc_extra))
