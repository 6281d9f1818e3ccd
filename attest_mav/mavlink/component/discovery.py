"""Finds the vehicle: the one system whose HEARTBEAT names an autopilot and a type that can move.

Cameras, gimbals and ground stations send heartbeats too. Most have MAV_AUTOPILOT_INVALID; those with a generic
autopilot are recognised by their MAV_TYPE. The autopilot is component 1 of its system. Another component that claims
to be the autopilot is accepted only while no component 1 is heard, and is replaced by component 1 on any link, unless
it has brought samples and goes on to be heard.

A vehicle that was found is kept: it may fall silent, reboot, or return on another link. While several vehicles are
heard from the start, none is chosen.
"""

from typing import Final

from attest_mav.mavlink.component.no_vehicles import NO_VEHICLES
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID, MAV_COMP_ID_AUTOPILOT1, MAV_TYPE_GCS

AMBIGUITY_NS: Final = 3_000_000_000
"""A second vehicle that is heard within this time after the first leaves the choice to chance, so none is chosen. A
later one is only reported. Heartbeats come once a second, so three of them fit."""
GRACE_NS: Final = 3_000_000_000
"""How long component 1 is awaited once another component claims to be the autopilot."""
SILENCE_NS: Final = 3_500_000_000
"""After three missed heartbeats the vehicle is silent, and may be taken up on another link."""
REMINDER_NS: Final = 60_000_000_000
"""Pause between two notes that several vehicles are heard."""


class Vehicle:
    """A vehicle. ``link``: number of the link on which it was last taken up."""

    def __init__(self, system: int, component: int, autopilot: int, vehicle_type: int, link: int) -> None:
        self.system: Final = system
        self.component: Final = component
        self.autopilot: Final = autopilot
        self.vehicle_type: Final = vehicle_type
        self.link: Final = link


class _Claim:
    """A system that may be the vehicle."""

    def __init__(self, now_ns: int) -> None:
        self.began_ns: Final = now_ns
        """First heartbeat since the system was last silent."""
        self.heard_ns = now_ns
        """Latest heartbeat."""
        self.autopilot_ns = now_ns - SILENCE_NS
        """Latest heartbeat of its component 1."""


