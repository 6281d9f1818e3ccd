"""``sim:``: the fake autopilot inside the daemon, as a link whose time is the loop's own clock."""

from attest_mav.config.link_url import LinkUrl
from attest_mav.mavlink.dialect import Dialect
from attest_mav.runtime.links.base import Link, log
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

SEED = 1
"""The same vehicle every time."""


class SimLink(Link):
    """A vehicle that starts when the link is opened. UsageError for a scenario or fault that does not exist."""

    def __init__(self, url: LinkUrl, dialect: Dialect, now_ns: int) -> None:
        super().__init__(str(url))
        settings = SimSettings(scenario=url.scenario or SimSettings.scenario, faults=parse_faults(url.faults))
        self.vehicle = FakeAutopilot(settings, SEED, dialect)
        self.began_ns = now_ns
        self.epoch = 1
        log.info("simulating a vehicle: %s", " ".join((settings.scenario, *url.faults)))

    @property
    def fd(self) -> int | None:
        """None: there is nothing to watch but the clock."""
        return None

    @property
    def is_up(self) -> bool:
        """Always."""
        return True

    @property
    def is_open(self) -> bool:
        """Always."""
        return True

    @property
    def next_deadline_ns(self) -> int | None:
        """When the vehicle has something to send."""
        return self.began_ns + self.vehicle.next_deadline_ns

    def receive(self, now_ns: int) -> bytes:
        """See ``Link``."""
        data = b"".join(self.vehicle.frames_until(now_ns - self.began_ns))
        self.received_bytes += len(data)
        return data

    def send(self, message: bytes, now_ns: int) -> None:
        """See ``Link``."""
        self.vehicle.handle(message, now_ns - self.began_ns)
        self.sent_bytes += len(message)

    def flush(self, now_ns: int) -> None:
        """Nothing ever waits."""

    def close(self) -> None:
        """Nothing to close."""
