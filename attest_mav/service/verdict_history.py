"""The verdict over time: the newest one, how long its agreement has stood, and the intervals of equal verdicts."""

from collections import deque
from dataclasses import replace
from math import isfinite
from typing import Final

from attest_mav.estimation.events import Agreement, LaneEvent, Verdict
from attest_mav.estimation.lane_standings import LaneStandings
from attest_mav.estimation.verdict_intervals import IntervalChange, VerdictInterval, VerdictIntervals
from attest_mav.service.verdict_records import VerdictSpan, VerdictStanding

KEPT_INTERVALS: Final = 30
"""So many intervals that have ended are shown."""


class VerdictHistory:
    """Follows the verdicts of one vehicle. ``standing``: the newest one, None before the first."""

    def __init__(self) -> None:
        self.standing: VerdictStanding | None = None
        self._intervals: Final = VerdictIntervals()
        self._ended: Final[deque[VerdictSpan]] = deque(maxlen=KEPT_INTERVALS)
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
        return self._kept(self._intervals.take(verdict, self._lanes.states))

    def settle(self, now_ns: int) -> IntervalChange | None:
        """The change to be told because a doubt has lasted, although no verdict comes any more."""
        return self._kept(self._intervals.settle(now_ns))

    @property
    def spans(self) -> tuple[VerdictSpan, ...]:
        """The last intervals, the one that goes on included, and behind it a change that has not lasted yet."""
        going_on, standing = self.open_interval, self.standing
        if going_on is None or standing is None:
            return tuple(self._ended)
        span, newest = _span(going_on), standing.verdict
        if newest.agreement == span.agreement:
            return (*self._ended, span)
        tilt, heading = _known(newest.tilt), _known(newest.heading)
        change = VerdictSpan(newest.agreement, newest.reason, standing.since_ns, newest.rx_ns, tilt, heading)
        return (*self._ended, replace(span, end_ns=standing.since_ns), change)

    def _kept(self, change: IntervalChange | None) -> IntervalChange | None:
        """The same change, after its interval that ended was kept."""
        if change is not None and change.ended is not None:
            self._ended.append(_span(change.ended))
        return change


def _span(interval: VerdictInterval) -> VerdictSpan:
    return VerdictSpan(
        interval.agreement,
        interval.reason,
        interval.begin_ns,
        interval.end_ns,
        _known(interval.peak_tilt),
        _known(interval.peak_heading),
    )


def _known(angle: float) -> float | None:
    return angle if isfinite(angle) else None
