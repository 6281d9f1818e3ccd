"""``attest-mav``: the command group. Each command lives in a module of its own and is imported when it is used."""

import sys
from importlib import import_module
from typing import Final

import click

import attest_mav.algebra
from attest_mav.errors import AttestMavError

COMMANDS: Final = {
    "run": "The daemon: inertial messages in, ATTITUDE_QUATERNION and a verdict out.",
    "replay": "Run filters over logs and compare them with a reference.",
    "evaluate": "Reproduce the papers' scenarios and check them against their bounds.",
    "sim": "The fake autopilot as a process of its own.",
    "config": "Check a configuration file, or show the effective one.",
}
"""Each is the ``command`` of the module of the same name; the help is here so that listing them imports none."""


class LazyGroup(click.Group):
    """A group that imports a command's module only when the command is called: start-up stays short."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """All names, in the order in which they are shown."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name, or None."""
        if cmd_name not in COMMANDS:
            return None
        command = import_module(f"attest_mav.cli.{cmd_name}").command
        if not isinstance(command, click.Command):
            raise TypeError(f"attest_mav.cli.{cmd_name}.command is not a click command")
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands in --help without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


def build_kind() -> str:
    """``compiled`` when the core is machine code, else ``interpreted``."""
    origin = attest_mav.algebra.__file__ or ""
    return "interpreted" if origin.endswith(".py") else "compiled"


def version_text() -> str:
    """Version and build kind, as ``--version`` prints them."""
    from importlib import metadata  # noqa: PLC0415  (40 ms that no other command needs)

    return f"attest-mav {metadata.version('attest-mav')} ({build_kind()})"


def show_version(ctx: click.Context, _parameter: click.Parameter, wanted: bool) -> None:
    """Print the version and end, for ``--version``."""
    if wanted and not ctx.resilient_parsing:
        click.echo(version_text())
        ctx.exit()


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=show_version, help="Show version.")
def group() -> None:
    """An independent attitude for any MAVLink vehicle, and a verdict on the autopilot's own."""


def main() -> None:
    """Entry point: errors meant for the user become one line and their exit code."""
    try:
        group(prog_name="attest-mav")
    except AttestMavError as error:
        click.echo(f"attest-mav: error: {error}", err=True)
        sys.exit(error.exit_code)
