"""A MAVLink companion component without I/O: frames and ``now_ns`` in, frames to send and deadlines out.

The companion finds the vehicle, takes its system id, sends the heartbeat, requests streams and measures them, answers
commands, and publishes estimates. Every link has a ``Port``: the caller writes the frames of ``ports[i].take()`` to
link i, and logs the notes of ``notebook.take()``.
"""

from collections.abc import Callable
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.announcer import Announcer
from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.commands import CommandDesk, CommandReader
from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.discovery import Vehicle, VehicleDiscovery
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.outgoing import Outgoing
from attest_mav.mavlink.component.outputs import Confidence
from attest_mav.mavlink.component.own_ids import OwnIds
from attest_mav.mavlink.component.own_parameters import OwnParameters
from attest_mav.mavlink.component.parameter_desk import ParameterDesk
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.component.requester import Requester
from attest_mav.mavlink.component.timesync import TimeSync
from attest_mav.mavlink.component.vehicle_data import VehicleData
from attest_mav.mavlink.component.vehicle_traffic import VehicleTraffic
from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_INVALID,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_MODE_FLAG_SAFETY_ARMED,
    MAV_STATE_BOOT,
    MAV_STATE_POWEROFF,
    MAV_TYPE_GCS,
    MAV_TYPE_ONBOARD_CONTROLLER,
)
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.framer import Frame
from attest_mav.vehicle_reports import ParameterSample

UNKNOWN_SYSTEM: Final = 1
"""Our system id before a vehicle is found: the one that autopilots are delivered with."""

NOBODY: Final = (0, 0, MAV_AUTOPILOT_INVALID)
"""The sender while there is no vehicle."""

