"""``attest-mav compare``: two files of results of ``replay --results`` side by side."""

import json
from pathlib import PurePath
from typing import Any, Final

import click

from attest_mav.cli.text_table import TextTable, figures, screen_width, words
from attest_mav.replay.limits import Checked, parse_limit
from attest_mav.replay.results_comparison import (
    FIGURES,
    LIMITED_CHANGES,
    Change,
    ResultsComparison,
    check_changes,
    compare_results,
)
from attest_mav.runtime.results import read_results

SHOWN: Final = 5
"""So many logs of a remark are named."""


@click.command("compare")
@click.argument("before", metavar="BEFORE")
@click.argument("after", metavar="AFTER")
@click.option("--rows", type=click.IntRange(min=1), default=20, show_default=True, help="Rows of the table at most.")
@click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="NAME=VALUE",
    help=f"Exit with 1 where a figure has grown by more; of {', '.join(LIMITED_CHANGES)}. May be given several times.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of a table.")
def command(before: str, after: str, rows: int, limits: tuple[str, ...], as_json: bool) -> None:
    """Compare two files that replay --results has written: what changed on each log, the worst first.

    A log is known by its name. Where a file has several results of one log, the last one counts. The changes are those
    of the errors against the reference and of the seconds of the verdict, AFTER less BEFORE. A limit is held against
    the growth on each log; a figure that AFTER lacks misses it, and so do results without a log in common.
    """
    parsed = [parse_limit(text, list(LIMITED_CHANGES)) for text in limits]
    comparison = compare_results(read_results(before), read_results(after))
    checked = check_changes(comparison.changes, parsed)
    if as_json:
        click.echo(json.dumps(as_object(comparison, checked), allow_nan=False))
    else:
        print_comparison(comparison, rows)
        print_missed(checked)
    is_missed = any(not one.passes for one in checked) or (bool(parsed) and not comparison.changes)
    click.get_current_context().exit(int(is_missed))


def print_missed(checked: list[Checked]) -> None:
    """Print the limits that were missed."""
    for one in checked:
        if not one.passes:
            click.echo(f"  limit MISSED {click.format_filename(str(one))}")


def as_object(comparison: ResultsComparison, checked: list[Checked]) -> dict[str, Any]:
    """The comparison as one JSON object; degrees and seconds, null for none."""
    return {
        "changes": [
            {
                "log": one.log,
                "filter": one.filter,
                **{
                    figure: {"before": one.before[figure], "after": one.after[figure], "change": one.of(figure)}
                    for figure in FIGURES
                },
            }
            for one in comparison.changes
        ],
        "only_before": comparison.only_before,
        "only_after": comparison.only_after,
        "other_size": comparison.other_size,
        "other_work": comparison.other_work,
        "not_compared": comparison.unread,
        "limits": [one.as_json() for one in checked],
    }


def print_comparison(comparison: ResultsComparison, rows: int) -> None:
    """Print the worst rows, and remarks on the logs that differ otherwise."""
    labels = ("tilt\nrms deg", "heading\nrms deg", "DISAGREE\ns", "undecided\ns")
    table = TextTable(words("after less before,\nthe worst first"), words("filter"), *figures(*labels))
    for one in comparison.changes[:rows]:
        table.add_row(click.format_filename(PurePath(one.log).name), one.filter, *_cells(one))
    if len(comparison.changes) > rows:
        table.caption = f"{rows} of {len(comparison.changes)} rows; --rows and --json show more"
    click.echo(table.text(screen_width()), nl=False)
    for remark in _remarks(comparison):
        click.echo(f"  {remark}")


def _cells(change: Change) -> list[str]:
    decimals = {"tilt_rms_deg": 3, "heading_rms_deg": 3, "disagree_s": 1, "undecided_s": 1}
    values = [(change.of(figure), decimals[figure]) for figure in FIGURES]
    return ["-" if value is None else "0" if value == 0.0 else f"{value:+.{digits}f}" for value, digits in values]


def _remarks(comparison: ResultsComparison) -> list[str]:
    kinds = {
        "only in BEFORE": comparison.only_before,
        "only in AFTER": comparison.only_after,
        "another file size": comparison.other_size,
        "another version or configuration": comparison.other_work,
        "unreadable, or no filter in common": comparison.unread,
    }
    return [f"{len(logs)} logs: {kind}: {_named(logs)}" for kind, logs in kinds.items() if logs]


def _named(logs: list[str]) -> str:
    names = [click.format_filename(PurePath(log).name) for log in logs[:SHOWN]]
    return ", ".join([*names, *(["..."] if len(logs) > SHOWN else [])])
