"""Many logs in one table: the verdict and the errors of each, the worst first."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from attest_mav.replay.batch import Outcome


@dataclass(frozen=True)
class SummaryRow:
    """One log. Times in s, errors in degrees; None where nothing was judged or compared."""

    log: str
    disagree_s: float | None
    undecided_s: float | None
    autopilot_tilt: float | None
    """Largest tilt between the autopilot's attitude and ours where both were judged."""
    tilt_rms: float | None
    """Of the judging filter against the reference."""
    error: str
    """The reason why the log could not be replayed, "" for one that was."""


def summary_of(outcomes: Iterable[Outcome]) -> list[SummaryRow]:
    """A row a log: those with the longest DISAGREE first, then those with the largest difference, the unread last."""
    return sorted((_row(one) for one in outcomes), key=_rank)


def _row(outcome: Outcome) -> SummaryRow:
    report = outcome.report
    if report is None:
        return SummaryRow(outcome.path, None, None, None, None, str(outcome.error))
    verdict = report["verdict"]
    intervals: list[dict[str, Any]] = verdict["intervals"]
    peaks = [one["peak_tilt_deg"] for one in intervals if one["state"] != "undecided" and one["peak_tilt_deg"]]
    judge = next(one for one in report["filters"] if one["name"] == verdict["filter"])
    return SummaryRow(
        outcome.path,
        verdict["disagree_s"] if intervals else None,
        verdict["undecided_s"] if intervals else None,
        max(peaks, default=None),
        None if judge["tilt_deg"] is None else judge["tilt_deg"]["rms"],
        "",
    )


def _rank(row: SummaryRow) -> tuple[bool, bool, float, float, str]:
    """Read and judged logs first."""
    disagree_s = row.disagree_s or 0.0
    return bool(row.error), row.disagree_s is None, -disagree_s, -(row.autopilot_tilt or 0.0), row.log