Handler = Callable[[int, Frame, int], bool]
"""Takes the number of a link, a frame from it and now_ns; True when the frame is the vehicle's data, to be decoded."""


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
        self.own_parameters: Final = OwnParameters(settings.parameters, self.notebook)
        """The parameters that ground stations may read and set."""
        self._parameter_desk: Final = ParameterDesk(dialect, self.ports, self.own_parameters)
        self.handlers: Final[dict[int, Handler]] = {
            **self._parameter_desk.handlers,
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
        self._heartbeat: Final = dialect.layout("HEARTBEAT").pick("type", "autopilot", "base_mode")
        self._ack: Final = dialect.layout("COMMAND_ACK").pick("command", "result", "target_system", "target_component")
        self._commands: Final = CommandReader(dialect)
        self._desks: Final = [CommandDesk(port, self.notebook) for port in self.ports]
        self.traffic: Final = VehicleTraffic(dialect, [name for name, _ in links], self.notebook)
        """The frames with the vehicle's ids on all links."""
        self._requester: Final = Requester(
            self.data, self.discovery, self.traffic, self.ports, dialect.id_of("AUTOPILOT_VERSION"), self.notebook
        )
        self._outgoing: Final = Outgoing(self.ports, now_ns)
        self._away = True

    def handle(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Take one frame from a link; True when it is the vehicle's data and worth decoding."""
        if frame.system == self._system and frame.component == self._settings.component:
            self.own_ids.heard(link, frame, now_ns)
            return False
        handler = self.handlers.get(frame.message_id)
        if handler is not None:
            return handler(link, frame, now_ns)
        if not (self._is_from_vehicle(frame) and self.traffic.take(link, frame, now_ns)):
            return False
        return self.data.arrived(frame.message_id)

    @property
    def wanted(self) -> frozenset[int]:
        """Ids of the messages that ``handle`` understands or passes on, for the framers."""
        return self.data.wanted | frozenset(self.handlers)

    def imu_taken(self, source: str, t_ns: int, now_ns: int) -> bool:
        """Take note of a decoded inertial sample from this source, of this time; True when it is in use."""
        is_used = self.data.imu_taken(source, now_ns)
        if is_used and source == self.data.primary_imu:
            self.traffic.identity.clock(t_ns, now_ns)
            self._requester.samples_come(self.traffic.link, now_ns)
        return is_used

    def parameter_taken(self, sample: ParameterSample) -> bool:
        """Take note of a decoded parameter of the vehicle; True when its value counts."""
        return self.data.parameter_taken(sample)

    def publish(self, estimate: Estimate, confidence: Confidence = Confidence.BELIEVED) -> None:
        """Send the newest estimate on every link where it is due, and keep it for requests.

        confidence: outputs that need a higher one are not sent.
        """
        self._outgoing.publish(estimate, confidence)

    def withdraw(self) -> None:
        """Drop the estimate: it is not valid any more."""
        self._outgoing.withdraw()

    def set_verdict(self, ok: float, tilt: float, heading: float) -> None:
        """Take the verdict: ok is 1 (agrees), 0 (disagrees), -1 (undecided); differences in rad, NaN where unknown."""
        self._outgoing.set_verdict(ok, tilt, heading)

    def remarks(self, now_ns: int) -> list[str]:
        """What is wrong on the links, for the status."""
        remarks = self.traffic.remarks(self._system, now_ns) + self.own_ids.remarks(now_ns)
        remarks += [*self.data.autopilot_settings.doubts.values()]
        remarks += [self._requester.remark(now_ns), self.data.stream_manager.loss.text]
        return [remark for remark in remarks if remark]

    def link_broken(self, link: int) -> None:
        """The stream of this link ended, or began anew."""
        self.discovery.link_broken(link)
        self.traffic.link_broken(link)

    def ask_again(self, now_ns: int) -> None:
        """Request everything again: the autopilot has rebooted and lost the requests."""
        self.data.begin(now_ns)
        self.timesync.begin(now_ns)

    def poll(self, now_ns: int) -> None:
        """Send the requests, heartbeats and notes that are due."""
        self.discovery.poll(now_ns)
        for port in self.ports:
            port.poll(now_ns)
        self._parameter_desk.poll(now_ns)
        self._away = not self._requester.may_ask(now_ns)
        self._requester.poll(now_ns)
        self._requester.note_remark(now_ns)
        self.traffic.note_remarks(self._system, now_ns)
        vehicle = self.discovery.vehicle
        if vehicle is not None and self.timesync.poll(now_ns):
            port = self.ports[vehicle.link]
            port.put(port.encoder.timesync(0, now_ns, vehicle.system, vehicle.component))
        announcement = self.announcer.take(now_ns)
        if announcement is not None:
            for port in self.ports:
                port.say(announcement.severity, announcement.text)
        self._outgoing.beat(self.state, now_ns)

    @property
    def next_deadline_ns(self) -> int:
        """When ``poll`` is due at the latest; a time in the past is at once."""
        text_ns = self.announcer.next_deadline_ns
        beat_ns = self._outgoing.due_ns
        due_ns = beat_ns if text_ns is None else min(text_ns, beat_ns)
        list_ns = self._parameter_desk.next_deadline_ns
        if list_ns is not None:
            due_ns = min(due_ns, list_ns)
        time_ns = None if self.discovery.vehicle is None else self.timesync.next_deadline_ns
        if time_ns is not None:
            due_ns = min(due_ns, time_ns)
        silence_ns = self.discovery.next_deadline_ns
        if silence_ns is None:
            return due_ns
        if self._away:
            return min(due_ns, silence_ns)
        data_ns = self.data.next_deadline_ns
        return min(due_ns, silence_ns) if data_ns is None else min(due_ns, silence_ns, data_ns)

    def stop(self) -> None:
        """Set the rates back where configured, and send a last heartbeat with POWEROFF on every link."""
        if self._settings.data.restores:
            self._requester.stop()
        for port in self.ports:
            port.heartbeat(MAV_STATE_POWEROFF)

    def _hear_heartbeat(self, link: int, frame: Frame, now_ns: int) -> bool:
        vehicle_type, autopilot, base_mode = self._heartbeat.unpack(frame.payload)
        found = self.discovery.heartbeat(link, frame.system, frame.component, vehicle_type, autopilot, now_ns)
        vehicle = self.discovery.vehicle
        if vehicle is None:
            self._forget()
        elif found:
            self._found(vehicle, now_ns)
        is_vehicle = self._is_from_vehicle(frame)
        if is_vehicle:
            self.own_parameters.is_armed = bool(base_mode & MAV_MODE_FLAG_SAFETY_ARMED)
        port = self.ports[link]
        port.station_heard(frame.system, frame.component, now_ns)
        if vehicle_type == MAV_TYPE_ONBOARD_CONTROLLER and frame.system == self._system and not is_vehicle:
            port.onboard_heard(frame.component, now_ns)
        elif vehicle_type == MAV_TYPE_GCS and vehicle is not None and vehicle.link == link:
            port.ground_station_heard(frame.component, now_ns)
        return is_vehicle and self.traffic.take(link, frame, now_ns)

    def _hear_command(self, link: int, frame: Frame, now_ns: int) -> bool:
        command = self._commands.read(frame)
        system, component = command.target_system, command.target_component
        if (system == 0 and component == 0) or (
            system == self._system and (component == 0 or component == self._settings.component)  # noqa: PLR1714
        ):
            self.ports[link].station_heard(frame.system, frame.component, now_ns)
            self._desks[link].answer(command, self._outgoing.publication, self.state, now_ns)
        elif command.number == MAV_CMD_SET_MESSAGE_INTERVAL:
            self.data.stream_manager.overheard(f"system {frame.system}", now_ns)
        return False

    def _hear_ack(self, link: int, frame: Frame, now_ns: int) -> bool:
        """The vehicle's answer to our command; MAVLink 1 and some autopilots leave the targets zero."""
        if not self._is_from_vehicle(frame) or not self.traffic.take(link, frame, now_ns):
            return False
        command, result, system, component = self._ack.unpack(frame.payload)
        meant = (system == 0 or system == self._system) and (component == 0 or component == self._settings.component)  # noqa: PLR1714
        if meant and command == MAV_CMD_SET_MESSAGE_INTERVAL:
            self.data.stream_manager.acknowledged(result, now_ns)
        return False

    def _hear_stream_request(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Another component requests streams from the vehicle."""
        if self.discovery.vehicle is not None and not self._is_from_vehicle(frame):
            self.data.stream_manager.overheard(f"system {frame.system}", now_ns)
        return False

    def _hear_timesync(self, link: int, frame: Frame, now_ns: int) -> bool:
        """A question for our time, or the vehicle's answer to ours."""
        question = self.timesync.question(frame)
        if question is None:
            if self._is_from_vehicle(frame) and self.traffic.take(link, frame, now_ns):
                self.timesync.answered(frame, now_ns)
        elif question.is_for(self._system, self._settings.component):
            self.ports[link].tell_time(question, frame, now_ns)
        return False

    def _is_from_vehicle(self, frame: Frame) -> bool:
        """Whether the frame carries the ids of the vehicle's autopilot."""
        vehicle = self.discovery.vehicle
        return vehicle is not None and frame.system == vehicle.system and frame.component == vehicle.component

    def _forget(self) -> None:
        """Drop everything about the vehicle: there is none, or none any more because there are several."""
        if self.sender != NOBODY:
            self.sender = NOBODY
            self.withdraw()
            self.data.forget()
            self.timesync.forget()
            self.traffic.begin_anew()

    def _found(self, vehicle: Vehicle, now_ns: int) -> None:
        """Take the system id of a vehicle that was found, for the first time or again, and request its messages."""
        sender = (vehicle.system, vehicle.component, vehicle.autopilot)
        if sender != self.sender:
            self._forget()
            self.sender = sender
            self._outgoing.autopilot = vehicle.autopilot
        self._system = self._settings.system or vehicle.system
        for port in self.ports:
            port.rename(self._system)
        self.data.vehicle_found(vehicle.autopilot, vehicle.vehicle_type, now_ns)
        self.timesync.begin(now_ns)
