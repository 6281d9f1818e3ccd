"""The signature behind a frame of MAVLink 2: 13 bytes that prove its content and its time to whoever has the key.

::

    link id (1 byte) | timestamp (6 bytes, low byte first) | first 6 bytes of a SHA-256

The SHA-256 covers the key, the frame from its magic to its checksum, the link id and the timestamp. A timestamp counts
ticks of 10 us since the beginning of 2015 (UTC), in 48 bits, which end in the year 2104.
"""

from hashlib import sha256
from hmac import compare_digest
from typing import Final

from attest_mav.mavlink.wire.frame import MAGIC_V2, SIGNED

KEY_BYTES: Final = 32
HASH_BYTES: Final = 6
TIMESTAMP_BYTES: Final = 6
TAIL_BYTES: Final = 12
"""Timestamp and hash, which stand at the end of a frame."""

EPOCH_NS: Final = 1_420_070_400_000_000_000
"""The beginning of 2015 as UNIX time, ns."""
TICK_NS: Final = 10_000
LATEST: Final = (1 << 48) - 10 * 366 * 86_400 * 100_000
"""The last timestamp that is believed, ten years before the 48 bits end: one at their end would leave none to follow
it."""


def timestamp_of(unix_ns: int) -> int:
    """The timestamp of a UNIX time, ns; 0 before 2015, and at most ``LATEST``."""
    return min(max((unix_ns - EPOCH_NS) // TICK_NS, 0), LATEST)


def signature_for(key: bytes, frame: bytes, link_id: int, timestamp: int) -> bytes:
    """The 13 bytes behind a frame, which is given from its magic to its checksum."""
    head = bytes((link_id,)) + timestamp.to_bytes(TIMESTAMP_BYTES, "little")
    return head + sha256(key + frame + head).digest()[:HASH_BYTES]


def is_signed(frame: bytes) -> bool:
    """Whether a whole frame, from its magic on, carries a signature."""
    return frame[0] == MAGIC_V2 and frame[2] == SIGNED


def is_made_with(key: bytes, frame: bytes) -> bool:
    """Whether the signature at the end of a whole frame was made with this key."""
    made = sha256(key + frame[:-HASH_BYTES]).digest()[:HASH_BYTES]
    return compare_digest(made, frame[-HASH_BYTES:])


def link_id_of(frame: bytes) -> int:
    """The link id in the signature at the end of a whole frame."""
    return frame[-TAIL_BYTES - 1]


def timestamp_in(frame: bytes) -> int:
    """The timestamp in the signature at the end of a whole frame."""
    return int.from_bytes(frame[-TAIL_BYTES:-HASH_BYTES], "little")
