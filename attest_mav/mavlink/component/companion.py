"""A MAVLink companion component without I/O: frames and ``now_ns`` in, frames to send and deadlines out.

The companion finds the vehicle, takes its system id, sends the heartbeat, requests streams and measures them, answers
commands, and publishes estimates. Every link has a ``Port``: the caller writes the frames of ``ports[i].take()`` to
link i, and logs the notes of ``notebook.take()``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import degrees
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.announcer import Announcer
from attest_mav.mavlink.component.commands import CommandReader, answer
from attest_mav.mavlink.component.discovery import Vehicle, VehicleDiscovery
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.outputs import NO_VERDICT, Confidence, Publication, PublishedVerdict
from attest_mav.mavlink.component.own_ids import OwnIds
from attest_mav.mavlink.component.ports import Port, PortSettings
from attest_mav.mavlink.component.timesync import TimeSync
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
from attest_mav.vehicle_reports import ParameterSample

HEARTBEAT_NS: Final = 1_000_000_000
UNKNOWN_SYSTEM: Final = 1
"""Our system id before a vehicle is found: the one that autopilots are delivered with."""

NOBODY: Final = (0, 0, MAV_AUTOPILOT_INVALID)
"""The sender while there is no vehicle."""

Handler = Callable[[int, Frame, int], bool]
"""Takes the number of a link, a frame from it and now_ns; True when the frame is the vehicle's data, to be decoded."""


@dataclass(frozen=True)
class CompanionSettings:
    """Identity, rate, and the data that are requested."""

    vehicle_system: int = 0
    """The vehicle's system id; 0 takes the only one that is heard."""
    system: int = 0
    """Our system id; 0 takes the vehicle's."""
    component: int = 193
    """Our component id."""
    publish_hz: float = 20.0
    """Rate of the attitude on every link, Hz."""
    data: DataSettings = field(default_factory=DataSettings)
    """The messages and settings requested of the vehicle."""
    timesync: bool = True
    """Whether the vehicle is asked for its time."""


