"""The manners of a companion component, without I/O: frames and ``now_ns`` in, frames to send and deadlines out.

It finds the vehicle, speaks under its system id, sends the heartbeat, asks for streams and sees that they come,
answers commands, and publishes estimates. Every link has a ``Port``; whoever runs the links writes what
``ports[i].take()`` returns, and logs what ``notebook.take()`` returns.
"""

from dataclasses import dataclass, field
from math import degrees, nan
from typing import Final

from attest_mav.mavlink.component.commands import CommandReader, answer
from attest_mav.mavlink.component.discovery import Vehicle, VehicleDiscovery
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.ports import Port, PortSettings
from attest_mav.mavlink.component.vehicle_data import DataSettings, VehicleData
from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_INVALID,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_STATE_BOOT,
    MAV_STATE_POWEROFF,
    MAV_TYPE_ONBOARD_CONTROLLER,
)
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.framer import Frame
from attest_mav.types import Estimate, ParameterSample

HEARTBEAT_NS: Final = 1_000_000_000
UNKNOWN_SYSTEM: Final = 1
"""What we call the vehicle before it has spoken: the id that autopilots are delivered with."""
CLASH_PAUSE_NS: Final = 60_000_000_000
"""A clash of ids is reported again after this long."""

NOBODY: Final = (0, 0, MAV_AUTOPILOT_INVALID)
PROTOCOL: Final = ("HEARTBEAT", "COMMAND_LONG", "COMMAND_INT", "COMMAND_ACK", "REQUEST_DATA_STREAM")


@dataclass(frozen=True)
class CompanionSettings:
    """Who is who.

    vehicle_system: the vehicle's system id, 0 for the only one. system: ours, 0 for the vehicle's. component: ours.
    publish_hz: rate of the attitude. data: what is asked of the vehicle.
    """

    vehicle_system: int = 0
    system: int = 0
    component: int = 193
    publish_hz: float = 20.0
    data: DataSettings = field(default_factory=DataSettings)


