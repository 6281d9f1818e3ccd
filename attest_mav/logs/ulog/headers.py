"""The bounds of a ULog's messages: the length that a message tells, where its content confirms it.

(PX4's ULog file format.) Data have an id that was subscribed and the length of its topic, a key tells the size of its
value, some types have one length, and all others hold text.
"""

import re
from struct import Struct, calcsize
from typing import Final

from mypy_extensions import i64

from attest_mav.logs.ulog.layout import KINDS
from attest_mav.logs.ulog.topics import LATEST_US, Topics

FILE_HEADER_BYTES: Final = 16
FILE_MAGIC: Final = b"ULog\x01\x12\x35"
HEADER_BYTES: Final = 3
UNDECIDED: Final = -1
TYPES: Final = frozenset(b"ABCDFILMOPQRS")
LENGTHS: Final = {ord("B"): 40, ord("O"): 2, ord("R"): 2, ord("S"): 8}
"""Types of one length: flags, dropout, removed subscription, synchronisation."""
KEY_AT: Final = {ord("I"): 0, ord("P"): 0, ord("M"): 1, ord("Q"): 1}
"""Place of the key's length in a message with a key and a value."""
TEXT_AT: Final = {ord("L"): 9, ord("C"): 11}
"""Place of the text behind level, tag and time."""
LEVELS: Final = b"01234567"
LONGEST: Final = {ord("L"): 512, ord("C"): 512, ord("A"): 256, ord("F"): 4096}
"""Types of text, with a length that none of them exceeds: each place of a damaged log may be tried as one."""
_KEY: Final = re.compile(rb"([A-Za-z0-9_]+)(?:\[(\d{1,5})\])? ([A-Za-z0-9_.\[\]/ -]+)\Z")
_TOPIC: Final = re.compile(rb"[A-Za-z0-9_/-]+\Z")
_FORMAT: Final = re.compile(rb"[A-Za-z0-9_/-]+:[A-Za-z0-9_\[\] ;./-]*\Z")
_NO_TEXT: Final = re.compile(rb"[\x00-\x08\x0e-\x1a\x1c-\x1f]")
_TIME: Final = Struct("<Q")
_SIZES: Final = {kind.encode(): 1 if letter == "s" else calcsize(f"<{letter}") for kind, letter in KINDS.items()}


class Headers:
    """Finds the ends of messages in one window after the other."""

    def __init__(self, topics: Topics) -> None:
        self._topics: Final = topics
        self._data = b""
        self._size: i64 = 0
        self._final = False

    def begin(self, window: bytes, final: bool) -> None:
        """Look at this window from now on. final: nothing comes behind it."""
        self._data, self._size, self._final = window, len(window), final

    def is_file(self, at: i64) -> bool:
        """Whether a file begins here."""
        return self._data[at] == 0x55 and self._data.startswith(FILE_MAGIC, at)

    def is_usual_data(self, at: i64, end: i64) -> bool:
        """Whether the message from ``at`` to ``end`` holds data, as many as others of its topic."""
        data = self._data
        begin = at + HEADER_BYTES
        return data[at + 2] == 0x44 and self._topics.is_usual(data[begin] + 256 * data[begin + 1], end - begin - 2)

    def end(self, at: i64) -> i64:
        """End of the message or file header that begins here; 0 if none does, UNDECIDED if bytes are missing."""
        data = self._data
        missing: i64 = 0 if self._final else UNDECIDED
        if at + HEADER_BYTES > self._size:
            return missing
        kind: i64 = data[at + 2]
        if kind == 0x44:
            return self._data_end(at, missing)
        if kind not in TYPES:
            end = at + FILE_HEADER_BYTES if self.is_file(at) else 0
            return end if end <= self._size else missing
        length: i64 = data[at] + 256 * data[at + 1]
        end = at + HEADER_BYTES + length
        if not _may_be(kind, length):
            return 0
        if end > self._size:
            return missing
        return end if _is_content(kind, data[at + HEADER_BYTES : end]) else 0

    def _data_end(self, at: i64, missing: i64) -> i64:
        """The same for data. missing: the answer where bytes are missing."""
        data = self._data
        begin = at + HEADER_BYTES
        if begin + 2 > self._size:
            return missing
        length: i64 = data[at] + 256 * data[at + 1]
        number: i64 = data[begin] + 256 * data[begin + 1]
        if not self._topics.fits(number, length - 2):
            return 0
        return begin + length if begin + length <= self._size else missing


def _may_be(kind: i64, length: i64) -> bool:
    """Whether a message of this type, which is no data, can have so many bytes."""
    fixed = LENGTHS.get(kind)
    if fixed is not None:
        return length == fixed
    return 0 < length <= LONGEST.get(kind, 65535)


def _is_content(kind: i64, body: bytes) -> bool:
    """Whether these bytes can be the body of a message of this type."""
    key_at = KEY_AT.get(kind)
    if key_at is not None:
        return _is_keyed(body, key_at)
    text_at = TEXT_AT.get(kind)
    if text_at is not None:
        return len(body) >= text_at and body[0] in LEVELS and _is_text(body, text_at)
    if kind == ord("F"):
        return _FORMAT.match(body) is not None
    if kind == ord("A"):
        return _TOPIC.match(body, 3) is not None
    return True


def _is_text(body: bytes, at: i64) -> bool:
    """Whether a text stands here, and a time before it."""
    if _TIME.unpack_from(body, at - _TIME.size)[0] >= LATEST_US or _NO_TEXT.search(body, at) is not None:
        return False
    try:
        body[at:].decode()
    except UnicodeDecodeError:
        return False
    return True


def _is_keyed(body: bytes, at: i64) -> bool:
    """Whether the body holds a key, and a value of the key's size."""
    if len(body) <= at:
        return False
    value_at = at + 1 + body[at]
    key = _KEY.match(body[at + 1 : value_at])
    if key is None or value_at > len(body):
        return False
    size = _SIZES.get(key[1])
    return size is None or len(body) - value_at == size * int(key[2] or 1)
