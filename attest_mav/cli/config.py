"""``attest-mav config``: check a configuration, or show the effective one."""

import click

from attest_mav.config.records import Config, parse_config
from attest_mav.config.text import to_toml
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


def load(file: str | None) -> Config:
    """The configuration in a file, or the defaults without one; ConfigError names the key that is wrong."""
    if file is None:
        return Config()
    config = parse_config(read_config(file), file)
    check_simulations(config, file)
    check_unsigned_messages(config, file)
    return config
