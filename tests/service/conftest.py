"""The daemon's work on virtual time: a service and a fake autopilot that exchange bytes, and pymavlink listening."""

from collections.abc import Callable
from math import degrees, radians
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.algebra import heading_between, tilt_between
from attest_mav.config.parsing import parse_config
from attest_mav.config.records import Config
from attest_mav.mavlink.component.notes import Note
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.service.assembly import service_settings
from attest_mav.service.service import Service
from attest_mav.service.snapshot import Snapshot
from attest_mav.service.status import status_line
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings
from attest_mav.types import EarthField

SECOND = 1_000_000_000

FIELD = EarthField(radians(12.69), radians(-66.05))
"""What the simulator models."""
"""Where the fake autopilot flies; a constant here, so that no model is loaded."""


@pytest.fixture(scope="session")
def dialect() -> Dialect:
    return load_dialect()


def message_id(frame: bytes) -> int:
    """The message id of a frame of MAVLink 2."""
    return int.from_bytes(frame[7:10], "little")


class Flight:
    """One vehicle and one service; ``heard`` is what the service sent, with the time it was sent, on its first link."""

    def __init__(
        self,
        dialect: Dialect,
        config: Config,
        settings: SimSettings,
        chunk: int = 0,
        keys: dict[str, bytes] | None = None,
    ) -> None:
        self.now_ns = 0
        self.vehicle = FakeAutopilot(settings, 1, dialect)
        names = [link.url for link in config.link]
        self.service = Service(service_settings(config, keys), names, dialect, lambda *_: (FIELD, "a test"), 0)
        self.heard: list[tuple[float, Any]] = []
        self.raw: list[bytes] = []
        self.deaf_to: set[int] = set()
        """Ids of messages that do not reach the service."""
        self.notes: list[Note] = []
        """The lines for the log, as the daemon writes them."""
        self._chunk = chunk
        self._shown = self.service.snapshot(0)
        self._parser = mavlink.MAVLink(None)

    def run_until(self, t_s: float) -> None:
        end_ns = round(t_s * SECOND)
        while self.now_ns < end_ns:
            due_ns = min(self.vehicle.next_deadline_ns, self.service.due_ns)
            self.now_ns = min(max(due_ns, self.now_ns + 100_000), end_ns)
            data = b"".join(
                one for one in self.vehicle.frames_until(self.now_ns) if message_id(one) not in self.deaf_to
            )
            for begin in range(0, len(data), self._chunk or len(data) or 1):
                self.service.receive(0, data[begin : begin + (self._chunk or len(data))], self.now_ns)
            self._exchange()
            if self.service.due_ns <= self.now_ns:  # as the daemon does
                self.service.poll(self.now_ns)
                self._exchange()

    def stop(self) -> None:
        self.service.stop()
        self._exchange()

    @property
    def texts(self) -> list[str]:
        """The notes' texts."""
        return [note.text for note in self.notes]

    def snapshot(self) -> Snapshot:
        return self.service.snapshot(self.now_ns)

    def status(self) -> str:
        """The status line, with the rates since the last one."""
        before, self._shown = self._shown, self.snapshot()
        return status_line(self._shown, before)

    def _exchange(self) -> None:
        self.notes += self.service.take_notes()
        for frame in self.service.take_frames(0):
            self.vehicle.handle(frame, self.now_ns)
            self.raw.append(frame)
            self.heard += [(self.now_ns / SECOND, one) for one in self._parser.parse_buffer(frame) or []]

    def of_type(self, name: str, begin_s: float = 0.0, end_s: float = 1e9) -> list[Any]:
        return [one for t_s, one in self.heard if one.get_type() == name and begin_s <= t_s < end_s]

    def states(self) -> list[int]:
        """MAV_STATE of the heartbeats, without repeats."""
        states: list[int] = []
        for beat in self.of_type("HEARTBEAT"):
            if not states or states[-1] != beat.system_status:
                states.append(beat.system_status)
        return states

    def errors_deg(self, begin_s: float) -> tuple[float, float]:
        """Largest tilt and heading error of what was sent since then, against the truth at the time it carries."""
        tilts, headings = [0.0], [0.0]
        for message in self.of_type("ATTITUDE_QUATERNION", begin_s):
            truth = self.vehicle.truth(message.time_boot_ms * 1_000_000 + self.vehicle.boot_ns).q_nb
            ours = (message.q1, message.q2, message.q3, message.q4)
            tilts.append(degrees(tilt_between(truth, ours)))
            headings.append(abs(degrees(heading_between(truth, ours))))
        return max(tilts), max(headings)


@pytest.fixture
def flight(dialect: Dialect) -> Callable[..., Flight]:
    """Makes a flight; ``toml`` is appended to a configuration with one link."""

    def make(
        toml: str = "", settings: SimSettings | None = None, chunk: int = 0, keys: dict[str, bytes] | None = None
    ) -> Flight:
        config = parse_config(f"[[link]]\nurl = 'udpin::0'\n{toml}", "test")
        return Flight(dialect, config, settings or SimSettings(scenario="still", fast_rate_hz=50.0), chunk, keys)

    return make
