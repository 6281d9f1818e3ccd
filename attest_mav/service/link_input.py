"""The receiving side of one link: a framer for each byte stream that it carries."""

from collections import OrderedDict
from typing import Final

from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.framer import Frame, Framer
from attest_mav.mavlink.wire.walker import AcceptanceCheck

MAX_STREAMS: Final = 16
"""Streams whose unfinished frames are remembered; the one fed longest ago makes room."""


class LinkInput:
    """Finds the frames of a link. A frame that is cut in one stream is not mixed with bytes of another.

    wanted: the ids to return. accepts: an optional check of each wanted frame. The counters are those of ``Walker``,
    over all streams.
    """

    def __init__(self, dialect: Dialect, wanted: frozenset[int], accepts: AcceptanceCheck | None = None) -> None:
        self._dialect: Final = dialect
        self._wanted: Final = wanted
        self._accepts: Final = accepts
        self._framers: Final[OrderedDict[int, Framer]] = OrderedDict()
        self._past: Final = [0, 0, 0, 0]
        self.completed = False
        """Whether the bytes fed last completed an intact frame, wanted or not."""

    @property
    def frames(self) -> int:
        """Intact frames, wanted or not."""
        return self._past[0] + sum(framer.frames for framer in self._framers.values())

    @property
    def bad_bytes(self) -> int:
        """Bytes in no frame."""
        return self._past[1] + sum(framer.bad_bytes for framer in self._framers.values())

    @property
    def bad_crc(self) -> int:
        """Frames whose checksum does not fit."""
        return self._past[2] + sum(framer.bad_crc for framer in self._framers.values())

    @property
    def lost(self) -> int:
        """Frames missing in the sequence numbers."""
        return self._past[3] + sum(framer.lost for framer in self._framers.values())

    def feed(self, data: bytes, now_ns: int, stream: int) -> list[Frame]:
        """The wanted frames that these bytes of a stream complete."""
        framer = self._framers.get(stream)
        if framer is None:
            framer = self._framers[stream] = Framer(self._dialect, self._wanted, self._accepts)
            if len(self._framers) > MAX_STREAMS:
                self._retire(self._framers.popitem(last=False)[1])
        self._framers.move_to_end(stream)
        before = framer.frames
        found = framer.feed(data, now_ns)
        self.completed = framer.frames > before
        return found

    def reset(self) -> None:
        """Forget what was received in part: the link began anew."""
        for framer in self._framers.values():
            framer.reset()

    def _retire(self, framer: Framer) -> None:
        framer.reset()
        for number, count in enumerate((framer.frames, framer.bad_bytes, framer.bad_crc, framer.lost)):
            self._past[number] += count
