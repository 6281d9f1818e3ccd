"""A tlog as a vehicle that sends again the frames it sent, at the times at which they were recorded."""

from collections.abc import Iterator
from typing import Final

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.source import LogBytes
from attest_mav.logs.tlog.annotate import OUR_COMPONENT
from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.logs.tlog.roles import GROUND_SYSTEM
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.mavlink.wire.framer import Framer

LONGEST_PAUSE_NS: Final = 10_000_000_000
"""A longer pause of the recording is cut to this; its clock may have been set."""


class PlayedLog:
    """The frames of all senders but ground stations and our own component, on the time since the first of them.

    Commands to the vehicle are not answered. UnreadableDataError for a log without such a frame.
    """

    def __init__(self, data: LogBytes, dialect: Dialect) -> None:
        self.framer: Final = Framer(dialect, frozenset())
        """Counts the frames that arrive from others; none is looked at."""
        self.sent = 0
        """Frames sent."""
        self._data: Final = data
        self._frames: Final = self._vehicle_frames(TlogReader(data, dialect))
        self._due_ns = 0
        self._next: Frame | None = next(self._frames, None)
        if self._next is None:
            raise UnreadableDataError("no frame of a vehicle in it; expected a tlog with a vehicle's messages")

    def handle(self, data: bytes, now_ns: int) -> None:
        """Take bytes that arrived; a recording does nothing about them."""
        self.framer.feed(data, now_ns)

    def frames_until(self, now_ns: int) -> list[bytes]:
        """All frames up to and including ``now_ns`` that were not yet returned, in the order of the log."""
        out: list[bytes] = []
        while (frame := self._next) is not None and self._due_ns <= now_ns:
            out.append(self._data[frame.offset : frame.offset + frame.size])
            self._next = next(self._frames, None)
            if self._next is not None:
                self._due_ns += min(max(self._next.rx_ns - frame.rx_ns, 0), LONGEST_PAUSE_NS)
        self.sent += len(out)
        return out

    @property
    def next_deadline_ns(self) -> int | None:
        """The time of the next frame; None after the last one."""
        return None if self._next is None else self._due_ns

    @staticmethod
    def _vehicle_frames(reader: TlogReader) -> Iterator[Frame]:
        return (frame for frame in reader if frame.system != GROUND_SYSTEM and frame.component != OUR_COMPONENT)
