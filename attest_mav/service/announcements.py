"""Changes in words: verdicts, faults of lanes, and publishing that stops or begins again.

Each change makes one line of the log and one text for people at a ground station, which begins with ``attest``.
"""

from collections.abc import Sequence
from math import degrees, isfinite
from typing import Final

from attest_mav.estimation.events import Agreement, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.verdict_intervals import IntervalChange, VerdictInterval
from attest_mav.mavlink.component.announcer import Announcement
from attest_mav.mavlink.component.companion import Companion
from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.constants import MAV_SEVERITY_CRITICAL, MAV_SEVERITY_NOTICE, MAV_SEVERITY_WARNING
from attest_mav.service.publication_gate import GateChange
from attest_mav.service.status import VERDICT_WORDS, verdict_text

LANE_WARNINGS: Final = {
    LaneEventKind.STOPPED,
    LaneEventKind.DELAYED,
    LaneEventKind.FROZEN,
    LaneEventKind.REBOOTED,
    LaneEventKind.HEADING_LOST,
    LaneEventKind.FAULTY,
    LaneEventKind.EXPLAINED,
}
LANE_STOPS: Final = {LaneEventKind.STOPPED, LaneEventKind.DELAYED}
LANE_NOTICES: Final = {
    LaneEventKind.HEADING_FOUND,
    LaneEventKind.RETURNED,
    LaneEventKind.RECEIVER_USED,
    LaneEventKind.UNCALIBRATED,
}
"""Events of a lane that are announced; those that stop publishing are announced as that."""

VERDICTS_A_MINUTE: Final = 20
"""Lines of the log on verdicts, and as many on their intervals: forged attitudes can change the verdict at will."""
GAPS_A_MINUTE: Final = 3
"""Lines of the log on short gaps of one lane: a link that loses many frames makes several gaps a second."""


class Announcements:
    """Writes the changes of one service. ``companion``: sends the texts."""

    def __init__(self, companion: Companion) -> None:
        self._companion: Final = companion
        self._notebook: Final[Notebook] = companion.notebook
        self._gaps: Final = LineLimit(GAPS_A_MINUTE)
        self._verdicts: Final = LineLimit(VERDICTS_A_MINUTE)

    def lane_event(self, event: LaneEvent) -> None:
        """Tell what happened to a lane."""
        text = f"{event.lane}: {event.text}"
        if event.kind == LaneEventKind.GAP:
            suffix = self._gaps.suffix(event.lane, event.rx_ns)
            if suffix is not None:
                self._note(False, text + suffix)
            return
        is_warning = event.kind in LANE_WARNINGS
        self._note(is_warning, text)
        if event.kind in LANE_STOPS or not (is_warning or event.kind in LANE_NOTICES):
            return
        self._announce(event.lane, MAV_SEVERITY_WARNING if is_warning else MAV_SEVERITY_NOTICE, text)

    def publishing(self, change: GateChange) -> None:
        """Tell that the attitude is withheld, or published again."""
        if change.opened:
            text = f"attitude sent again after {change.withheld_s:.1f} s"
        else:
            text = f"attitude withheld: {change.reason}"
        self._note(not change.opened, text)
        self._announce("publishing", MAV_SEVERITY_NOTICE if change.opened else MAV_SEVERITY_WARNING, text)

    def verdict(self, change: IntervalChange, in_flight: bool, reports: Sequence[str]) -> None:
        """Tell that an interval of the verdict has begun. reports: what the autopilot itself reports."""
        verdict, ended = change.verdict, change.ended
        if ended is not None:
            self.interval(ended)
        suffix = f"; the autopilot itself {', '.join(reports)}" if reports else ""
        left_out = self._verdicts.suffix("verdict", verdict.rx_ns)
        if left_out is not None:
            is_wrong = verdict.agreement == Agreement.DISAGREE
            self._note(is_wrong, f"verdict: {verdict_text(verdict)}{suffix}{left_out}")
        if ended is None and verdict.agreement == Agreement.UNDECIDED:
            return
        doubt = verdict.agreement == Agreement.UNDECIDED and ended is not None and ended.agreement == Agreement.AGREE
        if verdict.agreement == Agreement.DISAGREE:
            severity = MAV_SEVERITY_CRITICAL
        else:
            severity = MAV_SEVERITY_WARNING if doubt and in_flight else MAV_SEVERITY_NOTICE
        self._announce("verdict", severity, announced_verdict(verdict, ended))

    def interval(self, ended: VerdictInterval) -> None:
        """Write an interval that has ended into the log."""
        left_out = self._verdicts.suffix("interval", ended.end_ns)
        if left_out is not None:
            self._notebook.info(f"verdict interval: {interval_text(ended)}{left_out}")

    def _note(self, is_warning: bool, text: str) -> None:
        note = self._notebook.warning if is_warning else self._notebook.info
        note(text)

    def _announce(self, topic: str, severity: int, text: str) -> None:
        self._companion.announcer.announce(Announcement(topic, severity, f"attest: {text}"))


def announced_verdict(verdict: Verdict, ended: VerdictInterval | None) -> str:
    """A verdict in at most 42 characters; after a DISAGREE with its length and its largest tilt difference."""
    word = VERDICT_WORDS[verdict.agreement]
    if ended is not None and ended.agreement == Agreement.DISAGREE:
        return f"{word}; was off {ended.duration_s:.1f} s, tilt up to {degrees(ended.peak_tilt):.1f}"
    if verdict.agreement == Agreement.UNDECIDED or verdict.reason in {"frozen", "settling"}:
        return f"{word} ({verdict.reason})"
    tilt = f" tilt {degrees(verdict.tilt):.1f}" if isfinite(verdict.tilt) else ""
    heading = f" heading {degrees(verdict.heading):+.1f}" if isfinite(verdict.heading) else ""
    return f"{word}{tilt}{heading} deg"


def interval_text(interval: VerdictInterval) -> str:
    """An interval in one line: agreement, reason, length, largest differences, and the states of our lanes."""
    parts = [
        f"{interval.agreement.name} ({interval.reason}) for {interval.duration_s:.1f} s,{_peaks(interval)}",
        *interval.lanes,
    ]
    return "; ".join(parts)


def _peaks(interval: VerdictInterval) -> str:
    if not isfinite(interval.peak_tilt):
        return " nothing compared"
    text = f" tilt up to {degrees(interval.peak_tilt):.1f}"
    heading = f" heading {degrees(interval.peak_heading):+.1f}" if isfinite(interval.peak_heading) else ""
    return f"{text}{heading} deg"
