"""The format of a log, from its first bytes."""

import re
from typing import Final, Literal

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.source import EXPECTED

LogFormat = Literal["tlog", "mavlink", "dataflash", "dataflash-text", "ulog"]

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
)
BYTE_ORDER_MARKS: Final = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))
"""Marks at the begin of a text, and its encoding."""
_TEXT_FORMAT_LINE: Final = re.compile(r"^[ \t]*FMT[ \t]*,[ \t]*\d+[ \t]*,[ \t]*\d+[ \t]*,", re.MULTILINE)
"""The line of a DataFlash log in text that describes one kind of record."""
_RECORD_FORMAT: Final = b"\xa3\x95\x80"
"""Begin of a DataFlash record that describes one kind of record, as it begins in an sdlog2 file too."""
_RECORD_FORMAT_BYTES: Final = 89
_SDLOG2_CLOCK: Final = b"TIME"
_SDLOG2_CLOCK_LABELS: Final = b"StartTime\0"
"""Only sdlog2 has its time in a kind of record of its own; DataFlash has it in every record."""
_STAMP_BYTES: Final = 8
_DAY_US: Final = 86_400_000_000
_STREAM_RUN: Final = 4
"""So many adjacent frames without anything between them make a stream; by chance four magic bytes fit 1 in 10^8."""


def detect_format(head: bytes) -> LogFormat | None:
    """The format of a log that begins with ``head``; None when it is none of the known ones."""
    if head.startswith(_DATAFLASH):
        return None if _is_sdlog2(head) else "dataflash"
    if head.startswith(_ULOG):
        return "ulog"
    if _TEXT_FORMAT_LINE.search(_text(head)):
        return "dataflash-text"
    if _is_tlog(head):
        return "tlog"
    return "mavlink" if _is_stream(head) else None


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


def _is_stream(head: bytes) -> bool:
    """True if a run of frames stands without times between them, wherever it begins; a short file may be one run."""
    for start in range(min(len(head), HEAD_BYTES)):
        end, run = _frame_end(head, start), 0
        while 0 < end <= len(head) and run < _STREAM_RUN:
            run += 1
            if end == len(head) and run > 1:
                return True
            end = _frame_end(head, end)
        if run == _STREAM_RUN:
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
    if head.startswith(_DATAFLASH):
        return "a PX4 log of before 2017 (sdlog2, .px4log), which is no DataFlash log in spite of its first bytes"
    return ""


def _text(head: bytes) -> str:
    """The head as text, by its byte-order mark."""
    for mark, encoding in BYTE_ORDER_MARKS:
        if head.startswith(mark):
            return head[len(mark) :].decode(encoding, "replace")
    return head.decode("ascii", "replace")


def _is_sdlog2(head: bytes) -> bool:
    """True if the descriptions of records at the begin of the head hold sdlog2's kind of record for the time."""
    at = 0
    while head.startswith(_RECORD_FORMAT, at):
        name, labels = head[at + 5 : at + 9], head[at + 25 : at + _RECORD_FORMAT_BYTES]
        if name == _SDLOG2_CLOCK and labels.startswith(_SDLOG2_CLOCK_LABELS):
            return True
        at += _RECORD_FORMAT_BYTES
    return False
