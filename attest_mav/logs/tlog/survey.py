"""The first pass over a tlog: it counts all messages and decodes the few that decide what the second pass reads."""

from typing import Final

from attest_mav.logs.source import VehicleId
from attest_mav.logs.tlog.attitude_survey import AttitudeSurvey
from attest_mav.logs.tlog.clocks import LogClocks
from attest_mav.logs.tlog.message_counter import MessageCounter
from attest_mav.logs.tlog.roles import TLOG_ROLES
from attest_mav.logs.tlog.stamp_repair import with_time
from attest_mav.logs.tlog.stamps import TimeField, time_field
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID
from attest_mav.mavlink.decode.boot_clock import UNIX_US, BootClock
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import AttitudeSample, PositionSample, VelocitySample
from attest_mav.vehicle_reports import ClockSample, FirmwareSample, HeartbeatSample, ParameterSample


class Survey:
    """Counts and first samples of a whole log."""

    def __init__(self, dialect: Dialect, bare: bool = False) -> None:
        self._heartbeat_id: Final = dialect.id_of("HEARTBEAT")
        self._gps_id: Final = dialect.id_of("GPS_RAW_INT")
        # Without SYSTEM_TIME a receiver's UNIX time cannot be related to the time since boot.
        self._clock_id: Final = dialect.id_of("SYSTEM_TIME")
        self._parameter_id: Final = dialect.id_of("PARAM_VALUE")
        self._firmware_ids: Final = frozenset([dialect.id_of("AUTOPILOT_VERSION"), dialect.id_of("STATUSTEXT")])
        self._attitude_ids: Final = frozenset([dialect.id_of(name) for name in TLOG_ROLES.named_reference])
        wanted = self._firmware_ids.union([self._heartbeat_id, self._gps_id, self._clock_id, self._parameter_id])
        self.counter: Final = MessageCounter(dialect, wanted.union(self._attitude_ids), bare)
        """Counts of all messages."""
        self.heartbeats: Final[dict[VehicleId, Frame]] = {}
        """The first heartbeat of each flight controller."""
        self.first_heartbeats: Final[dict[VehicleId, HeartbeatSample]] = {}
        """The same, decoded."""
        self.firmware: Final[dict[VehicleId, FirmwareSample]] = {}
        """The first word of each sender on its firmware."""
        self.positions: Final[dict[int, PositionSample]] = {}
        """The first position with a 3-D fix, by system."""
        self.velocities: Final[set[int]] = set()
        """The systems with a velocity in GPS_RAW_INT."""
        self.untimed_velocities: Final[set[int]] = set()
        """The systems with one whose time cannot be related to the time since boot."""
        self.attitudes: Final = AttitudeSurvey()
        self.told_us: Final[dict[int, int]] = {}
        """The first UNIX time that a receiver told, us, by system."""
        self.boot_clock: Final = BootClock()
        self.parameters: Final[dict[VehicleId, dict[int, ParameterSample]]] = {}
        """The last parameter of each setting, by sender."""
        self.first_parameters: Final[dict[VehicleId, dict[int, ParameterSample]]] = {}
        """The first one of each, where it is part of a list: a change tells nothing of the time before."""
        self._decoder: Final = Decoder(dialect)
        self._fix_time: Final[TimeField] = time_field(dialect, "GPS_RAW_INT")

    @property
    def autopilots(self) -> dict[int, int]:
        """MAV_AUTOPILOT by system, as far as heartbeats tell it."""
        return self._decoder.autopilots

    def clocks(self) -> LogClocks:
        """The judgement on the clocks; to be called when all frames have been taken."""
        return LogClocks(self.counter, self.boot_clock)

    def take(self, frames: list[Frame]) -> None:
        """Take the next frames that the counter returns."""
        for frame in frames:
            if frame.message_id == self._clock_id:
                self._take_clock(frame)
            elif frame.message_id in self._attitude_ids:
                self._take_attitude(frame)
            elif frame.message_id == self._gps_id:
                self._take_fix(frame)
            elif frame.message_id == self._heartbeat_id and (frame.system, frame.component) not in self.heartbeats:
                self._take_heartbeat(frame)
            elif frame.message_id == self._parameter_id:
                self._take_parameter(frame)
            elif frame.message_id in self._firmware_ids:
                self._take_firmware(frame)

    def _take_clock(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, ClockSample):
                self.boot_clock.learn(frame.system, sample.unix_us, sample.t_ns // 1_000_000)
                if sample.unix_us >= UNIX_US:
                    self.told_us.setdefault(frame.system, sample.unix_us)

    def _take_attitude(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, AttitudeSample):
                self.attitudes.take(frame.offset, sample)

    def _take_fix(self, frame: Frame) -> None:
        """Position and velocity; without a usable time they still tell the place, and that there is a velocity."""
        if frame.system in self.positions and frame.system in self.velocities:
            return
        samples = self._decoder.decode(frame)
        has_time = bool(samples)
        for sample in samples or self._decoder.decode(with_time(frame, self._fix_time, 0)):
            if isinstance(sample, PositionSample):
                self.positions.setdefault(frame.system, sample)
            elif isinstance(sample, VelocitySample):
                (self.velocities if has_time else self.untimed_velocities).add(frame.system)

    def _take_heartbeat(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, HeartbeatSample) and sample.autopilot != MAV_AUTOPILOT_INVALID:
                self.heartbeats[frame.system, frame.component] = frame
                self.first_heartbeats[frame.system, frame.component] = sample

    def _take_parameter(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, ParameterSample):
                sender = (frame.system, frame.component)
                known = self.parameters.setdefault(sender, {})
                if sample.is_listed and sample.setting not in known:
                    self.first_parameters.setdefault(sender, {})[sample.setting] = sample
                known[sample.setting] = sample

    def _take_firmware(self, frame: Frame) -> None:
        for sample in self._decoder.decode(frame):
            if isinstance(sample, FirmwareSample):
                self.firmware.setdefault((frame.system, frame.component), sample)
