"""The framer: intact frames between garbage, cut anywhere, are all found, in order, and without a long wait."""

from itertools import pairwise
from random import Random
from typing import Final

from attest_mav.evaluation.fuzz.values import payload
from attest_mav.evaluation.fuzz.violation import require
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.dialect import Dialect, Layout, load_dialect
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.mavlink.wire.frame import MAGIC_V1, MAGIC_V2, SIGNATURE_BYTES, Frame
from attest_mav.mavlink.wire.framer import Framer

LONGEST_WAIT: Final = 1119
"""Bytes behind the end of a frame after which it must have come out."""
PIECES: Final = 60
"""Pieces of one stream: frames and what stands between them."""


class _Stream:
    """Bytes, and the places of the intact frames in them."""

    def __init__(self, rng: Random, dialect: Dialect) -> None:
        self.data = b""
        self.places: Final[list[tuple[int, int]]] = []
        """Begin and end of each intact frame."""
        self._rng: Final = rng
        self._layouts: Final = list(dialect.by_id.values())
        self._senders: Final = [Encoder(dialect, 1, 1), Encoder(dialect, 7, 9, lambda _: rng.randbytes(13))]
        for _ in range(PIECES):
            self._add()

    def _add(self) -> None:
        rng = self._rng
        frame = self._frame(rng.choice(self._layouts))
        kind = rng.randrange(8)
        if kind < 4:
            self.places.append((len(self.data), len(self.data) + len(frame)))
        elif kind == 4:
            frame = frame[: rng.randrange(1, len(frame))]
        elif kind == 5:
            frame = self._damaged(frame)
        elif kind == 6:
            frame = rng.randbytes(rng.randrange(1, 300))
        else:
            frame = bytes(rng.choice((MAGIC_V1, MAGIC_V2, 0, 255)) for _ in range(rng.randrange(1, 40)))
        self.data += frame

    def _frame(self, layout: Layout) -> bytes:
        rng = self._rng
        values = payload(rng, layout, 0.5)
        if layout.message_id < 256 and rng.random() < 0.3:
            whole = values[: rng.randrange(1, len(values) + 1)] if rng.random() < 0.1 else values
            head = bytes((MAGIC_V1, len(whole), rng.randrange(256), 1, 1, layout.message_id))
            return with_checksum(head + whole, layout.crc_extra)
        return rng.choice(self._senders).frame(layout, values)

    def _damaged(self, frame: bytes) -> bytes:
        """A frame with one wrong bit, outside a signature, which no checksum covers."""
        end = len(frame) - (SIGNATURE_BYTES if frame[0] == MAGIC_V2 and frame[2] else 0)
        place = self._rng.randrange(end)
        return frame[:place] + bytes((frame[place] ^ (1 << self._rng.randrange(8)),)) + frame[place + 1 :]


def fuzz_framer(seed: int) -> int:
    """One stream; its pieces."""
    rng = Random(f"framer {seed}")  # noqa: S311  # repeatable, no secret
    dialect = load_dialect()
    stream = _Stream(rng, dialect)
    whole = Framer(dialect, None)
    found = whole.feed(stream.data, 0) + whole.finish(0)
    _check_found(found, stream)
    _check_chunks(rng, Framer(dialect, None), stream, found)
    return PIECES


def _check_found(found: list[Frame], stream: _Stream) -> None:
    """Every intact frame comes out, but where bytes around it happen to be a frame with a right checksum."""
    spans = [(frame.offset, frame.offset + frame.size) for frame in found]
    require(spans == sorted(spans), "frames come out of order")
    require(all(a[1] <= b[0] for a, b in pairwise(spans)), "frames overlap")
    known = set(spans)
    for begin, end in stream.places:
        if (begin, end) not in known:
            chance = any(one[0] < end and begin < one[1] for one in spans)
            require(chance, f"the intact frame at byte {begin} of {len(stream.data)} is lost")


def _check_chunks(rng: Random, framer: Framer, stream: _Stream, expected: list[Frame]) -> None:
    """Cut anywhere, the same frames come, each in time."""
    data, place, found = stream.data, 0, list[Frame]()
    while place < len(data):
        size = rng.choice((1, 7, 60, 300))
        found += framer.feed(data[place : place + size], 0)
        place = min(place + size, len(data))
        due = [one for one in expected if one.offset + one.size <= place - LONGEST_WAIT]
        require(len(found) >= len(due), f"{len(due) - len(found)} frames are held back at byte {place}")
    found += framer.finish(0)
    same = [(one.offset, one.size, one.payload) for one in found]
    require(same == [(one.offset, one.size, one.payload) for one in expected], "the cuts change the frames")
