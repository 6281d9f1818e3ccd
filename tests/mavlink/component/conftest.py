"""A companion on virtual time, and pymavlink as everybody else on its links."""

from collections import defaultdict
from collections.abc import Callable
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.companion import Companion
from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.types import North

SECOND = 1_000_000_000


@pytest.fixture(scope="session")
def dialect() -> Dialect:
    return load_dialect()


@pytest.fixture
def notebook() -> Notebook:
    return Notebook()


class Bench:
    """One companion, its clock, and what others say to it."""

    def __init__(self, dialect: Dialect, settings: CompanionSettings, links: list[PortSettings]) -> None:
        self.now_ns = 0
        self.dialect = dialect
        named = [(f"link{number}", link) for number, link in enumerate(links)]
        self.companion = Companion(dialect, settings, named, 0)
        self.sent: list[list[Any]] = [[] for _ in links]
        self.notes: list[str] = []
        self._sequences: defaultdict[tuple[int, int, int], int] = defaultdict(int)
        self._parsers = [mavlink.MAVLink(None) for _ in links]

    def hear(
        self, message: Any, system: int = 1, component: int = 1, link: int = 0, sequence: int | None = None
    ) -> bool:
        """A message arrives, by default with its sender's next sequence number; whether it was the vehicle's data."""
        sender = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
        sender.seq = self._sequences[system, component, link] if sequence is None else sequence
        self._sequences[system, component, link] = (sender.seq + 1) % 256
        (frame,) = Framer(self.dialect, None).feed(message.pack(sender), self.now_ns)
        taken = self.companion.handle(link, frame, self.now_ns)
        self._collect()
        return taken

    def vehicle_heartbeat(
        self, system: int = 1, component: int = 1, link: int = 0, autopilot: int = 3, vehicle_type: int = 2
    ) -> bool:
        return self.hear(heartbeat(vehicle_type, autopilot), system, component, link)

    def run_until(self, t_s: float, every: Callable[[], None] | None = None) -> None:
        """Advance the clock from deadline to deadline, as a loop does; ``every`` is called each 0.1 s."""
        end_ns = round(t_s * SECOND)
        while self.now_ns < end_ns:
            self.companion.poll(self.now_ns)
            self._collect()
            step_ns = 100_000_000 - self.now_ns % 100_000_000
            self.now_ns = min(max(self.companion.next_deadline_ns, self.now_ns + 1_000_000), self.now_ns + step_ns)
            if every is not None and self.now_ns % 100_000_000 == 0:
                every()
        self.companion.poll(self.now_ns)
        self._collect()

    def publish(self, estimate: Estimate) -> None:
        self.companion.publish(estimate)
        self._collect()

    def stop(self) -> None:
        self.companion.stop()
        self._collect()

    def of_type(self, name: str, link: int = 0) -> list[Any]:
        return [message for message in self.sent[link] if message.get_type() == name]

    def interval_requests(self, link: int = 0) -> list[tuple[int, int, int]]:
        """Message id, interval in us and confirmation of every SET_MESSAGE_INTERVAL sent."""
        return [
            (int(one.param1), int(one.param2), one.confirmation)
            for one in self.of_type("COMMAND_LONG", link)
            if one.command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
        ]

    def _collect(self) -> None:
        for number, port in enumerate(self.companion.ports):
            for frame in port.take():
                self.sent[number] += self._parsers[number].parse_buffer(frame) or []
        self.notes += [note.text for note in self.companion.notebook.take()]


def heartbeat(vehicle_type: int, autopilot: int) -> Any:
    return mavlink.MAVLink_heartbeat_message(vehicle_type, autopilot, 0, 0, 4, 3)


@pytest.fixture
def bench(dialect: Dialect) -> Callable[..., Bench]:
    """Makes a bench; settings and the links' settings can be given."""

    def make(settings: CompanionSettings | None = None, links: list[PortSettings] | None = None) -> Bench:
        return Bench(dialect, settings or CompanionSettings(), links or [PortSettings()])

    return make


@pytest.fixture
def estimate() -> Callable[..., Estimate]:
    """Makes an estimate; level and north by default."""

    def make(
        t_s: float = 100.0,
        q_nb: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0),
        rates: tuple[float, float, float] = (0.1, 0.2, 0.3),
        sigma: float = float("nan"),
    ) -> Estimate:
        t_ns = round(t_s * SECOND)
        return Estimate("RAW_IMU", "any", t_ns, t_ns, q_nb, rates, North.TRUE, sigma, sigma, 0.02)

    return make
