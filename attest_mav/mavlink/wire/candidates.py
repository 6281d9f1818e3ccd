"""The places in a buffer where a frame may stand, and what stands there.

Each candidate that fails costs a checksum over its claimed length. Bytes that are made to be candidates everywhere
would cost up to 260 passes a byte; once the passes exceed those of intact frames by far, checksums are taken from
``RunningChecksum`` in constant time.
"""

from typing import Final

from mypy_extensions import i64

from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.checksum import checksum, checksum_at, explaining_extra
from attest_mav.mavlink.wire.frame import INCOMPLETE, MAGIC_V1, NO_FRAME, header_at, message_id_at, size_at
from attest_mav.mavlink.wire.running_checksum import MAX_LENGTH, RunningChecksum, ZeroTables

# What a candidate can be besides an intact frame of so many bytes (> 0), NO_FRAME and INCOMPLETE.
UNKNOWN_ID: Final = -2
BAD_CRC: Final = -3

MAX_UNKNOWN_RUN: Final = 3
"""So many frames with unknown ids in a row can vouch for each other."""
PATIENCE: Final = 3
PATIENCE_BYTES: Final = 2048
"""A buffer is checked in so many passes, and by so many bytes besides, before the other way is taken. Intact frames
take one pass."""


class Candidates:
    """The candidates in one buffer after the other."""

    def __init__(self, dialect: Dialect, intact: bool = False) -> None:
        """intact: every frame of the buffers is known to be intact, so that no checksum is needed."""
        self._is_intact: Final = intact
        self._extras: Final = dialect.crc_extras
        self._ids: i64 = len(dialect.crc_extras)
        self._sizes_v1: Final = dialect.sizes_v1
        self._zero_tables: Final[list[ZeroTables | None]] = [None] * MAX_LENGTH
        self._data = b""
        self._end: i64 = 0
        self._running: RunningChecksum | None = None
        self._patience: i64 = 0

    def begin(self, data: bytes) -> None:
        """Look at this buffer from now on."""
        self._data = data
        self._end = len(data)
        self._running = None
        self._patience = PATIENCE * self._end + PATIENCE_BYTES

    def at(self, at: i64) -> i64:
        """What stands at ``at``: the size of an intact frame, or one of the constants."""
        data = self._data
        size = size_at(data, at, self._end)
        if size <= 0:
            return size
        message_id = message_id_at(data, at)
        extra: i64 = self._extras[message_id] if message_id < self._ids else -1
        if extra < 0:
            return UNKNOWN_ID
        if data[at] == MAGIC_V1 and data[at + 1] > self._sizes_v1[message_id]:
            return NO_FRAME
        if at + size > self._end:
            return INCOMPLETE
        if self._is_intact:
            return size
        behind = at + header_at(data, at) + data[at + 1]
        return size if self._crc(at + 1, behind, extra) == checksum_at(data, behind) else BAD_CRC

    def explained(self, at: i64) -> i64:
        """Size of the candidate with an unknown id at ``at`` when some CRC extra explains its checksum."""
        if self._is_intact:
            return NO_FRAME
        data = self._data
        size = size_at(data, at, self._end)
        if at + size > self._end:
            return INCOMPLETE
        behind = at + header_at(data, at) + data[at + 1]
        return size if explaining_extra(data, at + 1, behind) >= 0 else NO_FRAME

    def proven_unknown(self, at: i64, lead: i64, final: bool) -> i64:
        """Size of the frame with an unknown id at ``at``, by what follows; INCOMPLETE while undecided; else NO_FRAME.

        lead: so many bytes precede each frame. final: nothing comes behind the buffer.
        """
        first: i64 = 0
        run: i64 = 0
        while run < MAX_UNKNOWN_RUN:
            size = self.explained(at)
            if size <= 0:
                return size
            if run == 0:
                first = size
            at += size + lead
            behind = self.at(at)
            if behind > 0 or (final and at - lead == self._end):
                return first
            if behind != UNKNOWN_ID:
                return INCOMPLETE if behind == INCOMPLETE else NO_FRAME
            run += 1
        return NO_FRAME

    def _crc(self, start: i64, stop: i64, extra: i64) -> i64:
        """Checksum of the bytes start to stop, by the way that suits the number of candidates."""
        running = self._running
        if running is not None:
            return running.crc(start, stop, extra)
        self._patience -= stop - start
        if self._patience < 0:
            self._running = RunningChecksum(self._data, self._zero_tables)
        return checksum(self._data, start, stop, extra)
