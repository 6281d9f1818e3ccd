"""``attest-mav config``: check a configuration, or show the effective one."""

import os
from collections.abc import Sequence
from pathlib import Path

import click

from attest_mav.config.layers import (
    DEFAULT,
    Layer,
    Layered,
    command_line_layer,
    environment_layers,
    file_layer,
    layered,
)
from attest_mav.config.parsing import parse_config
from attest_mav.config.records import Config
from attest_mav.config.remarks import remarks
from attest_mav.config.text import printable, to_toml
from attest_mav.errors import ConfigError, UsageError
from attest_mav.filters.own import search_here
from attest_mav.installation.unit_folders import unit_remarks
from attest_mav.runtime.files import drop_ins, read_config
from attest_mav.service.assembly import check_simulations, check_unsigned_messages

set_option = click.option(
    "--set", "changes", metavar="KEY=VALUE", multiple=True, help="A value, instead of the configuration's."
)


@click.group("config")
def command() -> None:
    """Check a configuration file, or show the effective one."""


@command.command("check")
@click.argument("file")
@set_option
def check(file: str, changes: tuple[str, ...]) -> None:
    """Say whether FILE is a valid configuration; exit code 78 if it is not.

    Its drop-ins and the environment count as they do for `run`. Warnings leave the exit code 0.
    """
    found = load_layered(file, changes)
    if not found.config.link:
        raise ConfigError(f"{file}: no link: write a [[link]] with a url, such as serial:/dev/ttyAMA0:921600")
    path = Path(file).absolute()
    for text in (*remarks(found.config, found.origins), *unit_remarks(found.config, path)):
        click.echo(f"{printable(file)}: warning: {printable(text)}", err=True)
    links = ", ".join(link.url for link in found.config.link)
    click.echo(f"{printable(file)}: valid; links: {links}; filter: {found.config.filter.chosen}")


@command.command("show")
@click.argument("file", required=False)
@set_option
def show(file: str | None, changes: tuple[str, ...]) -> None:
    """Print the whole configuration that FILE makes, with the origin of each value; without FILE, the defaults.

    Later ones win: FILE, its drop-ins in NAME.conf.d, variables such as ATTEST_MAV__OUTPUT__RATE_HZ, --set.
    """
    found = load_layered(file, changes)
    click.echo(to_toml(found.config, lambda name: found.origins.get(name, DEFAULT)), nl=False)


def load_layered(file: str | None, changes: Sequence[str] = ()) -> Layered:
    """The configuration that `run` uses: file, its drop-ins, environment and ``--set``; ConfigError names the key."""
    layers: list[Layer] = []
    if file is not None:
        layers += [file_layer(read_config(path), path) for path in (file, *map(str, drop_ins(file)))]
    layers += environment_layers(os.environ)
    if changes:
        layers.append(command_line_layer(changes))
    found = layered(layers)
    _check_names(found.config, file or DEFAULT)
    return found


def load(file: str | None, changes: Sequence[str] = ()) -> Config:
    """The configuration of a replay: a file, or the defaults without one, with changes of ``--set``.

    ConfigError names the key that is wrong.
    """
    if file is None and not changes:
        return Config()
    text = "" if file is None else read_config(file)
    name = " and ".join([*([] if file is None else [file]), *(["--set"] if changes else [])])
    config = parse_config(text, name, changes)
    _check_names(config, name)
    return config


def _check_names(config: Config, name: str) -> None:
    """ConfigError for a simulation or a message that does not exist."""
    check_simulations(config, name)
    check_unsigned_messages(config, name)
    _check_own_filter(config, name)


def _check_own_filter(config: Config, name: str) -> None:
    """ConfigError for a filter of one's own that cannot be made."""
    if config.filter.name != "own":
        return
    search_here(str(Path.cwd()))
    try:
        config.filter.build()
    except UsageError as error:
        raise ConfigError(f"{name}: filter.own: {error}") from None
