"""Reads telemetry logs (tlog), as ground stations and MAVProxy record them, at constant memory."""

from collections.abc import Iterator
from itertools import chain
from typing import Final

from attest_mav.logs.source import LogBytes
from attest_mav.logs.tlog.walker import TlogWalker
from attest_mav.logs.windows import read_windows
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame


class TlogReader:
    """Reads a tlog from memory at constant memory.

    ``wanted`` holds the message ids to return; None returns all. The frames come in order, with ``rx_ns`` from the log
    and ``offset`` in it: ``buffer[frame.offset : frame.offset + frame.size]`` is the raw frame. The counters fill
    during the iteration; a reader is read once. ``bare``: the buffer is a stream of frames without times.
    ``intact``: it is known to hold nothing but intact frames.
    """

    def __init__(
        self,
        buffer: LogBytes,
        dialect: Dialect,
        wanted: frozenset[int] | None = None,
        bare: bool = False,
        intact: bool = False,
    ) -> None:
        self._buffer: Final = buffer
        self._walker: Final = TlogWalker(dialect, wanted, bare, intact)

    def batches(self) -> Iterator[list[Frame]]:
        """The wanted frames, those of one stretch of the log at a time."""
        return read_windows(self._buffer, self._walker)

    def __iter__(self) -> Iterator[Frame]:
        return chain.from_iterable(self.batches())

    def raw_record(self, frame: Frame) -> bytes:
        """The record of a frame: its arrival time as it was believed, and the frame's own bytes."""
        return tlog_record(frame.rx_ns, self._buffer[frame.offset : frame.offset + frame.size])

    @property
    def frames(self) -> int:
        """Intact frames, wanted or not."""
        return self._walker.frames

    @property
    def bad_bytes(self) -> int:
        """Bytes that belong to no intact frame and its time stamp."""
        return self._walker.bad_bytes

    @property
    def bad_crc(self) -> int:
        """Candidates with a known id whose checksum does not fit."""
        return self._walker.bad_crc

    @property
    def unknown(self) -> int:
        """Frames with ids that the dialect does not know, passed over."""
        return self._walker.unknown

    @property
    def lost(self) -> int:
        """Frames missing by their senders' sequence numbers."""
        return self._walker.lost

    @property
    def bad_stamps(self) -> int:
        """Wanted frames whose recorded time was not believed."""
        return self._walker.bad_stamps


def tlog_record(rx_ns: int, frame: bytes) -> bytes:
    """One record: the arrival time in microseconds, eight bytes big-endian, and the frame."""
    return (rx_ns // 1000).to_bytes(8, "big") + frame
