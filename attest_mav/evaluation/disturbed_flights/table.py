"""The table of disturbed flights: all rows, and one line of text for each outcome."""

from collections.abc import Iterator
from math import isfinite
from typing import Final

from attest_mav.estimation.events import Agreement
from attest_mav.evaluation.disturbed_flights import rows_link, rows_strangers, rows_vehicle
from attest_mav.evaluation.disturbed_flights.flight import Outcome, fly, misses
from attest_mav.evaluation.disturbed_flights.row import Disturbance
from attest_mav.evaluation.harness import TrialMap

ROWS: Final = (*rows_link.ROWS, *rows_vehicle.ROWS, *rows_strangers.ROWS)

HEADER: Final = (
    "| what happens | verdicts meanwhile | sent, Hz | named after, s | accused after, s | good after, s | tilt, ° |\n"
    "|---|---|---|---|---|---|---|"
)


def run(trial_map: TrialMap, chosen: list[Disturbance]) -> Iterator[tuple[Disturbance, Outcome]]:
    """Fly these rows; the outcomes in order."""
    return zip(chosen, trial_map(fly_by_name, [row.name for row in chosen]), strict=True)


def fly_by_name(name: str) -> Outcome:
    """Fly the row of that name: a name can be sent to another process, a row with its functions cannot."""
    return fly(next(row for row in ROWS if row.name == name))


def line_of(row: Disturbance, found: Outcome) -> str:
    """One line of the table in Markdown, with the bounds that were missed."""
    verdicts = dict.fromkeys(agreement for agreement, _ in found.verdicts) or {Agreement.AGREE: None}
    cells = (
        row.name,
        ", ".join(agreement.name for agreement in verdicts),
        f"{found.sent_hz:.0f}",
        _seconds(found.detected_s),
        _seconds(found.accused_s),
        _seconds(found.recovered_s),
        f"{found.worst_tilt_deg:.1f}",
    )
    missed = misses(row, found)
    return f"| {' | '.join(cells)} |" + (f"  MISSED: {'; '.join(missed)}" if missed else "")


def _seconds(time_s: float) -> str:
    return f"{time_s:.1f}" if isfinite(time_s) else ""
