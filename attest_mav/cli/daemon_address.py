"""The option ``--at``: the address of a running daemon."""

from typing import Final

import click

from attest_mav.config.link_url import LinkUrl
from attest_mav.config.parsing import web_address
from attest_mav.errors import ConfigError, UsageError

DEFAULT: Final = "127.0.0.1:8484"
"""The address that the documentation uses."""


def _address(_context: click.Context, _parameter: click.Parameter, text: str) -> LinkUrl:
    try:
        return web_address(text, "--at")
    except ConfigError as error:
        raise UsageError(str(error)) from None


at_option = click.option(
    "--at",
    metavar="HOST:PORT",
    default=DEFAULT,
    show_default=True,
    callback=_address,
    help="Address of the daemon, its web.listen.",
)
