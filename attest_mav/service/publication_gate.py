"""Whether our attitude is published as believed: the reasons against it, with hysteresis, and the changes to be told.

The attitude is withheld while the filter aligns, while samples are missing, while its tilt sigma is above the limit,
and while a sensor, the receiver or the magnetic field contradicts it. A filter without a sigma has no such limit.
"""

from math import degrees
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.outputs import Confidence, is_sound

RELEASE: Final = 0.8
"""Share of the limit below which sigma must fall before a withheld attitude is published again."""
REOPEN_NS: Final = 1_000_000_000
"""Time for which nothing may have spoken against a withheld attitude before it is published again."""
TOLD_NS: Final = 1_000_000_000
"""An attitude that is withheld is told when something has spoken against it for this long: doubts often end sooner."""


class GateChange:
    """Publishing stopped or began again, to be told. reason: why it stopped. withheld_s: time without it so far, s."""

    def __init__(self, opened: bool, reason: str, withheld_s: float) -> None:
        self.opened: Final = opened
        self.reason: Final = reason
        self.withheld_s: Final = withheld_s


class PublicationGate:
    """Decides for each estimate of one vehicle. max_sigma: the limit of the tilt sigma, rad."""

    def __init__(self, max_sigma: float) -> None:
        self.is_open = False
        """Whether the attitude is published as believed."""
        self.reason = ""
        """Why it is withheld, "" while it is published and before the first estimate."""
        self.max_sigma = max_sigma
        """The limit of the tilt sigma, rad."""
        self._closed_ns = 0
        self._objected_ns = 0
        self._was_open = False
        self._is_told = False

    def take(self, estimate: Estimate, contradicted: bool, now_ns: int) -> GateChange | None:
        """Take the newest estimate; the change to be told. contradicted: something speaks against the attitude."""
        objection = self._objection(estimate, contradicted)
        if objection:
            self._close(objection, now_ns)
            return self._told(now_ns) if now_ns - self._closed_ns >= TOLD_NS else None
        if self.is_open or (self._was_open and now_ns - self._objected_ns < REOPEN_NS):
            return None
        change = GateChange(True, self.reason, (now_ns - self._closed_ns) * 1e-9) if self._is_told else None
        self.is_open = self._was_open = True
        self.reason, self._is_told = "", False
        return change

    def close(self, reason: str, now_ns: int) -> GateChange | None:
        """There is no estimate any more; the change to be told, which is told at once.

        No estimate is no objection: only the moment at which the last one went counts as one.
        """
        if self.is_open:
            self._close(reason, now_ns)
        self.reason = reason
        return self._told(now_ns)

    def _close(self, reason: str, now_ns: int) -> None:
        self._objected_ns = now_ns
        if self.is_open:
            self.is_open, self._closed_ns = False, now_ns
        self.reason = reason

    def _told(self, now_ns: int) -> GateChange | None:
        """The change, unless it was told already, or nothing was ever published."""
        if self._is_told or not self._was_open:
            return None
        self._is_told = True
        return GateChange(False, self.reason, (now_ns - self._closed_ns) * 1e-9)

    def confidence(self, estimate: Estimate, contradicted: bool) -> Confidence:
        """How far the estimate that was taken can be believed."""
        if self.is_open:
            return Confidence.BELIEVED
        return Confidence.DOUBTED if contradicted or not is_sound(estimate) else Confidence.UNCERTAIN

    def _objection(self, estimate: Estimate, contradicted: bool) -> str:
        """What speaks against publishing the attitude, "" for nothing."""
        if not is_sound(estimate):
            return "not finite"
        if contradicted:
            return "contradicted"
        share = 1.0 if self.is_open or not self._was_open else RELEASE
        if estimate.tilt_sigma > share * self.max_sigma:
            return f"tilt sigma {degrees(estimate.tilt_sigma):.1f} over {degrees(self.max_sigma):g} deg"
        return ""
