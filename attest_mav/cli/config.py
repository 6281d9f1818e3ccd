"""``attest-mav config``: check a configuration, or show the effective one."""

from collections.abc import Sequence
from pathlib import Path

import click

from attest_mav.config.records import Config, parse_config
from attest_mav.config.text import to_toml
from attest_mav.errors import ConfigError, UsageError
from attest_mav.filters.own import search_here
from attest_mav.runtime.files import read_config
from attest_mav.service.assembly import check_simulations, check_unsigned_messages


@click.group("config")
def command() -> None:
    """Check a configuration file, or show the effective one."""


@command.command("check")
@click.argument("file")
def check(file: str) -> None:
    """Say whether FILE is a valid configuration; exit code 78 if it is not."""
    config = load(file)
    links = ", ".join(link.url for link in config.link) or "none (give --link)"
    click.echo(f"{file}: valid; links: {links}; filter: {config.filter.chosen}")


@command.command("show")
@click.argument("file", required=False)
def show(file: str | None) -> None:
    """Print the whole configuration that FILE makes, defaults included; without FILE, the defaults."""
    click.echo(to_toml(load(file)), nl=False)


def load(file: str | None, changes: Sequence[str] = ()) -> Config:
    """The configuration in a file, or the defaults without one, with changes of ``--set``.

    ConfigError names the key that is wrong.
    """
    if file is None and not changes:
        return Config()
    text = "" if file is None else read_config(file)
    name = " and ".join([*([] if file is None else [file]), *(["--set"] if changes else [])])
    config = parse_config(text, name, changes)
    check_simulations(config, name)
    check_unsigned_messages(config, name)
    _check_own_filter(config, name)
    return config


def _check_own_filter(config: Config, name: str) -> None:
    """ConfigError for a filter of one's own that cannot be made."""
    if config.filter.name != "own":
        return
    search_here(str(Path.cwd()))
    try:
        config.filter.build()
    except UsageError as error:
        raise ConfigError(f"{name}: filter.own: {error}") from None
