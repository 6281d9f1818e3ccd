"""``attest-mav watch``: a running daemon in the terminal, until Ctrl-C."""

import sys
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import click

from attest_mav.cli.daemon_address import at_option
from attest_mav.cli.state_text import headline, remarks, sections, verdict_line
from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError
from attest_mav.runtime.web.fetch import fetch_status

if TYPE_CHECKING:
    from rich.console import RenderableType

PERIOD_S: Final = 0.5
STYLES: Final = {"agree": "green", "undecided": "yellow", "disagree": "bold red"}


@click.command("watch")
@at_option
@click.option("--looks", type=click.IntRange(min=1), help="End after so many looks, two a second; default: never.")
def command(at: LinkUrl, looks: int | None) -> None:
    """Show the state of a running daemon, twice a second, until Ctrl-C.

    In a pipe each change of state, verdict or remarks is one line. A daemon that is gone is waited for; the exit code
    is 69 where none answers at the start.
    """
    state = fetch_status(at)
    if sys.stdout.isatty():
        _on_terminal(at, state, looks)
    else:
        _in_pipe(at, state, looks)


def _on_terminal(at: LinkUrl, state: dict[str, Any], looks: int | None) -> None:
    from rich.console import Console  # noqa: PLC0415  (imported when shown)
    from rich.live import Live  # noqa: PLC0415

    console = Console(markup=False, highlight=False, emoji=False)
    with Live(_view(state, ""), console=console, auto_refresh=False, screen=True) as live:
        for newest, complaint in _looks(at, state, looks):
            live.update(_view(newest, complaint), refresh=True)


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


def _view(state: dict[str, Any], complaint: str) -> "RenderableType":
    from rich.text import Text  # noqa: PLC0415  (imported when shown)

    text = Text()
    if complaint:
        text.append(f"{complaint}; this was its last state\n", style="bold white on red")
    verdict = state["verdict"]
    style = STYLES[verdict["agreement"]] if verdict else "yellow"
    for title, lines in sections(state):
        text.append(f"{title}\n", style=f"bold {style}" if title == verdict_line(state) else "bold")
        for line in lines:
            text.append(f"  {line}\n", style="dim" if complaint else "")
    return text
