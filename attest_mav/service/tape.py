"""What goes onto a recording: the vehicle's messages as they were used, our own, and the lines of the log.

Records are those of a tlog. Signatures are taken off, and nothing is kept that was refused: a recording holds no more
than the vehicle tells everybody. Each file begins with the newest of those messages that come only once.
"""

from typing import Final

from attest_mav.logs.tlog.reader import tlog_record
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.component.notes import ERROR, WARNING, Note
from attest_mav.mavlink.constants import MAV_SEVERITY_ERROR, MAV_SEVERITY_INFO, MAV_SEVERITY_WARNING
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame, message_id_at
from attest_mav.mavlink.wire.plain import plain_frame, without_signature

OPENING: Final = ("HEARTBEAT", "AUTOPILOT_VERSION", "SYSTEM_TIME", "GPS_RAW_INT")
"""Messages whose newest one stands at the beginning of each file, beside all values of parameters."""
MAX_PARAMETERS: Final = 200
MAX_WAITING: Final = 1 << 18
"""Bytes that wait to be fetched; what comes then is dropped."""


class Tape:
    """Collects records until they are fetched. epoch_ns: UNIX time minus the host's clock, ns."""

    def __init__(self, dialect: Dialect, epoch_ns: int, component: int) -> None:
        self.lost = 0
        """Frames that found no room."""
        self._dialect: Final = dialect
        self._epoch_ns: Final = epoch_ns
        self._component: Final = component
        self._texts = Encoder(dialect, 1, component)
        self._text_number = 0
        self._text_id: Final = dialect.id_of("STATUSTEXT")
        self._opening_ids: Final = frozenset(dialect.id_of(name) for name in OPENING)
        self._value: Final = dialect.layout("PARAM_VALUE").pick("param_id")
        self._newest: Final[dict[tuple[int, bytes], bytes]] = {}
        self._records = bytearray()
        self._frames = 0

    def hear(self, frame: Frame) -> None:
        """Take a message of the vehicle that was used."""
        if frame.system != self._texts.system:
            self._texts = Encoder(self._dialect, frame.system, self._component)
            self._newest.clear()
        raw = plain_frame(frame, self._dialect)
        if frame.message_id in self._opening_ids:
            self._newest[frame.message_id, b""] = raw
        elif frame.message_id == self._value.layout.message_id:
            (name,) = self._value.unpack(frame.payload)
            if len(self._newest) < MAX_PARAMETERS:
                self._newest[frame.message_id, name] = raw
        self._add(raw, frame.rx_ns)

    def say(self, frame: bytes, now_ns: int) -> None:
        """Take a frame that we send; texts are in the lines of the log too, and whole there."""
        if message_id_at(frame, 0) != self._text_id:
            self._add(without_signature(frame, self._dialect), now_ns)

    def note(self, note: Note, now_ns: int) -> None:
        """Take a line of the log, as STATUSTEXT of ours."""
        severity = MAV_SEVERITY_INFO
        if note.level >= WARNING:
            severity = MAV_SEVERITY_ERROR if note.level >= ERROR else MAV_SEVERITY_WARNING
        self._text_number = self._text_number % 0xFFFF + 1
        for frame in self._texts.statustexts(severity, note.text, self._text_number):
            self._add(frame, now_ns)

    def take(self) -> tuple[bytes, int]:
        """The records since the last call, and the number of their frames."""
        records, frames = bytes(self._records), self._frames
        self._records.clear()
        self._frames = 0
        return records, frames

    def opening(self, now_ns: int) -> bytes:
        """The records with which a new file begins."""
        return b"".join(tlog_record(self._epoch_ns + now_ns, raw) for raw in self._newest.values())

    def _add(self, raw: bytes, rx_ns: int) -> None:
        if len(self._records) > MAX_WAITING:
            self.lost += 1
            return
        self._records += tlog_record(self._epoch_ns + rx_ns, raw)
        self._frames += 1
