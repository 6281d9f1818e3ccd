"""Two results of the same logs side by side: the change of each figure, the worst first."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from attest_mav.replay.limits import Checked, Limit

FIGURES: Final = ("tilt_rms_deg", "heading_rms_deg", "disagree_s", "undecided_s")
"""The figures whose change is told: errors of a filter against the reference, and seconds of the verdict."""
LIMITED_CHANGES: Final[Mapping[str, str]] = {
    "tilt.rms": "tilt_rms_deg",
    "heading.rms": "heading_rms_deg",
    "verdict.disagree_s": "disagree_s",
    "verdict.undecided_s": "undecided_s",
}
"""The figures whose growth can be limited, by the names that the limits of a replay have."""

Kept = Mapping[str, Any]
"""A line of a file of results: log, size, work and report or error."""


@dataclass(frozen=True)
class Change:
    """One filter over one log. Values before and after by figure, None where one has none."""

    log: str
    filter: str
    before: Mapping[str, float | None]
    after: Mapping[str, float | None]

    def of(self, figure: str) -> float | None:
        """After less before; None where one has none."""
        before, after = self.before[figure], self.after[figure]
        return None if before is None or after is None else after - before


@dataclass(frozen=True)
class ResultsComparison:
    """All changes, and the logs that cannot be compared or only with care."""

    changes: list[Change]
    only_before: list[str]
    only_after: list[str]
    other_size: list[str]
    """Logs that are another file now."""
    other_work: list[str]
    """Logs that were replayed by another version or configuration."""
    unread: list[str]
    """Logs that one of the two could not read, or without a filter in common."""


def compare_results(before: Mapping[str, Kept], after: Mapping[str, Kept]) -> ResultsComparison:
    """Compare results by log: the largest growth of DISAGREE first, then that of the tilt error."""
    both = [log for log in before if log in after]
    changes = {log: _changes(log, before[log], after[log]) for log in both}
    return ResultsComparison(
        sorted([one for found in changes.values() for one in found], key=_rank),
        [log for log in before if log not in after],
        [log for log in after if log not in before],
        [log for log in both if before[log]["of"]["bytes"] != after[log]["of"]["bytes"]],
        [log for log in both if before[log]["of"]["work"] != after[log]["of"]["work"]],
        [log for log, found in changes.items() if not found],
    )


def check_changes(changes: Sequence[Change], limits: Sequence[Limit]) -> list[Checked]:
    """Each limit held against the growth of its figure on every log that had it before; a lost figure misses it."""
    return [
        Checked(f"{one.log}: {one.filter}: growth of {limit.name}", one.of(LIMITED_CHANGES[limit.name]), limit.most)
        for limit in limits
        for one in changes
        if one.before[LIMITED_CHANGES[limit.name]] is not None
    ]


def _changes(log: str, before: Kept, after: Kept) -> list[Change]:
    first, second = _figures(before.get("report")), _figures(after.get("report"))
    return [Change(log, name, first[name], second[name]) for name in first if name in second]


def _figures(report: dict[str, Any] | None) -> dict[str, dict[str, float | None]]:
    """The figures of each filter; those of the verdict with the filter that it stands beside."""
    if report is None:
        return {}
    verdict = report["verdict"]
    found: dict[str, dict[str, float | None]] = {}
    for one in report["filters"]:
        judges = one["name"] == verdict["filter"] and bool(verdict["intervals"])
        found[one["name"]] = {
            "tilt_rms_deg": None if one["tilt_deg"] is None else one["tilt_deg"]["rms"],
            "heading_rms_deg": None if one["heading_deg"] is None else one["heading_deg"]["rms"],
            "disagree_s": verdict["disagree_s"] if judges else None,
            "undecided_s": verdict["undecided_s"] if judges else None,
        }
    return found


def _rank(change: Change) -> tuple[float, float, float, str, str]:
    growth = [-(change.of(figure) or 0.0) for figure in ("disagree_s", "tilt_rms_deg", "heading_rms_deg")]
    return growth[0], growth[1], growth[2], change.log, change.filter
