"""The bounds of a DataFlash log's records in one window: where one begins, ends, or seems to.

A record has no checksum. What stands around it, and inside, shows whether it is intact.
"""

from math import isfinite
from struct import Struct
from typing import Final

from mypy_extensions import i64

from attest_mav.logs.dataflash.record_clock import RecordClock
from attest_mav.logs.dataflash.record_format import FORMAT_BYTES, FORMAT_TYPE, HEADER_BYTES, is_format
from attest_mav.logs.dataflash.record_types import RecordTypes
from attest_mav.logs.dataflash.selection import time_column

MAGIC: Final = b"\xa3\x95"
LONGEST_GAP_NS: Final = 60_000_000_000
"""A record between damage on both sides is no more than this away from the newest one in time."""
_NUMBERS: Final = {"Q": Struct("<Q"), "I": Struct("<I")}


class Bounds:
    """Looks at one window after the other. clock: the time of the newest record."""

    def __init__(self, types: RecordTypes, clock: RecordClock) -> None:
        self.sure_ns = 0
        """Another time that counts as that of the newest record."""
        self._types: Final = types
        self._clock: Final = clock
        self._data = b""
        self._size: i64 = 0
        self._final = False

    def begin(self, window: bytes, final: bool) -> None:
        """Look at this window from now on. final: nothing comes behind it."""
        self._data, self._size, self._final = window, len(window), final

    def length(self, at: i64) -> i64:
        """Length of the record whose header stands here and that ends in the window, 0 if there is none."""
        data = self._data
        if not self.has_magic(at):
            return 0
        kind: i64 = data[at + 2]
        if kind == FORMAT_TYPE:
            end = at + FORMAT_BYTES
            return FORMAT_BYTES if end <= self._size and is_format(data[at + HEADER_BYTES : end]) else 0
        length: i64 = self._types.lengths[kind]
        return length if at + length <= self._size else 0

    def has_magic(self, at: i64) -> bool:
        """Whether the header of a record, of any type, stands here and ends in the window."""
        data = self._data
        return at + HEADER_BYTES <= self._size and data[at] == 0xA3 and data[at + 1] == 0x95

    def is_followed(self, end: i64) -> bool:
        """Whether another record, of any type, begins here, or the log ends."""
        return self.has_magic(end) or (end == self._size and self._final)

    def next_magic(self, at: i64, stop: i64) -> i64:
        """The next place before ``stop`` where a record may begin; ``stop`` if there is none."""
        found: i64 = self._data.find(MAGIC, at, stop + 1)
        return found if 0 <= found < stop else stop

    def hides_end(self, at: i64, end: i64) -> bool:
        """Whether this record has lost bytes, and as many of other records stand in their place up to its end.

        Some numbers look like the header of a record; the time of that one tells.
        """
        inside = self.next_magic(at + HEADER_BYTES, end)
        while inside < end:
            if self._chain_end(inside, end) == end and self.is_certain(inside):
                return True
            inside = self.next_magic(inside + 1, end)
        return False

    def is_cut(self, at: i64, end: i64) -> bool:
        """Whether another record begins inside this one: a further one stands behind it, or its content proves it."""
        inside = self.next_magic(at + 1, end)
        while inside < end:
            length = self.length(inside)
            if length > 0 and (self.is_followed(inside + length) or self.is_certain(inside)):
                return True
            inside = self.next_magic(inside + 1, end)
        return False

    def is_certain(self, at: i64) -> bool:
        """Whether the content of the record shows that it is one: a description, or a time close to the newest one."""
        if self._data[at + 2] == FORMAT_TYPE:
            return True
        route = self._types.routes[self._data[at + 2]]
        if route is None or not route.record_format.is_readable:
            return False
        column, unit_ns = time_column(route.record_format)
        reader = _NUMBERS.get(route.record_format.codes[column]) if column >= 0 else None
        if reader is None:
            return False
        t_ns: float = reader.unpack_from(self._data, at + route.record_format.offsets[column])[0] * unit_ns
        away_ns = min(abs(t_ns - self._clock.now_ns), abs(t_ns - self.sure_ns))
        return isfinite(t_ns) and away_ns <= LONGEST_GAP_NS

    def _chain_end(self, at: i64, stop: i64) -> i64:
        """Where the records from ``at`` on lead to, at ``stop`` or behind; 0 if they do not lead there."""
        while at < stop:
            length = self.length(at)
            if length == 0:
                return 0
            at += length
        return at
