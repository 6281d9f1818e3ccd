"""A line that does anything to frames: it loses, delays, copies, edits, forges and cuts."""

from collections import deque
from collections.abc import Iterable
from random import Random
from typing import Final

from attest_mav.evaluation.disturbed_flights.frames import message_id
from attest_mav.evaluation.fuzz.values import payload
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.mavlink.wire.frame import CHECKSUM_BYTES, HEADER_V2

SHARES: Final = (0.0, 0.0, 0.002, 0.02, 0.2)
"""Shares of the frames to which one thing happens."""
MEMORY: Final = 200
"""Frames that may be replayed."""


class HostileLine:
    """See ``service_flight.Line``. is_honest: frames are lost, delayed and copied, and none is edited or forged."""

    def __init__(self, rng: Random, dialect: Dialect, is_honest: bool) -> None:
        self._rng: Final = rng
        self._dialect: Final = dialect
        self._lost, self._delayed, self._copied, self._damaged = (rng.choice(SHARES) for _ in range(4))
        edits = (0.0,) if is_honest else SHARES
        self._edited, self._forged, self._replayed = (rng.choice(edits) for _ in range(3))
        self._delay_s: Final = rng.choice((0.05, 0.4, 3.0))
        self._backlog_s = 0.0
        self._growth: Final = rng.choice((0.0, 0.0, 0.1, 0.9))
        self._cut_until_ns = 0
        self._deaf: Final = rng.choice((0.0, 0.0, 0.3, 1.0))
        self._layouts: Final = list(dialect.by_id.values())
        self._forgers: Final = [
            Encoder(dialect, *ids) for ids in ((1, 1), (1, 1), (1, 191), (1, 193), (2, 1), (255, 190))
        ]
        self._past: Final[deque[bytes]] = deque(maxlen=MEMORY)
        self._last_ns = 0

    def deliver(self, now_ns: int, frames: list[bytes]) -> Iterable[tuple[int, bytes]]:
        """See ``Line``."""
        rng = self._rng
        if rng.random() < 1e-3:
            self._cut_until_ns = now_ns + round(1e9 * rng.choice((0.3, 0.8, 3.0, 8.0)))
        self._grow(now_ns)
        for frame in [*frames, *self._others()]:
            if now_ns < self._cut_until_ns or rng.random() < self._lost:
                continue
            self._past.append(frame)
            for _ in range(1 + (rng.random() < self._copied)):
                late_s = self._backlog_s + (self._delay_s * rng.random() if rng.random() < self._delayed else 0.0)
                yield now_ns + round(late_s * 1e9), self._changed(frame)

    def passes(self, _now_ns: int, _frame: bytes) -> bool:
        """See ``Line``."""
        return self._rng.random() >= self._deaf

    def _grow(self, now_ns: int) -> None:
        """A backlog grows, and is gone at once now and then."""
        self._backlog_s += self._growth * (now_ns - self._last_ns) * 1e-9
        self._last_ns = now_ns
        if self._rng.random() < 3e-4:
            self._backlog_s = 0.0

    def _others(self) -> list[bytes]:
        """Frames of forgers, and old ones again."""
        rng, found = self._rng, list[bytes]()
        while rng.random() < self._forged:
            layout = rng.choice(self._layouts)
            if rng.random() < 0.8 and self._past:
                layout = self._dialect.by_id.get(message_id(rng.choice(self._past)), layout)
            found.append(rng.choice(self._forgers).frame(layout, payload(rng, layout, rng.choice((0.1, 1.0)))))
        if self._past and rng.random() < self._replayed:
            found.append(rng.choice(self._past))
        return found

    def _changed(self, frame: bytes) -> bytes:
        """The frame with other values, or with a wrong bit."""
        rng = self._rng
        if rng.random() < self._edited:
            layout = self._dialect.by_id[message_id(frame)]
            values = payload(rng, layout, rng.choice((0.05, 0.3, 1.0)), frame[HEADER_V2:-CHECKSUM_BYTES])
            values = values.rstrip(b"\0") or values[:1]
            frame = with_checksum(frame[:1] + bytes((len(values),)) + frame[2:HEADER_V2] + values, layout.crc_extra)
        if rng.random() < self._damaged:
            place = rng.randrange(len(frame))
            frame = frame[:place] + rng.randbytes(rng.choice((1, 1, 5))) + frame[place + rng.choice((0, 1, 9)) :]
        return frame
