"""Passes the verdicts on one vehicle on: to the companion, which sends them, and in words where they change."""

from math import nan
from typing import Final

from attest_mav.estimation.events import Agreement, LaneEvent, Verdict
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.estimation.verdict_intervals import IntervalChange
from attest_mav.mavlink.component.companion import Companion
from attest_mav.service.announcements import Announcements
from attest_mav.service.verdict_history import VerdictHistory
from attest_mav.service.verdict_records import VerdictSpan, VerdictStanding

_VERDICT_CODES: Final = {Agreement.AGREE: 1.0, Agreement.DISAGREE: 0.0, Agreement.UNDECIDED: -1.0}
"""The value of ATT_OK for each verdict."""


class VerdictTeller:
    """The verdicts of one vehicle, from the first one to the last."""

    def __init__(self, companion: Companion, announcements: Announcements, vehicle: Vehicle) -> None:
        self._companion: Final = companion
        self._announcements: Final = announcements
        self._vehicle: Final = vehicle
        self._history: Final = VerdictHistory()
        companion.set_verdict(nan, nan, nan)

    @property
    def standing(self) -> VerdictStanding | None:
        """The newest verdict and how long it has stood, None before the first."""
        return self._history.standing

    @property
    def spans(self) -> tuple[VerdictSpan, ...]:
        """The last intervals of the verdict."""
        return self._history.spans

    @property
    def disagrees(self) -> bool:
        """True while the verdict is DISAGREE."""
        return self._history.disagrees

    def lane_event(self, event: LaneEvent) -> None:
        """Tell what happened to a lane."""
        self._history.lane_event(event)
        self._announcements.lane_event(event)

    def take(self, verdict: Verdict) -> None:
        """Pass a verdict on; tell when it changes."""
        self._companion.set_verdict(_VERDICT_CODES[verdict.agreement], verdict.tilt, verdict.heading)
        self._tell(self._history.take(verdict))

    def settle(self, now_ns: int) -> None:
        """Tell a doubt that has lasted, although no verdict comes any more."""
        self._tell(self._history.settle(now_ns))

    def end(self) -> None:
        """Write the interval of the verdict that goes on into the log: no more verdicts on this vehicle follow."""
        interval = self._history.open_interval
        if interval is not None:
            self._announcements.interval(interval)

    def _tell(self, change: IntervalChange | None) -> None:
        if change is not None:
            remarks = self._vehicle.self_report.remarks(change.verdict.rx_ns)
            self._announcements.verdict(change, self._vehicle.armed is True, remarks)
