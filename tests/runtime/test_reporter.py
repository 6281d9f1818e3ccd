"""The status line: written when its words change, and seldom otherwise; systemd is told each time."""

import logging
from itertools import pairwise

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.runtime.notify import Notifier
from attest_mav.runtime.reporter import Reporter
from attest_mav.service.assembly import service_settings
from attest_mav.service.service import Service
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings
from attest_mav.types import EarthField

SECOND = 1_000_000_000


class Heard(Notifier):
    """What systemd would have been told."""

    def __init__(self):
        super().__init__({})
        self.states = []

    def status(self, text):
        self.states.append(text)


@pytest.fixture
def lines(caplog):
    """The times (s) of the status lines of 70 s: a vehicle is there from 10 s to 34 s."""
    caplog.set_level(logging.INFO, "attest_mav")
    dialect = load_dialect()
    vehicle = FakeAutopilot(SimSettings(scenario="still", fast_rate_hz=50.0), 1, dialect)
    config = parse_config("[[link]]\nurl = 'udpin::0'\n", "test")
    service = Service(service_settings(config), ["udpin::0"], dialect, lambda *_: (EarthField(0.2, -1.1), "x"), 0)
    heard = Heard()
    reporter = Reporter(service, heard, service.snapshot, 30.0, 0)
    times = []
    for now_ns in range(0, 70 * SECOND, 40_000_000):
        if 10 * SECOND <= now_ns < 34 * SECOND:
            service.receive(0, b"".join(vehicle.frames_until(now_ns)), now_ns)
        service.poll(now_ns)
        for frame in service.take_frames(0):
            vehicle.handle(frame, now_ns)
        before = len(caplog.messages)
        if reporter.next_deadline_ns <= now_ns:
            reporter.due(now_ns)
        said = [one for one in caplog.messages[before:] if not one.startswith("ready")]
        times += [(now_ns / SECOND, one) for one in said]
    return times, heard.states


def test_a_status_line_comes_where_its_words_change_and_else_at_the_configured_period(lines):
    times, states = lines
    assert [t for t, _ in times if t < 10] == [0.0]
    steady = [t for t, _ in times if 22 < t < 34]
    assert len(steady) <= 1, "every 10 s at most while it settles, else every 30 s"
    gone = [(t, text) for t, text in times if t >= 34]
    assert gone[0][0] <= 44
    assert "samples stopped" in gone[0][1] or "no vehicle" in gone[0][1]
    assert max(b - a for (a, _), (b, _) in pairwise(times)) <= 30.1
    assert len(states) == pytest.approx(7, abs=3), "systemd is told every 10 s"
