"""What a MAVLink frame looks like, and the record of one.

::

    version 1   FE len seq sys comp id                         payload  checksum
    version 2   FD len incompat compat seq sys comp id id id   payload  checksum  [signature, 13 bytes]

The checksum covers everything between the magic byte and itself, and the CRC extra of the message.
"""

from typing import Final

from mypy_extensions import i64, mypyc_attr

from attest_mav.record import Record

MAGIC_V1: Final = 0xFE
MAGIC_V2: Final = 0xFD
HEADER_V1: Final = 6
HEADER_V2: Final = 10
CHECKSUM_BYTES: Final = 2
SIGNATURE_BYTES: Final = 13
SIGNED: Final = 0x01
"""The one incompatibility flag there is; a frame with another one cannot be understood."""

NO_FRAME: Final = 0
INCOMPLETE: Final = -1


@mypyc_attr(acyclic=True)  # as Sample
class Frame(Record):
    """One intact frame.

    The constructor has an argument for each field, positional, since the walker makes one for every wanted frame.
    """

    def __init__(
        self,
        message_id: i64,
        system: i64,
        component: i64,
        sequence: i64,
        version: i64,
        signed: bool,
        payload: bytes,
        rx_ns: i64,
        offset: i64 = 0,
        size: i64 = 0,
    ) -> None:
        self.message_id: Final = message_id
        self.system: Final = system
        self.component: Final = component
        self.sequence: Final = sequence
        self.version: Final = version
        """1 or 2."""
        self.signed: Final = signed
        """It carries a signature, verified only by an acceptance check of the walker."""
        self.payload: Final = payload
        """As it was on the wire, without the zeros that MAVLink 2 cuts off."""
        self.rx_ns: Final = rx_ns
        """Time of arrival, host clock."""
        self.offset: Final = offset
        """Place of its magic byte in all the bytes that came in."""
        self.size: Final = size
        """Length with header, checksum and signature, bytes."""


def size_at(data: bytes, at: i64, end: i64) -> i64:
    """Bytes of the frame whose header may stand at ``at``, though they need not be there yet.

    NO_FRAME when none can begin here, INCOMPLETE when the header is not all there.
    """
    left: i64 = end - at
    if left < HEADER_V1:
        return INCOMPLETE if left <= 0 or data[at] == MAGIC_V2 or data[at] == MAGIC_V1 else NO_FRAME
    if data[at] == MAGIC_V2:
        if left < HEADER_V2:
            return INCOMPLETE
        flags: i64 = data[at + 2]
        return HEADER_V2 + data[at + 1] + CHECKSUM_BYTES + SIGNATURE_BYTES * flags if flags <= SIGNED else NO_FRAME
    return HEADER_V1 + data[at + 1] + CHECKSUM_BYTES if data[at] == MAGIC_V1 else NO_FRAME


def header_at(data: bytes, at: i64) -> i64:
    """Bytes of the header at ``at``."""
    return HEADER_V2 if data[at] == MAGIC_V2 else HEADER_V1


def message_id_at(data: bytes, at: i64) -> i64:
    """Message id of the header at ``at``."""
    if data[at] == MAGIC_V2:
        return data[at + 7] | (data[at + 8] << 8) | (data[at + 9] << 16)
    return data[at + 5]
