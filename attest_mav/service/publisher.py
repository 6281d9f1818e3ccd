"""Sends each estimate of one vehicle in the forms that may be believed, and tells when that changes."""

from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.companion import Companion
from attest_mav.service.announcements import Announcements
from attest_mav.service.publication_gate import GateChange, PublicationGate


class Publisher:
    """The way of the estimates from the pipeline to the companion. max_sigma: limit of the tilt sigma, rad."""

    def __init__(self, companion: Companion, announcements: Announcements, max_sigma: float) -> None:
        self._companion: Final = companion
        self._announcements: Final = announcements
        self._gate: Final = PublicationGate(max_sigma)

    @property
    def is_open(self) -> bool:
        """Whether the attitude is sent as believed."""
        return self._gate.is_open

    @property
    def reason(self) -> str:
        """Why the attitude is withheld, "" where it is sent."""
        return self._gate.reason

    def limit(self, max_sigma: float) -> None:
        """Withhold the attitude above this tilt sigma from now on, rad."""
        self._gate.max_sigma = max_sigma

    def publish(self, estimate: Estimate, contradicted: bool, now_ns: int) -> None:
        """Send an estimate. contradicted: a sensor, the receiver or the field speaks against it."""
        self._tell(self._gate.take(estimate, contradicted, now_ns))
        self._companion.publish(estimate, self._gate.confidence(estimate, contradicted))

    def withdraw(self, reason: str, now_ns: int) -> None:
        """There is no estimate any more, for this reason."""
        self._companion.withdraw()
        self._tell(self._gate.close(reason, now_ns))

    def _tell(self, change: GateChange | None) -> None:
        if change is not None:
            self._announcements.publishing(change)
