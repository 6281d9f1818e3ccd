"""Walks over a ULog: messages by their length, and the next intact one behind damage.

A message is a length (uint16), a type (one letter), and as many bytes. It has no checksum, so it counts as intact when
its length fits its content (``headers``). Bytes may be missing inside it: then another message begins within its
length, and the cut one is given up. Data that were appended after a crash begin at offsets which the log names at its
begin; a message that reaches over one is cut. A log may be several joined ones.
"""

from struct import Struct
from typing import Final

from mypy_extensions import i64

from attest_mav.logs.damage import Damage
from attest_mav.logs.ulog.headers import HEADER_BYTES, UNDECIDED, Headers
from attest_mav.logs.ulog.marks import Marks
from attest_mav.logs.ulog.messages import TAGGED_TEXT_AT, TEXT_AT
from attest_mav.logs.ulog.topics import Topics
from attest_mav.samples import Sample

APPENDED: Final = 1
"""Bit of the first incompatible flag: data are appended."""
_LENGTH: Final = Struct("<H")
_OFFSETS: Final = Struct("<3Q")


class UlogWalker:
    """The samples of the wanted topics and messages, from windows of the log.

    intact_to: up to this byte another walk over the log has found no damage, so no look inside is needed.
    """

    def __init__(self, topics: Topics, intact_to: int = 0) -> None:
        self.records = 0
        """Intact messages, wanted or not."""
        self.damage: Final = Damage()
        self.dropout_ms = 0
        """Time for which the recorder could not keep up."""
        self.dropouts = 0
        self._topics: Final = topics
        self._headers: Final = Headers(topics)
        self._intact_to: Final = intact_to
        self._known_to: i64 = 0
        """The same, counted from the begin of the window."""
        self._data_marks: Final = Marks(b"D")
        self._file_at = 0
        self._behind_at: i64 = -1
        self._behind: i64 = 0
        """End of the message at ``_behind_at``, see ``Headers.end``."""
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
        self._headers.begin(window, final)
        self._data_marks.begin(window)
        self._known_to = max(self._intact_to - self._position, 0)
        self._behind_at = -1
        samples: list[Sample] = []
        at: i64 = 0
        while at < self._size:
            end = self._end(at)
            if end == UNDECIDED:
                break
            if end == 0:
                at = self._pass_damage(at)
                continue
            if self._headers.is_file(at):
                self._file_at = self._position + at
                self._boundaries = []
            else:
                self.records += 1
                self._take(at, end, samples)
            at = end
        self._position += at
        return samples

    def _pass_damage(self, begin: i64) -> i64:
        """The next place where a message begins, or one that the next window has to show."""
        at = begin + 1
        while at < self._size and self._end(at) == 0:
            at += 1
        self.damage.add(self._position + begin, at - begin)
        return at

    def _end(self, at: i64) -> i64:
        """End of the intact message or file header here; 0 if none begins, UNDECIDED if the next window shows it."""
        # The message behind the last one has been looked at; one that was none may be one by what the last one told.
        end = self._behind if at == self._behind_at and self._behind > 0 else self._headers.end(at)
        if end <= self._known_to:
            return end
        if self._boundaries and self._is_cut(at, end):
            return 0
        behind = self._headers.end(end)
        if behind == UNDECIDED:
            return UNDECIDED
        self._behind_at, self._behind = end, behind
        lacks_bytes = self._hides_end(at, end) if behind > 0 or end == self._size else self._hides_message(at, end)
        return 0 if lacks_bytes else end

    def _is_cut(self, at: i64, end: i64) -> bool:
        """Whether appended data begin inside."""
        places = [boundary - self._position for boundary in self._boundaries]
        return any(at < place < end and self._headers.end(place) > 0 for place in places)

    def _hides_end(self, at: i64, end: i64) -> bool:
        """Whether this message lost bytes, and data of the same number, or more messages, stand there up to its end."""
        if self._data_marks.behind(at + HEADER_BYTES - 1) >= end:
            return False
        kind: i64 = self._data.find(b"D", at + HEADER_BYTES, end)
        while kind >= 0:
            inside = kind - HEADER_BYTES + 1
            while 0 < inside < end:
                inside = self._headers.end(inside)
            if inside == end:
                return True
            kind = self._data.find(b"D", kind + 1, end)
        return False

    def _hides_message(self, at: i64, end: i64) -> bool:
        """Whether data of the usual size, or a message that a further one follows, begin inside this one.

        Then this one has lost bytes.
        """
        headers = self._headers
        for inside in range(at + 1, end):
            following = headers.end(inside)
            if following > 0 and (headers.is_usual_data(inside, following) or headers.end(following) > 0):
                return True
        return False

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
            self._boundaries = [self._file_at + offset for offset in _OFFSETS.unpack_from(body, 16) if offset > 0]
