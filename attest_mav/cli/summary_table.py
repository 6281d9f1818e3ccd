"""The summary of many logs as a table for people."""

from collections.abc import Sequence
from pathlib import PurePath

import click

from attest_mav.cli.text_table import TextTable, figures, screen_width, words
from attest_mav.replay.summary import SummaryRow


def print_summary(rows: Sequence[SummaryRow]) -> None:
    """Print a row a log on standard output, and the number of those that could not be read."""
    labels = ("DISAGREE\ns", "undecided\ns", "largest\ntilt", "our tilt\nrms")
    table = TextTable(words(f"{len(rows)} logs,\nthe worst first"), *figures(*labels))
    for row in rows:
        if not row.error:
            values = (row.disagree_s, row.undecided_s, row.autopilot_tilt, row.tilt_rms)
            name = click.format_filename(PurePath(row.log).name)
            table.add_row(name, *("-" if one is None else f"{one:.1f}" for one in values))
    click.echo(table.text(screen_width()), nl=False)
    unread = sum([bool(row.error) for row in rows])
    if unread:
        click.echo(f"  {unread} of {len(rows)} logs could not be read; the errors say why")
