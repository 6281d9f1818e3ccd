"""What a log holds: the first of two passes over it. It decides what the second one reads."""

from collections import Counter
from typing import Final

from attest_mav.mavlink.decoding import Decoder
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.framing import Frame
from attest_mav.mavlink.units import INVALID
from attest_mav.types import HeartbeatSample, PositionSample

IMU_MESSAGES: Final = ("RAW_IMU", "SCALED_IMU", "HIGHRES_IMU", "SCALED_IMU2", "SCALED_IMU3")
"""What a filter can run on."""
REFERENCE_MESSAGES: Final = ("SIM_STATE", "SIMSTATE", "ATTITUDE_QUATERNION", "ATTITUDE")
"""In the order in which they are chosen: a simulator's truth before the autopilot's opinion."""
NAMED_REFERENCES: Final = (*REFERENCE_MESSAGES, "AHRS2")
"""What can be named as reference."""
SURVEYED: Final = (*IMU_MESSAGES, *NAMED_REFERENCES, "HEARTBEAT", "GPS_RAW_INT")

Sender = tuple[int, int]
"""(system, component)."""


class Survey:
    """Counts and first finds of a whole log.

    frames, bad_bytes: of the whole log. first_rx_ns, last_rx_ns: arrival of the first and last surveyed message.
    heartbeats: the first one of each sender that flies something. positions: the first good one of each system.
    """

    def __init__(self, dialect: Dialect) -> None:
        self.wanted: Final = frozenset(dialect.id_of(name) for name in SURVEYED)
        self.frames = 0
        self.bad_bytes = 0
        self.first_rx_ns = 0
        self.last_rx_ns = 0
        self.heartbeats: Final[dict[Sender, Frame]] = {}
        self.positions: Final[dict[int, PositionSample]] = {}
        self._dialect: Final = dialect
        self._decoder: Final = Decoder(dialect)
        self._counts: Final[Counter[tuple[int, int, int]]] = Counter()
        self._heartbeat_id: Final = dialect.id_of("HEARTBEAT")
        self._gps_id: Final = dialect.id_of("GPS_RAW_INT")

    def take(self, frames: list[Frame]) -> None:
        """Take the next frames of the log."""
        if not frames:
            return
        if not self._counts:
            self.first_rx_ns = frames[0].rx_ns
        self.last_rx_ns = frames[-1].rx_ns
        self._counts.update([(frame.system, frame.component, frame.message_id) for frame in frames])
        for frame in frames:
            if frame.message_id == self._gps_id and frame.system not in self.positions:
                self._take_position(frame)
            elif frame.message_id == self._heartbeat_id and (frame.system, frame.component) not in self.heartbeats:
                self._take_heartbeat(frame)

    def _take_position(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, PositionSample):
                self.positions[frame.system] = sample

    def _take_heartbeat(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, HeartbeatSample) and sample.autopilot != INVALID:
                self.heartbeats[frame.system, frame.component] = frame

    @property
    def duration_s(self) -> float:
        """Time between the arrivals of the first and the last of the surveyed messages, s."""
        return (self.last_rx_ns - self.first_rx_ns) * 1e-9

    def autopilot(self, sender: Sender) -> int | None:
        """The sender's MAV_AUTOPILOT; None when no heartbeat tells."""
        return self._decoder.autopilots.get(sender[0])

    def senders(self) -> set[Sender]:
        """Everyone who sent a surveyed message."""
        return {(system, component) for system, component, _ in self._counts}

    def count(self, sender: Sender, name: str) -> int:
        """How many messages of that name the sender sent."""
        return self._counts[*sender, self._dialect.id_of(name)]
