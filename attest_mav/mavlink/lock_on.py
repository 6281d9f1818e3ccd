"""Which vehicle this is about: the one system whose HEARTBEAT names an autopilot.

Cameras, gimbals and ground stations have heartbeats too, but theirs say MAV_AUTOPILOT_INVALID. Once found, a vehicle
is kept for good: it may fall silent, reboot, or come back on another link, and is the same vehicle still.
"""

from typing import Final

from attest_mav.errors import ConfigError
from attest_mav.mavlink.notes import Notebook

AUTOPILOT_INVALID: Final = 8
"""MAV_AUTOPILOT_INVALID: not an autopilot."""
TYPE_GCS: Final = 6
"""MAV_TYPE_GCS: some ground stations claim a generic autopilot."""
AUTOPILOT_COMPONENT: Final = 1
"""MAV_COMP_ID_AUTOPILOT1: preferred when several components of one system claim to fly it."""

AMBIGUITY_NS: Final = 3_000_000_000
"""A second vehicle that shows up this soon after the first makes the choice a matter of chance: an error. Later, in
flight perhaps, it is only reported. Heartbeats come once a second, so three of them fit."""
SILENCE_NS: Final = 3_500_000_000
"""Three heartbeats missed: the vehicle is silent, and may be taken up on another link."""


class Vehicle:
    """The vehicle that was found. ``link``: number of the link it was last taken up on."""

    def __init__(self, system: int, component: int, autopilot: int, vehicle_type: int, link: int) -> None:
        self.system: Final = system
        self.component: Final = component
        self.autopilot: Final = autopilot
        self.vehicle_type: Final = vehicle_type
        self.link: Final = link


class LockOn:
    """Finds the vehicle in the heartbeats of all links. ``wanted_system``: the only one to take, 0 for any."""

    def __init__(self, wanted_system: int, notebook: Notebook) -> None:
        self.vehicle: Vehicle | None = None
        self.present = False
        """Whether the vehicle's heartbeats arrive, on a stream that has not broken since."""
        self._wanted_system: Final = wanted_system
        self._notebook: Final = notebook
        self._found_ns = 0
        self._heard_ns = 0
        self._others: list[int] = []

    def heartbeat(self, link: int, system: int, component: int, vehicle_type: int, autopilot: int, now_ns: int) -> bool:
        """Take one heartbeat; True when the vehicle was found by it, or found again.

        ConfigError when there are several vehicles and nothing says which one is meant.
        """
        if autopilot == AUTOPILOT_INVALID or vehicle_type == TYPE_GCS:
            return False
        if self._wanted_system not in {0, system}:
            self._other(system)
            return False
        known = self.vehicle
        if known is None:
            self._found_ns = now_ns
        elif system != known.system:
            if now_ns - self._found_ns < AMBIGUITY_NS:
                raise ConfigError(
                    f"two vehicles on the links, systems {known.system} and {system}: "
                    "name one with system_id under [vehicle] in the configuration"
                )
            self._other(system)
            return False
        elif self.present and (link != known.link or component != known.component):
            if component != AUTOPILOT_COMPONENT or link != known.link:
                return False
        elif self.present:
            self._heard_ns = now_ns
            return False
        self._take(Vehicle(system, component, autopilot, vehicle_type, link), now_ns)
        return True

    def _take(self, vehicle: Vehicle, now_ns: int) -> None:
        found = "found" if self.vehicle is None else "found again"
        self._notebook.info(f"vehicle {found}: system {vehicle.system}, component {vehicle.component}")
        self.vehicle = vehicle
        self.present = True
        self._heard_ns = now_ns

    def link_broken(self, link: int) -> None:
        """The stream of this link ended or began anew: a fresh heartbeat is needed before anything is asked for."""
        if self.vehicle is not None and self.vehicle.link == link:
            self.present = False

    def poll(self, now_ns: int) -> None:
        """Notice that the heartbeats have stopped."""
        if self.present and now_ns - self._heard_ns >= SILENCE_NS and self.vehicle is not None:
            self.present = False
            self._notebook.warning(f"vehicle lost: no heartbeat of system {self.vehicle.system} for 3 s")

    @property
    def next_deadline_ns(self) -> int | None:
        """When silence is to be noticed; None while there is nothing to miss."""
        return self._heard_ns + SILENCE_NS if self.present else None

    def _other(self, system: int) -> None:
        """Report another vehicle, once."""
        if system in self._others:
            return
        self._others.append(system)
        kept = self._wanted_system if self.vehicle is None else self.vehicle.system
        self._notebook.warning(f"another vehicle, system {system}, is on the links; only system {kept} is used")
