"""``attest-mav service``: put the systemd unit in place, or take it away."""

import os
from pathlib import Path

import click

from attest_mav.cli.config import load_layered
from attest_mav.config.text import printable
from attest_mav.errors import ConfigError, UsageError
from attest_mav.installation.machine import below, program_path, systemd_version
from attest_mav.installation.machine import install as install_files
from attest_mav.installation.machine import uninstall as uninstall_files
from attest_mav.installation.plan import CONFIGURATION, FIRST_NOTIFY_RELOAD, planned_files
from attest_mav.installation.unit_folders import unit_remarks

START = """\
Next:
  sudo systemd-sysusers && sudo systemctl daemon-reload
  sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=tty
  sudo editor {configuration}
  {program} config check {configuration}
  sudo systemctl enable --now attest-mav
A further vehicle: /etc/attest-mav/NAME.toml, and sudo systemctl enable --now attest-mav@NAME"""
END = """\
Next:
  sudo systemctl stop attest-mav "attest-mav@*"
  sudo systemctl daemon-reload && sudo udevadm control --reload
  sudo userdel attest-mav"""

prefix_option = click.option(
    "--prefix", metavar="DIR", default="/", help="Work below this folder instead of /; needs no root there."
)
dry_run_option = click.option("--dry-run", is_flag=True, help="Say what would be done, and do nothing.")


@click.group("service")
def command() -> None:
    """Put the systemd service in place, or take it away."""


@command.command("install")
@prefix_option
@dry_run_option
@click.option(
    "--example",
    metavar="NAME",
    default="ardupilot-serial",
    show_default=True,
    help="The configuration to begin with, where there is none yet.",
)
def install(prefix: str, dry_run: bool, example: str) -> None:
    """Write units, user, udev rule and a first configuration, for the program that runs this.

    A configuration that is there already is never overwritten.
    """
    _check_root(prefix, dry_run, "install")
    version = systemd_version()
    if version is None and prefix == "/":
        raise UsageError("systemctl was not found: this machine is not run by systemd; --prefix DIR writes elsewhere")
    program = program_path()
    for line in install_files(planned_files(program, version or FIRST_NOTIFY_RELOAD, example), Path(prefix), dry_run):
        click.echo(line)
    _warn(Path(prefix))
    click.echo(START.format(configuration=CONFIGURATION, program=program))


@command.command("uninstall")
@prefix_option
@dry_run_option
@click.option(
    "--purge",
    is_flag=True,
    help="Remove configuration, state and drop-ins too.",
)
def uninstall(prefix: str, dry_run: bool, purge: bool) -> None:
    """Remove what `service install` has written.

    A configuration that was changed, the state, and what was added beside them stay, and are named.
    """
    _check_root(prefix, dry_run, "uninstall")
    for line in uninstall_files(Path(prefix), purge, dry_run):
        click.echo(line)
    click.echo(END)


def _warn(prefix: Path) -> None:
    """Warn of the configurations that are there: an error in one, or a folder that its unit cannot write into."""
    for file in sorted(below(prefix, CONFIGURATION).parent.glob("*.toml")):
        try:
            config = load_layered(str(file)).config
        except ConfigError as error:
            click.echo(f"warning: {printable(str(error))}", err=True)
            continue
        for text in unit_remarks(config, Path(CONFIGURATION).with_name(file.name), prefix):
            click.echo(f"{printable(str(file))}: warning: {printable(text)}", err=True)


def _check_root(prefix: str, dry_run: bool, name: str) -> None:
    """UsageError for somebody who may not write to the system's folders."""
    if prefix == "/" and not dry_run and os.geteuid() != 0:
        raise UsageError(
            f"root's folders are written: sudo {program_path()} service {name}; --dry-run only says what would be done"
        )
