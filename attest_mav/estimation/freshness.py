"""Whether the samples of the selected lane come in time, and the events when they do not."""

from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.estimation.events import LaneEvent, LaneEventKind
from attest_mav.samples import ImuSample

TOLD_NS: Final = 500_000_000
"""A delay that has lasted for this long is told; a link that stalls for a moment is not worth a line."""


class FreshnessWatch:
    """Follows the delays of one vehicle's samples."""

    def __init__(self) -> None:
        self.late_by_s = 0.0
        """The delay of the newest sample where it is too large, s; else 0."""
        self._worst_s = 0.0
        self._since_ns = -1
        self._rx_ns = -1
        self._told = False

    def take(self, sample: ImuSample, delay_s: float, limit_s: float) -> LaneEvent | None:
        """Take the delay of the newest sample: the event to be told, if any."""
        self._rx_ns = sample.rx_ns
        if delay_s <= limit_s:
            return self._recovered(sample)
        self.late_by_s = delay_s
        self._worst_s = max(self._worst_s, delay_s)
        if self._since_ns < 0:
            self._since_ns = sample.rx_ns
        if self._told or sample.rx_ns - self._since_ns < TOLD_NS:
            return None
        return self._delayed(sample.source, sample.t_ns, sample.rx_ns)

    def stopped(self, estimate: Estimate, now_ns: int, stale_ns: int) -> LaneEvent:
        """The event that the newest estimate does not hold any more: samples come too late, or none come."""
        if self.late_by_s > 0.0 and now_ns - self._rx_ns < stale_ns:
            return self._delayed(estimate.lane, estimate.t_ns, now_ns)
        text = f"no usable sample for {1e-9 * stale_ns:.3g} s"
        return LaneEvent(estimate.lane, LaneEventKind.STOPPED, estimate.t_ns, now_ns, text)

    def _delayed(self, lane: str, t_ns: int, rx_ns: int) -> LaneEvent:
        self._told = True
        return LaneEvent(lane, LaneEventKind.DELAYED, t_ns, rx_ns, f"samples come {self.late_by_s:.2f} s late")

    def _recovered(self, sample: ImuSample) -> LaneEvent | None:
        told, worst_s = self._told, self._worst_s
        self.late_by_s = self._worst_s = 0.0
        self._since_ns, self._told = -1, False
        if not told:
            return None
        text = f"samples come in time again; they were up to {worst_s:.2f} s late"
        return LaneEvent(sample.source, LaneEventKind.IN_TIME, sample.t_ns, sample.rx_ns, text)
