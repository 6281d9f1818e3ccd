"""The fake autopilot: a vehicle with a true motion, sensors with errors, and a MAVLink personality. No I/O.

Time is an argument, integer nanoseconds from 0, the start of the simulation. Inside, it advances in ticks: at every
sensor tick (at least 400 a second) all sensors take a sample; at every loop tick (one in so many sensor ticks) what
has arrived is answered and what is due is sent. Nothing depends on when or how often the methods are called, so one
seed and one series of inputs give the same bytes always::

    vehicle = FakeAutopilot(SimSettings(scenario="square"), seed=1)
    vehicle.handle(data, now_ns)                 whenever bytes arrive
    for frame in vehicle.frames_until(now_ns):   at next_deadline_ns, or later
        ...
"""

from math import ceil
from typing import Final

from attest_mav.errors import UsageError
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.constants import INERTIAL_MESSAGES, MAV_COMP_ID_AUTOPILOT1
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.mavlink.wire.framer import Frame, Framer
from attest_mav.sim.commands import UNDERSTOOD, Commands
from attest_mav.sim.faults import Effect, FaultSchedule, Part, has
from attest_mav.sim.lanes import Lanes
from attest_mav.sim.messages import Messages
from attest_mav.sim.motion import Motion
from attest_mav.sim.parameters import ParameterTable
from attest_mav.sim.personality import fitted, personality_of
from attest_mav.sim.report import AttitudeReport
from attest_mav.sim.scenarios import make_trajectory
from attest_mav.sim.sensors import SensorSuite
from attest_mav.sim.settings import SimSettings
from attest_mav.sim.streams import Streams

SENSOR_RATE_HZ: Final = 400
"""Sensors take at least so many samples a second, however slow the loop is."""

MAX_RATE_HZ: Final = 1000
"""The fastest stream, and the fastest loop."""
MIN_LOOP_HZ: Final = 10

REBOOT_S: Final = 2.0
"""How long a restart keeps silent."""


