"""The format of a log, from its first bytes."""

from typing import Final, Literal

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.source import EXPECTED

LogFormat = Literal["tlog", "dataflash", "ulog"]

HEAD_BYTES: Final = 65536
"""Length of the head that ``detect_format`` needs; a shorter file is given whole."""

_DATAFLASH: Final = b"\xa3\x95"
_ULOG: Final = b"ULog\x01\x12\x35"
_FOREIGN_FORMATS: Final = (
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "a zip archive: unpack it first"),
    (b"\x1f\x8b", "gzip-compressed: unpack it first"),
    (b"\x7fELF", "a program"),
    (b"SQLite format 3\0", "an SQLite database"),
    (b"\x89HDF", "an HDF5 file"),
    (b"FMT, ", "a DataFlash log written as text: use the binary one"),
)
_STAMP_BYTES: Final = 8
_DAY_US: Final = 86_400_000_000


def detect_format(head: bytes) -> LogFormat | None:
    """The format of a log that begins with ``head``; None when it is none of the known ones."""
    if head.startswith(_DATAFLASH):
        return "dataflash"
    if head.startswith(_ULOG):
        return "ulog"
    return "tlog" if _is_tlog(head) else None


def require_format(head: bytes, name: str) -> LogFormat:
    """The format, or UnreadableDataError that names the foreign format of the file ``name``.

    A head of no known format counts as a tlog: its beginning may be damaged, and only reading all of it decides.
    """
    if not head:
        raise UnreadableDataError(f"{name}: the file is empty")
    found = detect_format(head)
    foreign = _foreign_format(head) if found is None else ""
    if foreign:
        raise UnreadableDataError(f"{name}: this is {foreign}; expected {EXPECTED}")
    return found or "tlog"


def _is_tlog(head: bytes) -> bool:
    """True if two adjacent records have times within a day, or if one record fills the head or ends beyond it."""
    for start in range(min(len(head), HEAD_BYTES) - _STAMP_BYTES):
        behind = _frame_end(head, start + _STAMP_BYTES)
        if behind == 0 or head[start] != 0:
            continue
        if start == 0 and behind >= len(head):
            return True
        if _frame_end(head, behind + _STAMP_BYTES) > 0 and abs(_stamp(head, behind) - _stamp(head, start)) < _DAY_US:
            return True
    return False


def _stamp(data: bytes, start: int) -> int:
    """The time of the record that may start here, us."""
    return int.from_bytes(data[start : start + _STAMP_BYTES], "big")


def _frame_end(data: bytes, frame: int) -> int:
    """End of the MAVLink frame that may start at ``frame``; 0 if none can start there."""
    if frame + 2 > len(data):
        return 0
    if data[frame] == 0xFE:
        return frame + 8 + data[frame + 1]
    if data[frame] == 0xFD:
        signature = 13 if data[frame + 2 : frame + 3] == b"\x01" else 0
        return frame + 12 + data[frame + 1] + signature
    return 0


def _foreign_format(head: bytes) -> str:
    """A foreign format in words; "" if the head is of none that is known."""
    for magic, words in _FOREIGN_FORMATS:
        if head.startswith(magic):
            return words
    first = _frame_end(head, 0)
    if first and _frame_end(head, first):
        return "a bare MAVLink stream, without the time stamps of a tlog"
    return ""
