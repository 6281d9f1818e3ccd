"""What kind of log a file is, from its first bytes."""

from typing import Final, Literal

from attest_mav.errors import UnreadableDataError

LogFormat = Literal["tlog", "dataflash", "ulog"]

HEAD_BYTES: Final = 65536
"""How much of a file ``detect_format`` wants to see; less will do where the file is shorter."""

EXPECTED: Final = "a tlog, a DataFlash log (.bin) or a ULog"
"""What a log can be."""

_DATAFLASH: Final = b"\xa3\x95"
_ULOG: Final = b"ULog\x01\x12\x35"
_STRANGERS: Final = (
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
    """The same, or UnreadableDataError that says what the file ``name`` is instead.

    What is nothing else that is known may be a tlog with a damaged beginning: reading all of it will tell.
    """
    if not head:
        raise UnreadableDataError(f"{name}: the file is empty")
    found = detect_format(head)
    stranger = _what_it_is(head) if found is None else ""
    if stranger:
        raise UnreadableDataError(f"{name}: this is {stranger}; expected {EXPECTED}")
    return found or "tlog"


def _is_tlog(head: bytes) -> bool:
    """Whether two records whose times agree follow each other, or one makes up the whole head or ends beyond it."""
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
    """Where the MAVLink frame that may start here would end; 0 when none can."""
    if frame + 2 > len(data):
        return 0
    if data[frame] == 0xFE:
        return frame + 8 + data[frame + 1]
    if data[frame] == 0xFD:
        signature = 13 if data[frame + 2 : frame + 3] == b"\x01" else 0
        return frame + 12 + data[frame + 1] + signature
    return 0


def _what_it_is(head: bytes) -> str:
    """A guess in words, empty when there is none."""
    for magic, words in _STRANGERS:
        if head.startswith(magic):
            return words
    first = _frame_end(head, 0)
    if first and _frame_end(head, first):
        return "a bare MAVLink stream, without the time stamps of a tlog"
    return ""
