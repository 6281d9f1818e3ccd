"""The verdict over time: how long it has stood, and which of its changes are worth a line in the log."""

from typing import Final

from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.service.snapshot import VerdictStanding

LASTING_NS: Final = 10_000_000_000
"""A change between AGREE and UNDECIDED is told once it has lasted this long: near a limit it comes and goes."""


class VerdictHistory:
    """Follows the verdicts of one vehicle. ``standing``: the newest one, None before the first."""

    def __init__(self) -> None:
        self.standing: VerdictStanding | None = None
        self._told: Agreement | None = None

    @property
    def disagrees(self) -> bool:
        """True while the verdict is DISAGREE."""
        return self.standing is not None and self.standing.verdict.agreement == Agreement.DISAGREE

    def take(self, verdict: Verdict) -> bool:
        """Take the newest verdict; True when it is a change to be told. An accusation and its end are told at once."""
        before = self.standing
        same = before is not None and before.verdict.agreement == verdict.agreement
        since_ns = before.since_ns if before is not None and same else verdict.rx_ns
        self.standing = VerdictStanding(verdict, since_ns)
        if verdict.agreement == self._told:
            return False
        grave = Agreement.DISAGREE in {verdict.agreement, self._told}
        if not grave and self._told is not None and verdict.rx_ns - since_ns < LASTING_NS:
            return False
        self._told = verdict.agreement
        return True