class Companion:
    """One companion component on any number of links. ``links``: a name and the settings of each."""

    def __init__(
        self, dialect: Dialect, settings: CompanionSettings, links: list[tuple[str, PortSettings]], now_ns: int
    ) -> None:
        self.notebook: Final = Notebook()
        self.discovery: Final = VehicleDiscovery(settings.vehicle_system, self.notebook)
        self.data: Final = VehicleData(dialect, settings.data, self.notebook)
        self.state = MAV_STATE_BOOT
        """MAV_STATE of the heartbeat; set by who knows."""
        self.clashes = 0
        self.sender = NOBODY
        """System, component and MAV_AUTOPILOT that samples come from: when it changes, nothing learned holds on."""
        self._system = settings.system or settings.vehicle_system or UNKNOWN_SYSTEM
        self._settings: Final = settings
        self.ports: Final = [
            Port(dialect, name, port, self._system, settings.component, settings.publish_hz, self.notebook)
            for name, port in links
        ]
        self.wanted: Final = self.data.wanted | frozenset([dialect.id_of(name) for name in PROTOCOL])
        """Ids of the messages that ``handle`` understands or passes on, for the framer."""
        self._heartbeat_id: Final = dialect.id_of("HEARTBEAT")
        self._ack_id: Final = dialect.id_of("COMMAND_ACK")
        self._stream_id: Final = dialect.id_of("REQUEST_DATA_STREAM")
        self._command_ids: Final = frozenset([dialect.id_of("COMMAND_LONG"), dialect.id_of("COMMAND_INT")])
        self._heartbeat: Final = dialect.layout("HEARTBEAT").pick("type", "autopilot")
        self._ack: Final = dialect.layout("COMMAND_ACK").pick("command", "result", "target_system", "target_component")
        self._commands: Final = CommandReader(dialect)
        self._estimate: Estimate | None = None
        self._verdict: tuple[float, float, float] = (nan, nan, nan)
        self._next_heartbeat_ns = now_ns
        self._clash_told_ns = now_ns - CLASH_PAUSE_NS

    def handle(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Take one frame from a link; True when it is the vehicle's data and worth decoding."""
        message_id = frame.message_id
        if frame.system == self._system and frame.component == self._settings.component:
            self._hear_own_ids(frame, now_ns)
            return False
        if message_id == self._heartbeat_id:
            return self._hear_heartbeat(link, frame, now_ns)
        if message_id in self._command_ids:
            self._hear_command(link, frame, now_ns)
            return False
        vehicle = self.discovery.vehicle
        if vehicle is None:
            return False
        if frame.system == vehicle.system and frame.component == vehicle.component and link == vehicle.link:
            if message_id != self._ack_id:
                return self.data.arrived(message_id)
            self._hear_ack(frame, now_ns)
        elif message_id == self._stream_id:
            self.data.stream_manager.overheard(f"system {frame.system}", now_ns)
        return False

    def imu_taken(self, message: str, now_ns: int) -> bool:
        """A sample of this inertial message was decoded; True when it is the one in use."""
        return self.data.imu_taken(message, now_ns)

    def parameter_taken(self, sample: ParameterSample) -> None:
        """A parameter of the vehicle was decoded."""
        self.data.autopilot_settings.received(sample)

    def publish(self, estimate: Estimate, now_ns: int) -> None:
        """The newest estimate: sent where and when it is due, and remembered for who asks."""
        self._estimate = estimate
        for port in self.ports:
            port.publish(estimate, now_ns)

    def withdraw(self) -> None:
        """There is no valid estimate any more."""
        self._estimate = None

    def tell_verdict(self, ok: float, tilt: float, heading: float) -> None:
        """The verdict: 1 agrees, 0 does not, -1 undecided; differences in rad, NaN where unknown."""
        self._verdict = (ok, degrees(tilt), degrees(heading))

    def link_broken(self, link: int) -> None:
        """The stream of this link ended, or began anew."""
        self.discovery.link_broken(link)

    def ask_again(self, now_ns: int) -> None:
        """The autopilot rebooted and has forgotten what it was asked."""
        self.data.begin(now_ns)

    def poll(self, now_ns: int) -> None:
        """Do what is due."""
        self.discovery.poll(now_ns)
        vehicle = self.discovery.vehicle
        if vehicle is not None and self.discovery.present:
            port = self.ports[vehicle.link]
            for request in self.data.poll(now_ns):
                port.request(request, vehicle.system, vehicle.component)
            for name in self.data.autopilot_settings.poll(now_ns):
                port.put(port.encoder.param_request_read(vehicle.system, vehicle.component, name))
        if now_ns >= self._next_heartbeat_ns:
            self._next_heartbeat_ns = max(self._next_heartbeat_ns + HEARTBEAT_NS, now_ns + HEARTBEAT_NS // 2)
            self._send_heartbeats()

    @property
    def next_deadline_ns(self) -> int:
        """When ``poll`` is due at the latest; a time in the past is at once."""
        due_ns = self._next_heartbeat_ns
        silence_ns = self.discovery.next_deadline_ns
        if silence_ns is None:
            return due_ns
        data_ns = self.data.next_deadline_ns
        return min(due_ns, silence_ns) if data_ns is None else min(due_ns, silence_ns, data_ns)

    def stop(self) -> None:
        """Say goodbye: the rates set back where configured, and a heartbeat with POWEROFF on every link."""
        vehicle = self.discovery.vehicle
        if vehicle is not None and self._settings.data.restores:
            port = self.ports[vehicle.link]
            for message_id in self.data.stream_manager.asked:
                port.put(port.encoder.set_message_interval(vehicle.system, vehicle.component, message_id, 0))
        for port in self.ports:
            port.heartbeat(MAV_STATE_POWEROFF)

    def _hear_own_ids(self, frame: Frame, now_ns: int) -> None:
        """A frame with our own ids is an echo, or another component that has them too."""
        if frame.message_id != self._heartbeat_id or self._echoed(frame.sequence):
            return
        self.clashes += 1
        if now_ns - self._clash_told_ns >= CLASH_PAUSE_NS:
            self._clash_told_ns = now_ns
            self.notebook.warning(
                f"another component speaks as {frame.system}/{frame.component}, which is us: "
                "give one of the two another component_id"
            )

    def _echoed(self, sequence: int) -> bool:
        """Whether a heartbeat with our ids is one of our own."""
        return any(port.sent_heartbeat(sequence) for port in self.ports)

    def _hear_heartbeat(self, link: int, frame: Frame, now_ns: int) -> bool:
        vehicle_type, autopilot = self._heartbeat.unpack(frame.payload)
        found = self.discovery.heartbeat(link, frame.system, frame.component, vehicle_type, autopilot, now_ns)
        vehicle = self.discovery.vehicle
        if vehicle is None:
            self._forget()
        elif found:
            self._found(vehicle, now_ns)
        if vehicle_type == MAV_TYPE_ONBOARD_CONTROLLER and frame.system == self._system:
            self.ports[link].onboard_heard(frame.component, now_ns)
        return vehicle is not None and frame.system == vehicle.system and frame.component == vehicle.component

    def _hear_command(self, link: int, frame: Frame, now_ns: int) -> None:
        command = self._commands.read(frame)
        system, component = command.target_system, command.target_component
        if (system == 0 and component == 0) or (
            system == self._system and (component == 0 or component == self._settings.component)  # noqa: PLR1714
        ):
            answer(command, self.ports[link], self._estimate, self.state)
        elif command.number == MAV_CMD_SET_MESSAGE_INTERVAL:
            self.data.stream_manager.overheard(f"system {frame.system}", now_ns)

    def _hear_ack(self, frame: Frame, now_ns: int) -> None:
        """The vehicle's answer to our command; MAVLink 1 and some autopilots leave the targets zero."""
        command, result, system, component = self._ack.unpack(frame.payload)
        meant = (system == 0 or system == self._system) and (component == 0 or component == self._settings.component)  # noqa: PLR1714
        if meant and command == MAV_CMD_SET_MESSAGE_INTERVAL:
            self.data.stream_manager.acknowledged(result, now_ns)

    def _forget(self) -> None:
        """There is no vehicle, or none any more because there are several."""
        if self.sender != NOBODY:
            self.sender = NOBODY
            self.withdraw()
            self.data.forget()

    def _found(self, vehicle: Vehicle, now_ns: int) -> None:
        """The vehicle is there, for the first time or again: take its id and ask for its messages."""
        sender = (vehicle.system, vehicle.component, vehicle.autopilot)
        if sender != self.sender:
            self._forget()
            self.sender = sender
        self._system = self._settings.system or vehicle.system
        for port in self.ports:
            port.rename(self._system)
        self.data.vehicle_found(vehicle.autopilot, now_ns)

    def _send_heartbeats(self) -> None:
        """One heartbeat a link, and the verdict beside it where it is wanted and there is one."""
        ok, tilt_deg, heading_deg = self._verdict
        for port in self.ports:
            port.heartbeat(self.state)
            if self._estimate is not None and ok == ok:  # noqa: PLR0124  (NaN: no verdict yet)
                port.put_verdict(self._estimate.t_ns, ok, tilt_deg, heading_deg)
