"""The summary of many logs as a table for people."""

from collections.abc import Sequence
from pathlib import PurePath

import click
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from attest_mav.cli.replay_table import PIPE_COLUMNS
from attest_mav.replay.summary import SummaryRow


def print_summary(rows: Sequence[SummaryRow]) -> None:
    """Print a row a log on standard output, and the number of those that could not be read."""
    console = Console(markup=False, highlight=False, emoji=False)
    if not console.is_terminal:
        console = Console(markup=False, highlight=False, emoji=False, width=PIPE_COLUMNS)
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column(f"{len(rows)} logs,\nthe worst first", overflow="fold")
    for label in ("DISAGREE\ns", "undecided\ns", "largest\ntilt", "our tilt\nrms"):
        table.add_column(label, justify="right", no_wrap=True)
    for row in rows:
        if not row.error:
            figures = (row.disagree_s, row.undecided_s, row.autopilot_tilt, row.tilt_rms)
            name = click.format_filename(PurePath(row.log).name)
            table.add_row(name, *("-" if one is None else f"{one:.1f}" for one in figures))
    with console.capture() as capture:
        console.print(table)
        unread = sum([bool(row.error) for row in rows])
        if unread:
            console.print(f"  {unread} of {len(rows)} logs could not be read; the errors say why", soft_wrap=True)
    click.echo(capture.get(), nl=False)
