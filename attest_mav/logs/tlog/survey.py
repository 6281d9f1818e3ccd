"""What a log holds: the first of two passes over it. It decides what the second one reads."""

from typing import Final

from attest_mav.logs.tlog.census import Census, census_key
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.decode.units import INVALID
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.types import HeartbeatSample, ParameterSample, PositionSample, VelocitySample

IMU_MESSAGES: Final = ("RAW_IMU", "SCALED_IMU", "HIGHRES_IMU", "SCALED_IMU2", "SCALED_IMU3")
"""What a filter can run on."""
TRUTH_MESSAGES: Final = ("SIM_STATE", "SIMSTATE")
"""Of a simulator."""
REFERENCE_MESSAGES: Final = (*TRUTH_MESSAGES, "ATTITUDE_QUATERNION", "ATTITUDE")
"""In the order in which they are chosen: a simulator's truth before the autopilot's opinion."""
NAMED_REFERENCES: Final = (*REFERENCE_MESSAGES, "AHRS2")
"""What can be named as reference."""
Sender = tuple[int, int]
"""(system, component)."""


class Survey:
    """Counts and first finds of a whole log.

    census: its counts and counters. heartbeats: the first one of each sender that flies something. positions: the
    first good one of each system. velocities: the systems with a velocity from GPS_RAW_INT. parameters: of each sender
    and setting the last one that told it.
    """

    def __init__(self, dialect: Dialect) -> None:
        self._heartbeat_id: Final = dialect.id_of("HEARTBEAT")
        self._gps_id: Final = dialect.id_of("GPS_RAW_INT")
        # Without it a receiver's UNIX time means nothing.
        self._clock_id: Final = dialect.id_of("SYSTEM_TIME")
        self._parameter_id: Final = dialect.id_of("PARAM_VALUE")
        wanted = frozenset({self._heartbeat_id, self._gps_id, self._clock_id, self._parameter_id})
        self.census: Final = Census(dialect, wanted)
        self.heartbeats: Final[dict[Sender, Frame]] = {}
        self.positions: Final[dict[int, PositionSample]] = {}
        self.velocities: Final[set[int]] = set()
        self.parameters: Final[dict[Sender, dict[int, ParameterSample]]] = {}
        self._dialect: Final = dialect
        self._decoder: Final = Decoder(dialect)

    def take(self, frames: list[Frame]) -> None:
        """Take the next frames that the census gives."""
        for frame in frames:
            if frame.message_id == self._clock_id:
                self._decoder.decode(frame)
            elif frame.message_id == self._gps_id:
                self._take_fix(frame)
            elif frame.message_id == self._heartbeat_id and (frame.system, frame.component) not in self.heartbeats:
                self._take_heartbeat(frame)
            elif frame.message_id == self._parameter_id:
                self._take_parameter(frame)

    def _take_fix(self, frame: Frame) -> None:
        if frame.system in self.positions and frame.system in self.velocities:
            return
        for sample in self._decoder.decode(frame):
            if isinstance(sample, PositionSample):
                self.positions.setdefault(frame.system, sample)
            elif isinstance(sample, VelocitySample):
                self.velocities.add(frame.system)

    def _take_heartbeat(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, HeartbeatSample) and sample.autopilot != INVALID:
                self.heartbeats[frame.system, frame.component] = frame

    def _take_parameter(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, ParameterSample):
                self.parameters.setdefault((frame.system, frame.component), {})[sample.setting] = sample

    @property
    def duration_s(self) -> float:
        """Time between the arrivals of the first and the last message, s."""
        return (self.census.last_rx_ns - self.census.first_rx_ns) * 1e-9

    def autopilot(self, sender: Sender) -> int | None:
        """The sender's MAV_AUTOPILOT; None when no heartbeat tells."""
        return self._decoder.autopilots.get(sender[0])

    def told(self, sender: Sender) -> list[ParameterSample]:
        """The parameters by which the sender told a setting."""
        return list(self.parameters.get(sender, {}).values())

    def senders(self) -> list[Sender]:
        """Everyone who sent something."""
        return sorted({((key >> 8) & 0xFF, key & 0xFF) for key in self.census.counts})

    def count(self, sender: Sender, name: str) -> int:
        """How many messages of that name the sender sent."""
        return self.census.counts.get(census_key(*sender, self._dialect.id_of(name)), 0)
