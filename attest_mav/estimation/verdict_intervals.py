"""Verdicts as intervals: how long each agreement stood, for which reason, and how far the attitudes were apart.

DISAGREE begins and ends an interval at once. Between AGREE and UNDECIDED a new interval begins when the change has
lasted for ``LASTING_NS``, back at its first verdict: near a limit the verdict comes and goes.
"""

from math import isnan, nan
from typing import Final

from attest_mav.estimation.events import Agreement, Verdict

LASTING_NS: Final = 10_000_000_000


class VerdictInterval:
    """One interval.

    begin_ns: its first verdict, host clock. end_ns: the first verdict of the next interval. reason: given with most of
    its verdicts. peak_tilt, peak_heading: the largest differences, rad, NaN where nothing was compared. lanes: the
    states of our lanes at its last verdict.
    """

    def __init__(
        self,
        agreement: Agreement,
        reason: str,
        begin_ns: int,
        end_ns: int,
        peak_tilt: float,
        peak_heading: float,
        lanes: tuple[str, ...],
    ) -> None:
        self.agreement: Final = agreement
        self.reason: Final = reason
        self.begin_ns: Final = begin_ns
        self.end_ns: Final = end_ns
        self.peak_tilt: Final = peak_tilt
        self.peak_heading: Final = peak_heading
        self.lanes: Final = lanes

    @property
    def duration_s(self) -> float:
        """Length on the host's clock, s."""
        return (self.end_ns - self.begin_ns) * 1e-9


class _Stretch:
    """An interval that goes on."""

    def __init__(self, first: Verdict, lanes: tuple[str, ...]) -> None:
        self.first: Final = first
        self._peak_tilt = nan
        self._peak_heading = nan
        self._lanes = lanes
        self._reasons: Final[dict[str, int]] = {}
        self.add(first, lanes)

    def add(self, verdict: Verdict, lanes: tuple[str, ...]) -> None:
        """Take one more verdict of the same agreement."""
        self._lanes = lanes
        self._reasons[verdict.reason] = self._reasons.get(verdict.reason, 0) + 1
        if isnan(self._peak_tilt) or verdict.tilt > self._peak_tilt:
            self._peak_tilt = verdict.tilt
        if isnan(self._peak_heading) or abs(verdict.heading) > abs(self._peak_heading):
            self._peak_heading = verdict.heading

    def until(self, end_ns: int) -> VerdictInterval:
        """The interval with this end, host clock."""
        reasons = self._reasons
        most = max(reasons.values())
        reason = next(one for one, count in reasons.items() if count == most)
        first = self.first
        return VerdictInterval(
            first.agreement, reason, first.rx_ns, end_ns, self._peak_tilt, self._peak_heading, self._lanes
        )


class IntervalChange:
    """A new interval began. ended: the interval before it, None at the first one. verdict: the newest one."""

    def __init__(self, ended: VerdictInterval | None, verdict: Verdict) -> None:
        self.ended: Final = ended
        self.verdict: Final = verdict


class VerdictIntervals:
    """Makes intervals of the verdicts on one vehicle."""

    def __init__(self) -> None:
        self._current: _Stretch | None = None
        self._next: _Stretch | None = None
        self._newest: Verdict | None = None

    def take(self, verdict: Verdict, lanes: tuple[str, ...] = ()) -> IntervalChange | None:
        """Take the newest verdict; the change where an interval begins. lanes: the states of our lanes now."""
        self._newest = verdict
        current = self._current
        if current is None:
            self._current = _Stretch(verdict, lanes)
            return IntervalChange(None, verdict)
        if verdict.agreement == current.first.agreement:
            current.add(verdict, lanes)
            self._next = None
            return None
        following = self._next
        if following is None or following.first.agreement != verdict.agreement:
            following = self._next = _Stretch(verdict, lanes)
        else:
            following.add(verdict, lanes)
        if Agreement.DISAGREE in (verdict.agreement, current.first.agreement):
            return self._go_on(current, following, verdict)
        return self.settle(verdict.rx_ns)

    def settle(self, now_ns: int) -> IntervalChange | None:
        """The change that follows from no other verdict having come until then (host clock)."""
        current, following, newest = self._current, self._next, self._newest
        if current is None or following is None or newest is None or now_ns - following.first.rx_ns < LASTING_NS:
            return None
        return self._go_on(current, following, newest)

    def _go_on(self, current: _Stretch, following: _Stretch, verdict: Verdict) -> IntervalChange:
        self._current, self._next = following, None
        return IntervalChange(current.until(following.first.rx_ns), verdict)

    def open_interval(self, now_ns: int) -> VerdictInterval | None:
        """The interval that goes on, with this instant as its end; None before the first verdict."""
        return None if self._current is None else self._current.until(now_ns)
