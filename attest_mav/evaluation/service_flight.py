"""A vehicle and the whole service that exchange frames on virtual time, over a line that may disturb them."""

from collections.abc import Iterable
from heapq import heappop, heappush
from math import radians
from typing import Final, Protocol

from attest_mav.config.records import Config
from attest_mav.mavlink.dialect import Dialect
from attest_mav.service.assembly import service_settings
from attest_mav.service.service import Service
from attest_mav.service.tape import Tape
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.types import EarthField

STEP_NS: Final = 100_000
"""Time advances by at least this much, so that a deadline in the past stops nothing, ns."""


class Line(Protocol):
    """The way between the two."""

    def deliver(self, now_ns: int, frames: list[bytes]) -> Iterable[tuple[int, bytes]]:
        """Times of arrival, ns, and bytes, for the frames that the vehicle sends now."""

    def passes(self, now_ns: int, frame: bytes) -> bool:
        """Whether a frame of the service reaches the vehicle."""


class PlainLine:
    """Delivers everything at once."""

    def deliver(self, now_ns: int, frames: list[bytes]) -> Iterable[tuple[int, bytes]]:
        """See ``Line``."""
        return [(now_ns, frame) for frame in frames]

    def passes(self, now_ns: int, frame: bytes) -> bool:
        """See ``Line``."""
        return True


class ServiceFlight:
    """One flight; the caller advances it and looks at what it likes."""

    def __init__(
        self, vehicle: FakeAutopilot, config: Config, dialect: Dialect, line: Line, tape: Tape | None = None
    ) -> None:
        earth = vehicle.settings.earth
        field = EarthField(radians(earth.declination_deg), radians(earth.inclination_deg))
        self.vehicle: Final = vehicle
        self.service: Final = Service(
            service_settings(config), ["link"], dialect, lambda *_: (field, "the simulator's"), 0, tape
        )
        self.now_ns = 0
        self._line: Final = line
        self._on_the_way: Final[list[tuple[int, int, bytes]]] = []
        self._delivered = 0

    def advance(self, latest_ns: int) -> list[bytes]:
        """Go on to the next deadline, or to ``latest_ns`` where that is earlier; what the service sent."""
        arrival_ns = self._on_the_way[0][0] if self._on_the_way else latest_ns
        due_ns = min(self.vehicle.next_deadline_ns, self.service.due_ns, arrival_ns, latest_ns)
        now_ns = self.now_ns = max(due_ns, self.now_ns + STEP_NS)
        for arrival_ns, data in self._line.deliver(now_ns, self.vehicle.frames_until(now_ns)):
            self._delivered += 1
            heappush(self._on_the_way, (arrival_ns, self._delivered, data))
        for data in self._arrived(now_ns):
            self.take(data)
        if self.service.due_ns <= now_ns:
            self.service.poll(now_ns)
        sent = self.service.take_frames(0)
        for frame in sent:
            if self._line.passes(now_ns, frame):
                self.vehicle.handle(frame, now_ns)
        return sent

    def take(self, data: bytes) -> None:
        """Bytes arrive at the service."""
        self.service.receive(0, data, self.now_ns)

    def _arrived(self, now_ns: int) -> Iterable[bytes]:
        while self._on_the_way and self._on_the_way[0][0] <= now_ns:
            yield heappop(self._on_the_way)[2]
