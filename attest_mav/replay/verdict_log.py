"""The verdict on the autopilot's attitude over a recorded flight, as intervals in log time."""

from math import floor
from typing import Final

from attest_mav.estimation.events import LaneEvent, Verdict
from attest_mav.estimation.lane_standings import LaneStandings
from attest_mav.estimation.self_report import SelfReport
from attest_mav.estimation.verdict_intervals import IntervalChange, VerdictInterval, VerdictIntervals


class LoggedInterval:
    """An interval in log time.

    reports: what the autopilot itself reported as bad at the end.
    """

    def __init__(self, interval: VerdictInterval, reports: tuple[str, ...]) -> None:
        self.interval: Final = interval
        self.reports: Final = reports

    @property
    def begin_s(self) -> float:
        """Log time of the first verdict, s."""
        return self.interval.begin_ns * 1e-9

    @property
    def end_s(self) -> float:
        """Log time of the end, s."""
        return self.interval.end_ns * 1e-9


class VerdictLog:
    """Follows the verdicts beside one filter. self_report: what the autopilot says of itself."""

    def __init__(self, self_report: SelfReport) -> None:
        self.intervals: Final[list[LoggedInterval]] = []
        self._self_report: Final = self_report
        self._lanes: Final = LaneStandings()
        self._verdicts: Final = VerdictIntervals()

    def lane_event(self, event: LaneEvent) -> None:
        """Take note of what happened to a lane."""
        self._lanes.take(event)

    def take(self, verdict: Verdict, elapsed_s: float) -> None:
        """Take the next verdict, which came at this log time."""
        timed = Verdict(
            verdict.agreement,
            verdict.reason,
            verdict.tilt,
            verdict.heading,
            verdict.source,
            verdict.t_ns,
            _in_ns(elapsed_s),
        )
        self._take_change(self._verdicts.take(timed, self._lanes.states), verdict.rx_ns)

    def settle(self, elapsed_s: float, rx_ns: int) -> None:
        """No verdict has come until this log time and time of reception."""
        self._take_change(self._verdicts.settle(_in_ns(elapsed_s)), rx_ns)

    def finish(self, elapsed_s: float, rx_ns: int) -> None:
        """The log has ended, at this log time and time of reception."""
        self.settle(elapsed_s, rx_ns)
        self._end(self._verdicts.open_interval(_in_ns(elapsed_s)), rx_ns)

    def _take_change(self, change: IntervalChange | None, rx_ns: int) -> None:
        if change is not None:
            self._end(change.ended, rx_ns)

    def _end(self, interval: VerdictInterval | None, rx_ns: int) -> None:
        if interval is not None:
            self.intervals.append(LoggedInterval(interval, self._self_report.remarks(rx_ns)))


def _in_ns(elapsed_s: float) -> int:
    """Log time in whole nanoseconds; compiled, ``round`` would go through Python."""
    return floor(1e9 * elapsed_s + 0.5)
