"""Frames as bytes without their signatures, for records that other people may read."""

from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.mavlink.wire.frame import HEADER_V2, MAGIC_V1, MAGIC_V2, SIGNED, Frame, message_id_at


def plain_frame(frame: Frame, dialect: Dialect) -> bytes:
    """A frame that was received, in its own version of MAVLink."""
    payload = frame.payload
    sender = bytes((frame.sequence, frame.system, frame.component))
    if frame.version == 1:
        head = bytes((MAGIC_V1, len(payload))) + sender + bytes((frame.message_id,))
    else:
        head = bytes((MAGIC_V2, len(payload), 0, 0)) + sender + int(frame.message_id).to_bytes(3, "little")
    return with_checksum(head + payload, dialect.by_id[frame.message_id].crc_extra)


def without_signature(frame: bytes, dialect: Dialect) -> bytes:
    """A whole frame that is to be sent."""
    if frame[0] != MAGIC_V2 or frame[2] & SIGNED == 0:
        return frame
    head = frame[:2] + bytes((frame[2] & ~SIGNED,)) + frame[3 : HEADER_V2 + frame[1]]
    return with_checksum(head, dialect.by_id[message_id_at(frame, 0)].crc_extra)
