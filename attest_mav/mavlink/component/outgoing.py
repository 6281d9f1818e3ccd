"""What a companion sends of its own accord: the newest estimate with its verdict, and the heartbeats."""

from math import degrees
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.outputs import NO_VERDICT, Confidence, Publication, PublishedVerdict
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID

HEARTBEAT_NS: Final = 1_000_000_000


class Outgoing:
    """The newest estimate and verdict, and when the next heartbeat is due. ``ports``: all links."""

    def __init__(self, ports: list[Port], now_ns: int) -> None:
        self.due_ns = now_ns
        """When the next heartbeat is due."""
        self.autopilot = MAV_AUTOPILOT_INVALID
        """MAV_AUTOPILOT of the vehicle."""
        self._resets = 0
        self._ports: Final = ports
        self._estimate: Estimate | None = None
        self._confidence = Confidence.BELIEVED
        self._verdict = NO_VERDICT

    @property
    def publication(self) -> Publication | None:
        """The estimate and verdict to be sent now; None while there is no valid estimate."""
        return None if self._estimate is None else self._publication(self._estimate)

    def publish(self, estimate: Estimate, confidence: Confidence) -> None:
        """Send the newest estimate on every link where it is due, and keep it for requests."""
        before = self._estimate if self._confidence == Confidence.BELIEVED else None
        if confidence == Confidence.BELIEVED and (before is None or before.lane != estimate.lane):
            self._resets += 1
        self._estimate, self._confidence = estimate, confidence
        publication = self._publication(estimate)
        for port in self._ports:
            port.publish(publication)

    def withdraw(self) -> None:
        """Drop the estimate: it is not valid any more."""
        self._estimate = None

    def set_verdict(self, ok: float, tilt: float, heading: float) -> None:
        """Take the verdict: ok is 1 (agrees), 0 (disagrees), -1 (undecided); differences in rad, NaN where unknown."""
        self._verdict = PublishedVerdict(ok, degrees(tilt), degrees(heading))

    def _publication(self, estimate: Estimate) -> Publication:
        return Publication(estimate, self._verdict, self._confidence, self.autopilot, self._resets)

    def beat(self, state: int, now_ns: int) -> None:
        """Send a heartbeat with this MAV_STATE on each link, and the outputs beside it, when it is due."""
        if now_ns < self.due_ns:
            return
        self.due_ns = max(self.due_ns + HEARTBEAT_NS, now_ns + HEARTBEAT_NS // 2)
        publication = self.publication
        for port in self._ports:
            port.heartbeat(state)
            if publication is not None:
                port.publish_beside_heartbeat(publication)
