"""``attest-mav watch``: a running daemon in the terminal, until Ctrl-C."""

import os
import sys
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import click

from attest_mav.cli.daemon_address import at_option
from attest_mav.cli.state_text import headline, remarks, sections, verdict_line
from attest_mav.cli.text_table import folded
from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError
from attest_mav.runtime.web.fetch import fetch_status

if TYPE_CHECKING:
    from rich.text import Text

PERIOD_S: Final = 0.5
STYLES: Final = {
    "agree": "bold black on green",
    "undecided": "bold black on yellow",
    "disagree": "bold white on red",
}
"""Of the verdict, by agreement; readable on dark and on light terminals."""


@click.command("watch")
@at_option
@click.option("--looks", type=click.IntRange(min=1), help="End after so many looks, two a second; default: never.")
def command(at: LinkUrl, looks: int | None) -> None:
    """Show the state of a running daemon, twice a second, until Ctrl-C.

    In a pipe, and on a terminal without a cursor (TERM=dumb), each change of state, verdict or remarks is one line. A
    daemon that is gone is waited for; the exit code is 69 where none answers at the start.
    """
    state = fetch_status(at)
    if sys.stdout.isatty() and os.environ.get("TERM") != "dumb":
        _on_terminal(at, state, looks)
    else:
        _in_pipe(at, state, looks)


def _on_terminal(at: LinkUrl, state: dict[str, Any], looks: int | None) -> None:
    from rich.console import Console  # noqa: PLC0415  (imported when shown)
    from rich.live import Live  # noqa: PLC0415

    console = Console(markup=False, highlight=False, emoji=False)
    clock = ""
    with Live(console=console, auto_refresh=False, screen=True) as live:
        for newest, complaint in _looks(at, state, looks):
            clock = clock if complaint else time.strftime("%H:%M:%S")
            banner = f"{complaint}; this was its last state, at {clock}" if complaint else ""
            footer = f"{at.host}:{at.port} at {clock}; Ctrl-C ends"
            live.update(_view(newest, banner, footer, console.size), refresh=True)


def _in_pipe(at: LinkUrl, state: dict[str, Any], looks: int | None) -> None:
    """One line for each change: what changes by itself all the time makes none."""
    shown: object = None
    for now, complaint in _looks(at, state, looks):
        verdict = now["verdict"] or {}
        key = complaint or (headline(now), verdict.get("agreement"), verdict.get("reason"), len(remarks(now)))
        if key != shown:
            shown = key
            click.echo(complaint or " | ".join([headline(now), verdict_line(now), *remarks(now)]))


def _looks(at: LinkUrl, state: dict[str, Any], looks: int | None) -> Iterator[tuple[dict[str, Any], str]]:
    """The state as it becomes, with a complaint while no daemon answers; the one given is the first."""
    complaint = ""
    count = 0
    while True:
        yield state, complaint
        count += 1
        if looks is not None and count >= looks:
            return
        time.sleep(PERIOD_S)
        try:
            state, complaint = fetch_status(at), ""
        except LinkError:
            complaint = f"the daemon at {at.host}:{at.port} is gone"


def _view(state: dict[str, Any], banner: str, footer: str, size: tuple[int, int]) -> "Text":
    """The state in lines that fit the terminal. banner: above it, "" for none. size: columns and lines."""
    from rich.text import Text  # noqa: PLC0415  (imported when shown)

    columns, height = size
    lines = _styled_lines(state, is_old=bool(banner))
    lines = [(banner, "bold white on red"), *lines] if banner else lines
    rows = [(row, style) for text, style in lines for row in folded(text, columns, hanging="    ").split("\n")]
    hidden = max(0, len(rows) + 1 - height)
    shown = rows[: len(rows) - hidden]
    last = f"{hidden} lines more in a taller window; {footer}" if hidden else footer
    return Text("\n").join(Text(text, style) for text, style in [*shown, (last[:columns], "dim")])


def _styled_lines(state: dict[str, Any], *, is_old: bool) -> list[tuple[str, str]]:
    """All lines with their styles. is_old: nothing of it is live."""
    verdict = state["verdict"]
    lines: list[tuple[str, str]] = []
    for place, section in enumerate(sections(state)):
        is_verdict = place == 1
        title = STYLES[verdict["agreement"] if verdict else "undecided"] if is_verdict and not is_old else "bold"
        lines.append((section.title, title))
        lines += [(f"  {one.text}", "dim" if is_old else "red" if one.is_bad else "") for one in section.lines]
    return lines
