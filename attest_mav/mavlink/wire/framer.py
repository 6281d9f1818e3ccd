"""The frames of a link, from bytes as they arrive; ``attest_mav.mavlink.wire.walker`` says how they are found.

Waiting
    A candidate with a known id whose end has not arrived holds back what is behind it, for at most 279 bytes (the
    longest frame less one). One with an unknown id where a frame is expected does so for at most 1119 bytes (four
    frames less one). A candidate inside a frame that was found behind garbage holds this frame back too, since it may
    be the real one. So a false magic delays frames and loses none; ``Framer.finish`` ends the wait.
"""

from mypy_extensions import i64

from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.mavlink.wire.walker import AcceptanceCheck, Walker

__all__ = ["Frame", "Framer"]


class Framer(Walker):
    """Takes bytes cut anywhere.

    wanted: the ids to return; None for all. The rest is checked and counted, and costs little. accepts: an optional
    check of each wanted frame, such as of its signature. The counters are those of Walker.
    """

    def __init__(self, dialect: Dialect, wanted: frozenset[int] | None, accepts: AcceptanceCheck | None = None) -> None:
        super().__init__(dialect, wanted, 0, looks_behind=False, accepts=accepts)
        self._pending = b""
        self._rx_ns: i64 = 0

    def feed(self, data: bytes, rx_ns: int) -> list[Frame]:
        """The wanted frames completed by data, which arrived at rx_ns (host clock)."""
        return self._continue(data, rx_ns, False)

    def finish(self, rx_ns: int) -> list[Frame]:
        """The wanted frames behind candidates that were still waited for: for a stream that ends or falls silent."""
        return self._continue(b"", rx_ns, True)

    def reset(self) -> None:
        """Forgets the bytes and sequence numbers of the present stream, for a link opened again. Counters stay."""
        self.bad_bytes += len(self._pending)
        self._base += len(self._pending)
        self._pending = b""
        self._place = 0
        self._searching = False
        self._sequences.forget()

    def _continue(self, data: bytes, rx_ns: int, final: bool) -> list[Frame]:
        self._rx_ns = rx_ns
        buffer = self._pending + data if self._pending else data
        frames = self._walk(buffer, len(buffer), final)
        self._pending = buffer[self._done :]
        self._forget_done()
        return frames

    def _arrival(self, size: i64) -> i64:
        return self._rx_ns
