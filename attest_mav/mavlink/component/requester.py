"""Sends the requests for the vehicle's data, on the link that brings its samples.

While no link brings samples, the links on which its heartbeats come are tried in turn. Nothing is requested while the
vehicle is away.
"""

from typing import Final

from attest_mav.mavlink.component.discovery import VehicleDiscovery
from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.component.vehicle_data import VehicleData
from attest_mav.mavlink.component.vehicle_traffic import VehicleTraffic

UNHEARD: Final = 3
"""So many requests in a row without any answer, while messages arrive, show that none is heard."""


class Requester:
    """The requests of one companion. version_id: the id of AUTOPILOT_VERSION."""

    def __init__(
        self,
        data: VehicleData,
        discovery: VehicleDiscovery,
        traffic: VehicleTraffic,
        ports: list[Port],
        version_id: int,
        notebook: Notebook,
    ) -> None:
        self._data: Final = data
        self._discovery: Final = discovery
        self._traffic: Final = traffic
        self._ports: Final = ports
        self._version_id: Final = version_id
        self._notebook: Final = notebook
        self._lines: Final = LineLimit()
        self._failed_rounds = 0

    def may_ask(self, now_ns: int) -> bool:
        """Whether the vehicle is there to answer."""
        return self._discovery.present and not self._traffic.is_away(now_ns)

    def poll(self, now_ns: int) -> None:
        """Send the requests that are due."""
        vehicle = self._discovery.vehicle
        if vehicle is None:
            return
        if not self.may_ask(now_ns):
            self._data.stream_manager.pause(now_ns)
            return
        self._try_other_link(now_ns)
        vehicle = self._discovery.vehicle
        if vehicle is None:
            return
        port = self._ports[vehicle.link]
        self._data.stream_manager.silent_ns = self._traffic.silent_ns(now_ns)
        for request in self._data.poll(now_ns):
            port.request(request, vehicle.system, vehicle.component)
        for name in self._data.autopilot_settings.poll(now_ns):
            port.put(port.encoder.param_request_read(vehicle.system, vehicle.component, name))
        if self._data.take_version_request():
            port.put(port.encoder.request_message(vehicle.system, vehicle.component, self._version_id))

    def remark(self, now_ns: int) -> str:
        """Why the vehicle does not do what is requested, "" where it answers or was not asked."""
        manager = self._data.stream_manager
        if manager.unanswered < UNHEARD or self._data.autopilot_settings.is_answered or not self.may_ask(now_ns):
            return ""
        vehicle = self._discovery.vehicle
        if self._traffic.is_signed and vehicle is not None and self._ports[vehicle.link].encoder.signer is None:
            return (
                "the vehicle signs its messages and answers no unsigned request: let it accept unsigned messages on "
                "this link, or give its key (signing and key_file of the link)"
            )
        return "the autopilot does not hear us: no request was answered; check the line towards it"

    def note_remark(self, now_ns: int) -> None:
        """Leave the remark as a warning, once a minute."""
        remark = self.remark(now_ns)
        if remark and self._lines.suffix("remark", now_ns) is not None:
            self._notebook.warning(remark)

    def samples_come(self, link: int, now_ns: int) -> None:
        """The primary inertial samples come on this link: request everything there."""
        vehicle = self._discovery.vehicle
        self._discovery.brings_samples = True
        if vehicle is None or vehicle.link == link:
            return
        self._move(link, f"samples come on {self._ports[link].name}: the vehicle is asked there", now_ns)

    def stop(self) -> None:
        """Set the rates back to the autopilot's defaults."""
        vehicle = self._discovery.vehicle
        if vehicle is not None:
            port = self._ports[vehicle.link]
            for message_id in self._data.stream_manager.asked:
                port.put(port.encoder.set_message_interval(vehicle.system, vehicle.component, message_id, 0))

    def _try_other_link(self, now_ns: int) -> None:
        """Go on to another link when every inertial message was tried on this one."""
        rounds = self._data.failed_rounds
        if rounds == self._failed_rounds:
            return
        self._failed_rounds = rounds
        other = self._discovery.other_link(now_ns)
        if rounds > 0 and other >= 0:
            self._move(other, f"no inertial message comes; trying {self._ports[other].name}", now_ns)

    def _move(self, link: int, text: str, now_ns: int) -> None:
        suffix = self._lines.suffix("move", now_ns)
        if suffix is not None:
            self._notebook.info(f"{text}{suffix}")
        self._discovery.move(link)
        self._data.begin_on_other_link(now_ns)
