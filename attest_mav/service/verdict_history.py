"""The verdict over time: the newest one, how long its agreement has stood, and the intervals of equal verdicts."""

from typing import Final

from attest_mav.estimation.events import Agreement, LaneEvent, Verdict
from attest_mav.estimation.lane_standings import LaneStandings
from attest_mav.estimation.verdict_intervals import IntervalChange, VerdictInterval, VerdictIntervals
from attest_mav.service.snapshot import VerdictStanding


class VerdictHistory:
    """Follows the verdicts of one vehicle. ``standing``: the newest one, None before the first."""

    def __init__(self) -> None:
        self.standing: VerdictStanding | None = None
        self._intervals: Final = VerdictIntervals()
        self._lanes: Final = LaneStandings()

    @property
    def disagrees(self) -> bool:
        """True while the verdict is DISAGREE."""
        return self.standing is not None and self.standing.verdict.agreement == Agreement.DISAGREE

    @property
    def open_interval(self) -> VerdictInterval | None:
        """The interval that goes on, up to the newest verdict; None before the first one."""
        return None if self.standing is None else self._intervals.open_interval(self.standing.verdict.rx_ns)

    def lane_event(self, event: LaneEvent) -> None:
        """Take note of what happened to a lane."""
        self._lanes.take(event)

    def take(self, verdict: Verdict) -> IntervalChange | None:
        """Take the newest verdict; the change to be told, where it begins a new interval."""
        before = self.standing
        same = before is not None and before.verdict.agreement == verdict.agreement
        since_ns = before.since_ns if before is not None and same else verdict.rx_ns
        self.standing = VerdictStanding(verdict, since_ns)
        return self._intervals.take(verdict, self._lanes.states)

    def settle(self, now_ns: int) -> IntervalChange | None:
        """The change to be told because a doubt has lasted, although no verdict comes any more."""
        return self._intervals.settle(now_ns)