class FakeAutopilot:
    """One vehicle. Raises UsageError for settings that make no sense."""

    def __init__(self, settings: SimSettings, seed: int, dialect: Dialect | None = None) -> None:
        self.settings = settings
        self.trajectory = make_trajectory(settings.scenario, seed)
        firmware = personality_of(settings.personality)
        self.personality = fitted(firmware, self.trajectory.vehicle_type, settings.low_pass_hz)
        self.loop_hz = self._checked_loop_rate()
        self.oversample = -(-SENSOR_RATE_HZ // self.loop_hz)
        self.sensor_hz = self.loop_hz * self.oversample
        dialect = load_dialect() if dialect is None else dialect
        firmware = self.personality
        self.faults = FaultSchedule(settings.faults)
        self.sensors = SensorSuite(settings, firmware, self.trajectory, self.faults, self.sensor_hz, seed)
        self.lanes = Lanes(self.sensors, seed)
        report = AttitudeReport(settings.attitude_error, self.lanes, self.faults, seed)
        parameters = ParameterTable(firmware, settings, self.trajectory.is_plane)
        self.messages = Messages(settings, firmware, dialect, self.trajectory, self.sensors, report, parameters)
        self.commands = Commands(settings.system, MAV_COMP_ID_AUTOPILOT1, firmware, dialect, parameters)
        self.framer = Framer(dialect, frozenset(dialect.id_of(name) for name in UNDERSTOOD))
        self.dialect = dialect
        self.encoder = Encoder(dialect, settings.system, MAV_COMP_ID_AUTOPILOT1)
        self.inbox: list[Frame] = []
        self.tick = 0
        self.boot_ns = 0
        self.silent_until_ns = 0
        self.reboots_ns = self.faults.starts_ns(Part.VEHICLE, Effect.REBOOT)
        self.texts: list[tuple[int, str]] = []
        """STATUSTEXTs that go out with the next message that is due: severity and text."""
        self.streams = self._booted_streams()

    def _checked_loop_rate(self) -> int:
        settings, firmware = self.settings, self.personality
        rate_hz = 1.0 if settings.fast_rate_hz is None else settings.fast_rate_hz
        if not 1.0 <= rate_hz <= MAX_RATE_HZ:
            raise UsageError(f"rate {rate_hz:g} Hz is out of range: expected 1 to {MAX_RATE_HZ}")
        usual = firmware.plane_loop_hz if self.trajectory.is_plane else firmware.copter_loop_hz
        # Messages take at most 80 % of the loop rate: whoever wants them faster runs the loop faster. Whole multiples
        # of the usual rate keep the messages' ticks even.
        loop_hz = settings.loop_rate_hz or min(usual * max(ceil(1.25 * rate_hz / usual), 1), MAX_RATE_HZ)
        if not MIN_LOOP_HZ <= loop_hz <= MAX_RATE_HZ:
            raise UsageError(f"loop rate {loop_hz} Hz is out of range: expected {MIN_LOOP_HZ} to {MAX_RATE_HZ}")
        return loop_hz

    def _booted_streams(self) -> Streams:
        return Streams(self.personality, self.loop_hz, self.settings.fast_rate_hz)

    # --- the outside -------------------------------------------------------------------------------------------

    def handle(self, data: bytes, now_ns: int) -> None:
        """Take bytes from the link; they are acted upon at the next loop tick. ``now_ns`` must never go back."""
        self.inbox.extend(self.framer.feed(data, now_ns))

    def frames_until(self, now_ns: int) -> list[bytes]:
        """All frames that were sent since the last call, up to and including ``now_ns``, oldest first."""
        out: list[bytes] = []
        while (t_ns := self.tick * 1_000_000_000 // self.sensor_hz) <= now_ns:
            motion = self._sample(t_ns)
            if self.tick % self.oversample == 0:
                self._loop(t_ns, motion, out)
            self.tick += 1
        return out

    @property
    def next_deadline_ns(self) -> int:
        """When ``frames_until`` will have something, or may: the loop tick at which the next message is due."""
        due_ns = max(self.boot_ns + self.streams.next_ns, self.silent_until_ns)
        if self.inbox:
            due_ns = min(due_ns, self.inbox[0].rx_ns + 1)
        loop = max(-(-due_ns * self.loop_hz // 1_000_000_000), -(-self.tick // self.oversample))
        return self._time_of(loop * self.oversample)

    def truth(self, t_ns: int) -> Motion:
        """The true motion at any time."""
        return self.trajectory.at(t_ns * 1e-9)

    def __str__(self) -> str:
        """Firmware, scenario, inertial message and its rate, for people."""
        imu = next(name for name in self.streams.names if name in INERTIAL_MESSAGES)
        rate_hz = 1e9 / self.streams.intervals[imu]
        return f"{self.personality.name} vehicle, scenario {self.settings.scenario}, {imu} at {rate_hz:.4g} Hz"

    # --- the inside --------------------------------------------------------------------------------------------

    def _time_of(self, tick: int) -> int:
        return tick * 1_000_000_000 // self.sensor_hz

    def _sample(self, t_ns: int) -> Motion:
        motion = self.trajectory.at(t_ns * 1e-9)
        self.sensors.update(t_ns, motion)
        if self.settings.faults and self.lanes.step(1.0 / self.sensor_hz, t_ns, motion):
            lane = self.lanes.selected
            self.texts += [(severity, text.format(lane)) for severity, text in self.personality.lane_texts]
        return motion

    def _loop(self, t_ns: int, motion: Motion, out: list[bytes]) -> None:
        if self.reboots_ns and t_ns >= self.reboots_ns[0]:
            del self.reboots_ns[0]
            self._reboot(t_ns)
        arrived = self._take_inbox(t_ns)
        if t_ns < self.silent_until_ns:
            return
        self.messages.begin(t_ns, self.boot_ns, motion)
        due = self.streams.take_due(t_ns - self.boot_ns)
        for name in due:
            self._send(name, None, out)
        if due:
            out += [self.encoder.statustext(severity, text) for severity, text in self.texts]
            self.texts.clear()
        for frame in arrived:
            for name, payload in self.commands.answer(frame, self.streams, t_ns, self.boot_ns):
                self._send(name, payload, out)

    def _take_inbox(self, t_ns: int) -> list[Frame]:
        count = 0
        while count < len(self.inbox) and self.inbox[count].rx_ns < t_ns:
            count += 1
        arrived, self.inbox = self.inbox[:count], self.inbox[count:]
        return arrived

    def _send(self, name: str, payload: bytes | None, out: list[bytes]) -> None:
        if name in INERTIAL_MESSAGES and self._is_silent(name):
            return
        filled = self.messages.payload(name) if payload is None else payload
        out.append(self.encoder.frame(self.dialect.layout(name), filled))

    def _is_silent(self, name: str) -> bool:
        """Whether the sensor that an inertial message is about sends none."""
        sensor = self.lanes.selected if name == "HIGHRES_IMU" else int(name == "SCALED_IMU2")
        return has(self.faults.active(Part.IMU, self.messages.t_s, sensor), Effect.SILENT)

    def _reboot(self, t_ns: int) -> None:
        self.boot_ns = t_ns
        self.silent_until_ns = t_ns + round(REBOOT_S * 1e9)
        self.streams = self._booted_streams()
        self.lanes.restart()
        self.texts.clear()
        self.encoder = Encoder(self.dialect, self.settings.system, MAV_COMP_ID_AUTOPILOT1)
