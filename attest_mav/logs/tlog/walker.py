"""Walks over a telemetry log (tlog): frames, each behind its arrival time.

A record is eight bytes, microseconds since 1970 as a big-endian number, and a frame. The frames are found by the rules
of ``attest_mav.mavlink.wire.walker``. A time that steps back by more than a second, or forward by more than ten, may be
damaged. Such a time is accepted when the next record's time goes on from it; otherwise the frame gets the time of the
one before. So a true step (the recorder's clock was set, two logs in one file) costs nothing, and a damaged time moves
no other frame.

A bare stream has no times. A frame of it gets the newest time since boot that its system has sent, so that everything
that compares arrivals goes by the sensor's clock.
"""

from typing import Final

from mypy_extensions import i64

from attest_mav.logs.tlog.stamps import NewestBootTime
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.mavlink.wire.walker import Walker

STAMP_BYTES: Final = 8
MARGIN: Final = 2048
"""More than the longest stretch that deciding on one frame looks ahead: five records of 288 bytes."""

_LATEST_SECOND_BYTE: Final = 0x20
"""No time from 2**53 us (the year 2255) on is believed; this also keeps nanoseconds within 64 bits."""

_MAX_STEP_BACK_US: Final = 1_000_000
_MAX_STEP_US: Final = 10_000_000


class TlogWalker(Walker):
    """The frames of a tlog, from windows of it; ``bare``: those of a stream without times. intact: as in ``Walker``."""

    def __init__(
        self, dialect: Dialect, wanted: frozenset[int] | None, bare: bool = False, intact: bool = False
    ) -> None:
        super().__init__(dialect, wanted, 0 if bare else STAMP_BYTES, looks_behind=True, intact=intact)
        self.bare: Final = bare
        self._boot_clock: Final = NewestBootTime(dialect) if bare else None
        self.bad_stamps: i64 = 0
        """Times that were not believed."""
        self._last_us: i64 = -1

    @property
    def is_intact(self) -> bool:
        """Whether all bytes so far belong to one intact frame each, with an id that the dialect knows."""
        return self.bad_bytes == 0 and self.unknown == 0 and self.shared == 0

    @property
    def position(self) -> int:
        """Where the next window has to begin."""
        return self._base

    def walk(self, window: bytes, final: bool) -> list[Frame]:
        """The wanted frames of a window of the log that begins at ``position``.

        final: the window reaches to the end. Otherwise it should be much longer than MARGIN: its last MARGIN bytes
        are left to the next window.
        """
        frames = self._walk(window, len(window) if final else len(window) - MARGIN, final)
        self._forget_done()
        return frames

    def _arrival(self, size: i64) -> i64:
        """The record's time if it can be believed, else that of the record before; ns."""
        if self._boot_clock is not None:
            return self._boot_clock.at(self._data, self._place)
        stamp: i64 = self._stamp(self._place) if self._place - self._done >= STAMP_BYTES else -1
        if stamp < 0 or not (_goes_on(self._last_us, stamp) or self._confirmed(stamp, size)):
            self.bad_stamps += 1
            stamp = self._last_us
        if stamp < 0:
            return 0
        self._last_us = stamp
        return stamp * 1000

    def _stamp(self, frame_at: i64) -> i64:
        """The time before a frame, us; -1 when it cannot be one."""
        if frame_at > self._end:
            return -1
        data = self._data
        if data[frame_at - 8] > 0 or data[frame_at - 7] >= _LATEST_SECOND_BYTE:
            return -1
        stamp: i64 = 0
        place = frame_at - 7
        while place < frame_at:
            stamp = (stamp << 8) | data[place]
            place += 1
        return stamp

    def _confirmed(self, stamp: i64, size: i64) -> bool:
        """Whether the next record's time goes on from ``stamp``; without a next one, whether there was none before."""
        behind = self._place + size + STAMP_BYTES
        if behind > self._end:
            return self._last_us < 0
        following = self._stamp(behind)
        return following >= 0 and _goes_on(stamp, following)


def _goes_on(before_us: i64, after_us: i64) -> bool:
    """Whether two neighbouring records can carry these times."""
    return before_us >= 0 and -_MAX_STEP_BACK_US <= after_us - before_us <= _MAX_STEP_US
