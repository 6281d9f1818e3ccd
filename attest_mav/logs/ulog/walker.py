"""Walks over a ULog: messages by their length, and the next intact one behind damage.

A message is a length (uint16), a type (one letter), and as many bytes. It has no checksum, so it counts as intact when
its type is known, its length fits it, and behind it the header of a known type stands, or the end of the log. Data that
were appended after a crash begin at offsets which the log names at its begin; a message that reaches over one is cut.
"""

from struct import Struct
from typing import Final

from mypy_extensions import i64

from attest_mav.logs.damage import Damage
from attest_mav.logs.ulog.messages import TAGGED_TEXT_AT, TEXT_AT
from attest_mav.logs.ulog.topics import Topics
from attest_mav.samples import Sample

FILE_HEADER_BYTES: Final = 16
HEADER_BYTES: Final = 3
FLAG_BYTES: Final = 40
"""Length of the message with the flags: 16 bytes of flags, and three offsets."""
APPENDED: Final = 1
"""Bit of the first incompatible flag: data are appended."""
TYPES: Final = frozenset(b"ABCDFILMOPQRS")
SMALLEST: Final = {ord("B"): FLAG_BYTES, ord("D"): 3, ord("S"): 8, ord("O"): 2, ord("A"): 4, ord("R"): 2, ord("L"): 9}
_LENGTH: Final = Struct("<H")
_OFFSETS: Final = Struct("<3Q")


class UlogWalker:
    """The samples of the wanted topics and messages, from windows of the log."""

    def __init__(self, topics: Topics) -> None:
        self.records = 0
        """Intact messages, wanted or not."""
        self.damage: Final = Damage()
        self.dropout_ms = 0
        """Time for which the recorder could not keep up."""
        self.dropouts = 0
        self._topics: Final = topics
        self._data = b""
        self._size: i64 = 0
        self._position = 0
        self._final = False
        self._boundaries: list[int] = []

    @property
    def position(self) -> int:
        """Where the next window has to begin."""
        return self._position

    def walk(self, window: bytes, final: bool) -> list[Sample]:
        """The samples of the window that begins at ``position``. final: it reaches to the end of the log."""
        self._data, self._size, self._final = window, len(window), final
        samples: list[Sample] = []
        at: i64 = FILE_HEADER_BYTES if self._position == 0 else 0
        while at < self._size:
            end = self._end(at)
            if end < 0:
                break
            if end == 0:
                following = self._next_intact(at + 1)
                self.damage.add(self._position + at, following - at)
                at = following
                continue
            self.records += 1
            self._take(at, end, samples)
            at = end
        self._position += min(at, self._size)
        return samples

    def _end(self, at: i64) -> i64:
        """End of the intact message that begins here; 0 if none does, -1 if the next window has to show it."""
        data = self._data
        if at + HEADER_BYTES > self._size:
            return 0 if self._final else -1
        length: i64 = data[at] + 256 * data[at + 1]
        end = at + HEADER_BYTES + length
        if not self._is_known(at, length) or self._is_cut(at, end):
            return 0
        if end + HEADER_BYTES > self._size:
            if not self._final:
                return -1
            return end if end == self._size else 0
        if self._is_boundary(end) or self._may_begin(end):
            return end
        return 0 if self._hides_message(at, end) else end

    def _may_begin(self, at: i64) -> bool:
        """Whether the header here is that of a known type, with a length that it can have."""
        data = self._data
        length: i64 = data[at] + 256 * data[at + 1]
        return data[at + 2] in TYPES and length >= SMALLEST.get(data[at + 2], 1)

    def _is_known(self, at: i64, length: i64) -> bool:
        """The same, and data have the length of their topic."""
        if not self._may_begin(at):
            return False
        kind = self._data[at + 2]
        if kind != ord("D") or at + HEADER_BYTES + 2 > self._size:
            return True
        return self._topics.fits(_LENGTH.unpack_from(self._data, at + HEADER_BYTES)[0], length - 2)

    def _is_cut(self, at: i64, end: i64) -> bool:
        """Whether appended data begin inside."""
        return any(self._position + at < boundary < self._position + end for boundary in self._boundaries)

    def _is_boundary(self, at: i64) -> bool:
        return bool(self._boundaries) and self._position + at in self._boundaries

    def _hides_message(self, at: i64, end: i64) -> bool:
        """Whether a message begins inside this one, and a further one behind that: then this one lost bytes."""
        return any(self._is_followed(inside) for inside in range(at + 1, min(end, self._size - HEADER_BYTES)))

    def _next_intact(self, at: i64) -> i64:
        """The next place where a message begins that another one follows, or appended data, or the window's end."""
        while at + HEADER_BYTES <= self._size:
            if self._is_boundary(at) or self._is_followed(at):
                return at
            at += 1
        return self._size if self._final else at

    def _is_followed(self, at: i64) -> bool:
        """Whether a known message stands here, and another one may begin behind it."""
        data = self._data
        length: i64 = data[at] + 256 * data[at + 1]
        end = at + HEADER_BYTES + length
        if not self._is_known(at, length) or end + HEADER_BYTES > self._size:
            return False
        return self._may_begin(end)

    def _take(self, at: i64, end: i64, samples: list[Sample]) -> None:
        """Take the message from ``at`` to ``end``."""
        kind = self._data[at + 2]
        begin = at + HEADER_BYTES
        topics = self._topics
        if kind == ord("D"):
            samples.extend(topics.data(self._data, begin, end))
            return
        body = self._data[begin:end]
        if kind == ord("P"):
            samples.extend(topics.messages.parameter(body, topics.now_ns))
        elif kind == ord("I"):
            samples.extend(topics.messages.information(body, topics.now_ns))
        elif kind == ord("L"):
            samples.extend(topics.messages.text(body, TEXT_AT))
        elif kind == ord("C"):
            samples.extend(topics.messages.text(body, TAGGED_TEXT_AT))
        elif kind == ord("F"):
            topics.formats.learn(body.decode("ascii", "replace"))
        elif kind == ord("A"):
            topics.subscribe(body)
        elif kind == ord("O"):
            self.dropouts += 1
            self.dropout_ms += _LENGTH.unpack_from(body)[0]
        elif kind == ord("B") and body[8] & APPENDED:
            self._boundaries = [offset for offset in _OFFSETS.unpack_from(body, 16) if offset > 0]
