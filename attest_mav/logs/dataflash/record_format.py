"""The description of one type of record (FMT): name, length, columns, and where each column stands.

A record is the two magic bytes A3 95, its type, and its columns without padding. Every log begins with the
descriptions, FMT's own among them. (ArduPilot's libraries/AP_Logger, LogStructure.h.)
"""

import re
from itertools import accumulate
from struct import Struct
from typing import Final

HEADER_BYTES: Final = 3
"""Magic and type."""
FORMAT_TYPE: Final = 128
"""The type of FMT itself."""
FORMAT_BYTES: Final = 89
"""The length of FMT."""
_BODY: Final = Struct("<BB4s16s64s")
_NAME: Final = re.compile(rb"[A-Za-z0-9_]{1,4}\0*\Z")
_CODES: Final = re.compile(rb"[A-Za-z]{0,16}\0*\Z")
CENTI: Final = 1e-2


class FieldCode:
    """The meaning of one letter of a format. kind: the letter of ``struct``. scale: by which a number is multiplied."""

    def __init__(self, kind: str, size: int, scale: float = 1.0, is_text: bool = False) -> None:
        self.kind: Final = kind
        self.size: Final = size
        self.scale: Final = scale
        self.is_text: Final = is_text


CODES: Final = {
    "a": FieldCode("64s", 64, is_text=True),
    "b": FieldCode("b", 1),
    "B": FieldCode("B", 1),
    "M": FieldCode("B", 1),
    "h": FieldCode("h", 2),
    "H": FieldCode("H", 2),
    "c": FieldCode("h", 2, CENTI),
    "C": FieldCode("H", 2, CENTI),
    "i": FieldCode("i", 4),
    "I": FieldCode("I", 4),
    "e": FieldCode("i", 4, CENTI),
    "E": FieldCode("I", 4, CENTI),
    "L": FieldCode("i", 4, 1e-7),
    "q": FieldCode("q", 8),
    "Q": FieldCode("Q", 8),
    "f": FieldCode("f", 4),
    "d": FieldCode("d", 8),
    "g": FieldCode("e", 2),
    "n": FieldCode("4s", 4, is_text=True),
    "N": FieldCode("16s", 16, is_text=True),
    "Z": FieldCode("64s", 64, is_text=True),
}
"""All letters. c, C, e and E are hundredths; L is a latitude or longitude in degrees times 10^7; M is a flight mode."""


class RecordFormat:
    """One type of record. codes: a letter of ``CODES`` for each column."""

    def __init__(self, record_type: int, length: int, name: str, codes: str, columns: tuple[str, ...]) -> None:
        self.record_type: Final = record_type
        self.length: Final = length
        """Bytes of a record, its header included."""
        self.name: Final = name
        self.codes: Final = codes
        self.columns: Final = columns
        sizes = [CODES[code].size for code in codes] if all(code in CODES for code in codes) else []
        self.offsets: Final = list(accumulate(sizes[:-1], initial=HEADER_BYTES)) if sizes else []
        """Place of each column in the record."""
        self.columns_length: Final = HEADER_BYTES + sum(sizes) if sizes else length
        """Length of the header and the columns: another one than that told where a description is damaged or wrong."""
        self.is_readable: Final = bool(sizes) and self.columns_length <= length
        """False where the letters do not fit the length: such records are passed over."""

    @property
    def key(self) -> tuple[int, int, str, str, tuple[str, ...]]:
        """The description: a log repeats them when it goes on in a new file, and so do joined logs."""
        return self.record_type, self.length, self.name, self.codes, self.columns

    def of_columns(self) -> "RecordFormat":
        """The same with the length of its columns."""
        return RecordFormat(self.record_type, self.columns_length, self.name, self.codes, self.columns)

    def index(self, column: str) -> int:
        """Place of a column among all, -1 where there is none, or none with a letter."""
        found = self.columns.index(column) if column in self.columns else -1
        return found if found < len(self.codes) else -1


def is_format(body: bytes) -> bool:
    """Whether the 86 bytes behind FMT's header are a description."""
    if len(body) < _BODY.size or body[1] < HEADER_BYTES:
        return False
    return _NAME.match(body[2:6]) is not None and _CODES.match(body[6:22]) is not None


def parse_format(body: bytes) -> RecordFormat | None:
    """The description in the 86 bytes behind FMT's header; None for bytes that are none."""
    if not is_format(body):
        return None
    record_type, length, name, codes, labels = _BODY.unpack_from(body)
    return made_format(record_type, length, text_of(name), text_of(codes), text_of(labels))


def made_format(record_type: int, length: int, name: str, codes: str, labels: str) -> RecordFormat:
    """The format with columns named in one text, with commas."""
    columns = tuple([label.strip() for label in labels.split(",")])
    return RecordFormat(record_type, length, name, codes, columns)


def text_of(field: bytes) -> str:
    """The text in a field of fixed length, up to the first zero."""
    return field.split(b"\0", 1)[0].decode("ascii", "replace")
