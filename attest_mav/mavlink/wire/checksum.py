"""MAVLink's checksum (CRC-16/MCRF4XX, the guide calls it X.25), at the speed of the standard library.

MAVLink's CRC is the bit-reflection of the one that ``binascii.crc_hqx`` computes: reverse the bits of every byte of
the message, run ``crc_hqx`` from 0xFFFF, and the result is the checksum with its sixteen bits reversed. The sender
puts the low byte first on the wire, so in the mirrored message the two checksum bytes read as one big-endian number:
no result is ever reversed. A whole buffer is mirrored once and then serves every frame in it.
"""

from binascii import crc_hqx
from struct import Struct
from typing import Final

from mypy_extensions import i64

MIRROR: Final = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))
"""Every byte with its bits reversed, for ``bytes.translate``."""

_BIG_ENDIAN: Final = Struct(">H")

_CRC: Final = crc_hqx
"""A constant of the module is found faster than an imported name once compiled."""

_START: Final = 0xFFFF

_STEP: Final = [crc_hqx(bytes([byte]), 0) for byte in range(256)]
"""One step of the CRC from zero, for a byte that is known as a number."""


def mirrored(data: bytes) -> bytes:
    """data with the bits of every byte reversed."""
    return data.translate(MIRROR)


def mirrored_crc(mirror: bytes, start: i64, stop: i64, mirrored_extra: i64) -> i64:
    """Checksum of the mirrored bytes start to stop, and the message's CRC extra (mirrored), with reversed bits."""
    return stepped(_CRC(mirror[start:stop], _START), mirrored_extra)


def stepped(crc: i64, mirrored_byte: i64) -> i64:
    """The register ``crc`` after one more byte."""
    index: i64 = (crc >> 8) ^ mirrored_byte
    step: i64 = _STEP[index]
    return ((crc << 8) & 0xFF00) ^ step


def explaining_extra(mirror: bytes, start: i64, stop: i64) -> i64:
    """The mirrored CRC extra with which bytes start to stop fit the checksum at stop, or -1 when none does.

    One in 256 random candidates is explained by some extra.
    """
    crc: i64 = _CRC(mirror[start:stop], _START)
    wire: i64 = (mirror[stop] << 8) | mirror[stop + 1]
    needed: i64 = wire ^ ((crc << 8) & 0xFF00)
    index: i64 = 0
    while index < 256:
        step: i64 = _STEP[index]
        if step == needed:
            return index ^ (crc >> 8)
        index += 1
    return -1


def with_checksum(frame: bytes, crc_extra: i64) -> bytes:
    """A frame, given from its magic to the end of its payload, with its checksum behind it."""
    crc = mirrored_crc(mirrored(frame), 1, len(frame), MIRROR[crc_extra])
    return frame + mirrored(_BIG_ENDIAN.pack(crc))
