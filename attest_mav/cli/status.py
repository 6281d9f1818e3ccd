"""``attest-mav status``: one look at a running daemon."""

import json

import click

from attest_mav.cli.daemon_address import at_option
from attest_mav.cli.state_text import plain_text
from attest_mav.config.link_url import LinkUrl
from attest_mav.runtime.web.fetch import fetch_status


@click.command("status")
@at_option
@click.option("--json", "as_json", is_flag=True, help="The whole state as JSON, as under /status.")
def command(at: LinkUrl, as_json: bool) -> None:
    """Print the state of a running daemon: its verdict, attitudes, sensors and links.

    The daemon must serve its state (`web.listen` in the configuration). The exit code is 69 where none answers, else 0,
    whatever the verdict is.
    """
    state = fetch_status(at)
    click.echo(json.dumps(state, indent=2) if as_json else plain_text(state))
