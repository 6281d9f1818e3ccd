"""A tlog with our attitudes inserted: all bytes of the original stay, in order, and our records stand between them."""

from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.logs.source import ByteSink, LogBytes
from attest_mav.logs.tlog.reader import tlog_record
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.component.outputs import boot_ms, is_sound

OUR_COMPONENT: Final = 193
"""The component id of inserted messages, the daemon's default."""

COPY_BYTES: Final = 1 << 20
"""The original is copied in pieces of this size."""


class AnnotatedLogWriter:
    """Writes ATTITUDE_QUATERNION of our own component behind the record of each sample it was estimated from."""

    def __init__(self, original: LogBytes, sink: ByteSink, encoder: Encoder) -> None:
        self._original: Final = original
        self._sink: Final = sink
        self._encoder: Final = encoder
        self._copied = 0

    def insert(self, estimate: Estimate, position: int) -> None:
        """Insert an estimate at this offset of the original, the end of its sample's record. Offsets never decrease.

        An estimate that the daemon would not send is not inserted.
        """
        if not is_sound(estimate):
            return
        self._copy_to(position)
        frame = self._encoder.attitude_quaternion(boot_ms(estimate.t_ns), estimate.q_nb, estimate.rates)
        self._sink.write(tlog_record(estimate.rx_ns, frame))

    def finish(self) -> None:
        """Copy the rest of the original."""
        self._copy_to(len(self._original))

    def _copy_to(self, offset: int) -> None:
        while self._copied < offset:
            stop = min(offset, self._copied + COPY_BYTES)
            self._sink.write(self._original[self._copied : stop])
            self._copied = stop