class Companion:
    """One companion component on any number of links. ``links``: a name and the settings of each."""

    def __init__(
        self, dialect: Dialect, settings: CompanionSettings, links: list[tuple[str, PortSettings]], now_ns: int
    ) -> None:
        self.notebook: Final = Notebook()
        self.discovery: Final = VehicleDiscovery(settings.vehicle_system, self.notebook)
        self.data: Final = VehicleData(dialect, settings.data, self.notebook)
        self.state = MAV_STATE_BOOT
        """MAV_STATE of the heartbeat; set by the service, which knows the estimate and the verdict."""
        self.sender = NOBODY
        """System, component and MAV_AUTOPILOT of the vehicle. When it changes, everything learned about the previous
        vehicle is dropped."""
        self._system = settings.system or settings.vehicle_system or UNKNOWN_SYSTEM
        self._settings: Final = settings
        self.ports: Final = [
            Port(dialect, name, port, self._system, settings.component, settings.publish_hz, self.notebook)
            for name, port in links
        ]
        self.handlers: Final[dict[int, Handler]] = {
            dialect.id_of("HEARTBEAT"): self._hear_heartbeat,
            dialect.id_of("COMMAND_LONG"): self._hear_command,
            dialect.id_of("COMMAND_INT"): self._hear_command,
            dialect.id_of("COMMAND_ACK"): self._hear_ack,
            dialect.id_of("REQUEST_DATA_STREAM"): self._hear_stream_request,
            dialect.id_of("TIMESYNC"): self._hear_timesync,
        }
        """By message id. Frames with another id are data if they come from the vehicle, and are dropped otherwise."""
        self.timesync: Final = TimeSync(dialect, settings.timesync, self.notebook)
        """Exchanges of time with the vehicle."""
        self.announcer: Final = Announcer()
        """Texts for people, which go out on every link that carries texts."""
        self.own_ids: Final = OwnIds(self.ports, self.notebook, now_ns)
        self._heartbeat: Final = dialect.layout("HEARTBEAT").pick("type", "autopilot")
        self._ack: Final = dialect.layout("COMMAND_ACK").pick("command", "result", "target_system", "target_component")
        self._commands: Final = CommandReader(dialect)
        self._version_id: Final = dialect.id_of("AUTOPILOT_VERSION")
        self._estimate: Estimate | None = None
        self._confidence = Confidence.BELIEVED
        self._verdict = NO_VERDICT
        self._next_heartbeat_ns = now_ns

    def handle(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Take one frame from a link; True when it is the vehicle's data and worth decoding."""
        if frame.system == self._system and frame.component == self._settings.component:
            self.own_ids.heard(frame, now_ns)
            return False
        handler = self.handlers.get(frame.message_id)
        if handler is not None:
            return handler(link, frame, now_ns)
        return self._is_from_vehicle(link, frame) and self.data.arrived(frame.message_id)

    @property
    def wanted(self) -> frozenset[int]:
        """Ids of the messages that ``handle`` understands or passes on, for the framers."""
        return self.data.wanted | frozenset(self.handlers)

    def imu_taken(self, source: str, now_ns: int) -> bool:
        """Take note of a decoded inertial sample from this source; True when it is in use."""
        return self.data.imu_taken(source, now_ns)

    def parameter_taken(self, sample: ParameterSample) -> None:
        """Take note of a decoded parameter of the vehicle."""
        self.data.parameter_taken(sample)

    def publish(self, estimate: Estimate, now_ns: int, confidence: Confidence = Confidence.BELIEVED) -> None:
        """Send the newest estimate on every link where it is due, and keep it for requests.

        confidence: outputs that need a higher one are not sent.
        """
        self._estimate, self._confidence = estimate, confidence
        publication = Publication(estimate, self._verdict, confidence)
        for port in self.ports:
            port.publish(publication, now_ns)

    def withdraw(self) -> None:
        """Drop the estimate: it is not valid any more."""
        self._estimate = None

    def set_verdict(self, ok: float, tilt: float, heading: float) -> None:
        """Take the verdict: ok is 1 (agrees), 0 (disagrees), -1 (undecided); differences in rad, NaN where unknown."""
        self._verdict = PublishedVerdict(ok, degrees(tilt), degrees(heading))

    def link_broken(self, link: int) -> None:
        """The stream of this link ended, or began anew."""
        self.discovery.link_broken(link)

    def ask_again(self, now_ns: int) -> None:
        """Request everything again: the autopilot has rebooted and lost the requests."""
        self.data.begin(now_ns)
        self.timesync.begin(now_ns)

    def poll(self, now_ns: int) -> None:
        """Send the requests, heartbeats and notes that are due."""
        self.discovery.poll(now_ns)
        vehicle = self.discovery.vehicle
        if vehicle is not None and self.discovery.present:
            port = self.ports[vehicle.link]
            for request in self.data.poll(now_ns):
                port.request(request, vehicle.system, vehicle.component)
            for name in self.data.autopilot_settings.poll(now_ns):
                port.put(port.encoder.param_request_read(vehicle.system, vehicle.component, name))
            if self.data.take_version_request():
                port.put(port.encoder.request_message(vehicle.system, vehicle.component, self._version_id))
        if vehicle is not None and self.timesync.poll(now_ns):
            port = self.ports[vehicle.link]
            port.put(port.encoder.timesync(0, now_ns, vehicle.system, vehicle.component))
        announcement = self.announcer.take(now_ns)
        if announcement is not None:
            for port in self.ports:
                port.say(announcement.severity, announcement.text)
        if now_ns >= self._next_heartbeat_ns:
            self._next_heartbeat_ns = max(self._next_heartbeat_ns + HEARTBEAT_NS, now_ns + HEARTBEAT_NS // 2)
            self._send_heartbeats()

    @property
    def next_deadline_ns(self) -> int:
        """When ``poll`` is due at the latest; a time in the past is at once."""
        text_ns = self.announcer.next_deadline_ns
        due_ns = self._next_heartbeat_ns if text_ns is None else min(text_ns, self._next_heartbeat_ns)
        time_ns = None if self.discovery.vehicle is None else self.timesync.next_deadline_ns
        if time_ns is not None:
            due_ns = min(due_ns, time_ns)
        silence_ns = self.discovery.next_deadline_ns
        if silence_ns is None:
            return due_ns
        data_ns = self.data.next_deadline_ns
        return min(due_ns, silence_ns) if data_ns is None else min(due_ns, silence_ns, data_ns)

    def stop(self) -> None:
        """Set the rates back where configured, and send a last heartbeat with POWEROFF on every link."""
        vehicle = self.discovery.vehicle
        if vehicle is not None and self._settings.data.restores:
            port = self.ports[vehicle.link]
            for message_id in self.data.stream_manager.asked:
                port.put(port.encoder.set_message_interval(vehicle.system, vehicle.component, message_id, 0))
        for port in self.ports:
            port.heartbeat(MAV_STATE_POWEROFF)

    @property
    def _publication(self) -> Publication | None:
        """The estimate and verdict to be sent now; None while there is no valid estimate."""
        return None if self._estimate is None else Publication(self._estimate, self._verdict, self._confidence)

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

    def _hear_command(self, link: int, frame: Frame, now_ns: int) -> bool:
        command = self._commands.read(frame)
        system, component = command.target_system, command.target_component
        if (system == 0 and component == 0) or (
            system == self._system and (component == 0 or component == self._settings.component)  # noqa: PLR1714
        ):
            answer(command, self.ports[link], self._publication, self.state)
        elif command.number == MAV_CMD_SET_MESSAGE_INTERVAL:
            self.data.stream_manager.overheard(f"system {frame.system}", now_ns)
        return False

    def _hear_ack(self, link: int, frame: Frame, now_ns: int) -> bool:
        """The vehicle's answer to our command; MAVLink 1 and some autopilots leave the targets zero."""
        if not self._is_from_vehicle(link, frame):
            return False
        command, result, system, component = self._ack.unpack(frame.payload)
        meant = (system == 0 or system == self._system) and (component == 0 or component == self._settings.component)  # noqa: PLR1714
        if meant and command == MAV_CMD_SET_MESSAGE_INTERVAL:
            self.data.stream_manager.acknowledged(result, now_ns)
        return False

    def _hear_stream_request(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Another component requests streams from the vehicle."""
        if self.discovery.vehicle is not None and not self._is_from_vehicle(link, frame):
            self.data.stream_manager.overheard(f"system {frame.system}", now_ns)
        return False

    def _hear_timesync(self, link: int, frame: Frame, now_ns: int) -> bool:
        """A question for our time, or the vehicle's answer to ours."""
        question = self.timesync.question(frame)
        if question is None:
            if self._is_from_vehicle(link, frame):
                self.timesync.answered(frame, now_ns)
        elif question.is_for(self._system, self._settings.component):
            self.ports[link].tell_time(question, frame, now_ns)
        return False

    def _is_from_vehicle(self, link: int, frame: Frame) -> bool:
        """Whether the frame comes from the vehicle's autopilot, on the link on which it was taken up."""
        vehicle = self.discovery.vehicle
        if vehicle is None or link != vehicle.link:
            return False
        return frame.system == vehicle.system and frame.component == vehicle.component

    def _forget(self) -> None:
        """Drop everything about the vehicle: there is none, or none any more because there are several."""
        if self.sender != NOBODY:
            self.sender = NOBODY
            self.withdraw()
            self.data.forget()
            self.timesync.forget()

    def _found(self, vehicle: Vehicle, now_ns: int) -> None:
        """Take the system id of a vehicle that was found, for the first time or again, and request its messages."""
        sender = (vehicle.system, vehicle.component, vehicle.autopilot)
        if sender != self.sender:
            self._forget()
            self.sender = sender
        self._system = self._settings.system or vehicle.system
        for port in self.ports:
            port.rename(self._system)
        self.data.vehicle_found(vehicle.autopilot, vehicle.vehicle_type, now_ns)
        self.timesync.begin(now_ns)

    def _send_heartbeats(self) -> None:
        """One heartbeat a link, and the outputs beside it."""
        publication = self._publication
        for port in self.ports:
            port.heartbeat(self.state)
            if publication is not None:
                port.publish_beside_heartbeat(publication)