class VehicleDiscovery:
    """Finds the vehicle in the heartbeats of all links. ``wanted_system``: the only one to take, 0 for any."""

    def __init__(self, wanted_system: int, notebook: Notebook) -> None:
        self.vehicle: Vehicle | None = None
        self.present = False
        """Whether the vehicle's heartbeats arrive, on a link that has not broken since."""
        self.ambiguity = ""
        """Why no vehicle is chosen although there are some; empty otherwise."""
        self.brings_samples = False
        """Whether the vehicle has proven to be one; set by the companion."""
        self._heard_on: Final[dict[int, int]] = {}
        self._wanted_system: Final = wanted_system
        self._notebook: Final = notebook
        self._claims: Final[dict[int, _Claim]] = {}
        self._found_ns = 0
        self._heard_ns = 0
        self._next_reminder_ns = 0
        self._reported: list[int] = []
        self._is_component_reported = False

    def heartbeat(self, link: int, system: int, component: int, vehicle_type: int, autopilot: int, now_ns: int) -> bool:
        """Take one heartbeat; True when it made the vehicle known, for the first time or again."""
        if not self._may_fly(system, component, vehicle_type, autopilot):
            return False
        if self._wanted_system not in {0, system}:
            self._report_other(system)
            return False
        claim = self._claim(system, component, now_ns)
        heard = Vehicle(system, component, autopilot, vehicle_type, link)
        known = self.vehicle
        if known is None:
            return self._choose(heard, claim, now_ns)
        if system == known.system:
            return self._follow(known, heard, now_ns)
        if self.settled(now_ns) or system not in self._rivals(now_ns):
            self._report_other(system)
            return False
        self.vehicle = None
        self.present = False
        self.brings_samples = False
        return self._choose(heard, claim, now_ns)

    def settled(self, now_ns: int) -> bool:
        """Whether the choice stands, whichever other vehicle is heard."""
        return self.vehicle is not None and now_ns - self._found_ns >= AMBIGUITY_NS

    def move(self, link: int) -> None:
        """Request the vehicle's data on this link from now on."""
        known = self.vehicle
        if known is not None and known.link != link:
            self.vehicle = Vehicle(known.system, known.component, known.autopilot, known.vehicle_type, link)
            self.present = link in self._heard_on
            self._heard_ns = self._heard_on.get(link, self._heard_ns)

    def other_link(self, now_ns: int) -> int:
        """The next link on which the vehicle's heartbeats come too, -1 where there is none."""
        known = self.vehicle
        if known is None:
            return -1
        heard = sorted(one for one, heard_ns in self._heard_on.items() if now_ns - heard_ns < SILENCE_NS)
        others = [one for one in heard if one > known.link] + [one for one in heard if one < known.link]
        return others[0] if others else -1

    def link_broken(self, link: int) -> None:
        """The link ended or began anew: a fresh heartbeat is needed before anything is requested."""
        self._heard_on.pop(link, None)
        if self.vehicle is not None and self.vehicle.link == link:
            self.present = False

    def poll(self, now_ns: int) -> None:
        """Notice that the heartbeats have stopped."""
        if self.present and now_ns - self._heard_ns >= SILENCE_NS and self.vehicle is not None:
            self.present = False
            self._notebook.warning(f"vehicle lost: no heartbeat of system {self.vehicle.system} for 3 s")
        if self.ambiguity and not self._rivals(now_ns):
            self.ambiguity = ""

    @property
    def next_deadline_ns(self) -> int | None:
        """When silence is to be noticed; None while no heartbeat is expected."""
        return self._heard_ns + SILENCE_NS if self.present else None

    def _may_fly(self, system: int, component: int, vehicle_type: int, autopilot: int) -> bool:
        """Whether this heartbeat can be a vehicle's. The configured system may have any MAV_TYPE but GCS."""
        if autopilot == MAV_AUTOPILOT_INVALID or vehicle_type == MAV_TYPE_GCS:
            return False
        named = system == self._wanted_system and component == MAV_COMP_ID_AUTOPILOT1
        return named or vehicle_type not in NO_VEHICLES

    def _claim(self, system: int, component: int, now_ns: int) -> _Claim:
        """The system's claim, brought up to date."""
        claim = self._claims.get(system)
        if claim is None or now_ns - claim.heard_ns >= SILENCE_NS:
            claim = _Claim(now_ns)
            self._claims[system] = claim
        claim.heard_ns = now_ns
        if component == MAV_COMP_ID_AUTOPILOT1:
            claim.autopilot_ns = now_ns
        return claim

    def _rivals(self, now_ns: int) -> list[int]:
        """The systems that are heard and may be the vehicle: those with a component 1 if there are any, else all."""
        claims = self._claims
        heard = sorted(system for system in claims if now_ns - claims[system].heard_ns < SILENCE_NS)
        return [system for system in heard if now_ns - claims[system].autopilot_ns < SILENCE_NS] or heard

    def _choose(self, heard: Vehicle, claim: _Claim, now_ns: int) -> bool:
        """Take the vehicle if it is the only one, and its component 1 is heard or was awaited long enough."""
        rivals = self._rivals(now_ns)
        if len(rivals) > 1:
            self._report_several(rivals, now_ns)
            return False
        self.ambiguity = ""
        self._next_reminder_ns = 0
        if heard.system not in rivals:
            return False
        if heard.component != MAV_COMP_ID_AUTOPILOT1 and now_ns - max(claim.began_ns, claim.autopilot_ns) < GRACE_NS:
            return False
        self._found_ns = now_ns
        self._take(heard, "found", now_ns)
        return True

    def _follow(self, known: Vehicle, heard: Vehicle, now_ns: int) -> bool:
        """Take a heartbeat of the vehicle's system: the known component's, or component 1's; others are ignored.

        Another link is taken only when the known one is silent.
        """
        if heard.component == known.component:
            self._heard_on[heard.link] = now_ns
            if self.present and heard.link == known.link:
                self._heard_ns = now_ns
            if self.present:
                return False
        elif heard.component != MAV_COMP_ID_AUTOPILOT1:
            return False
        elif self.present and self.brings_samples:
            self._report_component(known)
            return False
        self._take(heard, "found again" if heard.component == known.component else "found", now_ns)
        return True

    def _take(self, vehicle: Vehicle, found: str, now_ns: int) -> None:
        self._notebook.info(f"vehicle {found}: system {vehicle.system}, component {vehicle.component}")
        if self.vehicle is None or vehicle.component != self.vehicle.component:
            self.brings_samples = False
            self._heard_on.clear()
        self._heard_on[vehicle.link] = now_ns
        self.vehicle = vehicle
        self.present = True
        self._heard_ns = now_ns

    def _report_component(self, known: Vehicle) -> None:
        """Report once that component 1 claims to be the autopilot beside the one that is used."""
        if self._is_component_reported:
            return
        self._is_component_reported = True
        self._notebook.warning(
            f"component 1 of system {known.system} is an autopilot too; component {known.component} is kept, "
            "since it brings samples"
        )

    def _report_several(self, rivals: list[int], now_ns: int) -> None:
        """Several vehicles: leave a note, and repeat it after a pause."""
        names = f"{', '.join(map(str, rivals[:-1]))} and {rivals[-1]}"
        self.ambiguity = f"several vehicles, systems {names}: name one with system_id under [vehicle]"
        if now_ns >= self._next_reminder_ns:
            self._next_reminder_ns = now_ns + REMINDER_NS
            self._notebook.error(f"{self.ambiguity} in the configuration; nothing is sent until one is left")

    def _report_other(self, system: int) -> None:
        """Report another vehicle, once."""
        if system in self._reported:
            return
        self._reported.append(system)
        kept = self._wanted_system if self.vehicle is None else self.vehicle.system
        self._notebook.warning(f"another vehicle, system {system}, is on the links; only system {kept} is used")
