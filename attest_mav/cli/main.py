"""``attest-mav``: the command group. Each command lives in a module of its own and is imported when it is used."""

import atexit
import errno
import gc
import sys
from importlib import import_module
from typing import Final

import click

from attest_mav.cli.collector import seldom_collected
from attest_mav.cli.version import version_text
from attest_mav.errors import AttestMavError, UnwritableError
from attest_mav.runtime.files import give_up_stdout

COMMANDS: Final = {
    "run": "The daemon: inertial messages in, ATTITUDE_QUATERNION and a verdict out.",
    "replay": "Run filters over logs and compare them with a reference.",
    "evaluate": "Reproduce the papers' scenarios and check them against their bounds.",
    "sim": "The fake autopilot as a process of its own.",
    "compare": "Compare two files of results that replay has kept.",
    "tune": "Search parameters of a filter on logs, and check them on others.",
    "play": "Send a recorded flight on a link, like a live vehicle.",
    "status": "One look at a running daemon.",
    "watch": "A running daemon in the terminal.",
    "config": "Check a configuration file, or show the effective one.",
    "service": "Put the systemd service in place, or take it away.",
}
"""Each is the ``command`` of the module of the same name; the help is here so that listing them imports none."""

READER_LEFT: Final = 141
INTERRUPTED: Final = 130
"""A shell's exit codes for SIGPIPE and SIGINT: the reader of a pipe left, or Ctrl-C."""
FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Errors that come only from standard output here: files and links raise errors of their own."""


class LazyGroup(click.Group):
    """A group that imports a command's module only when the command is called: start-up stays short."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """All names, in the order in which they are shown."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name, or None."""
        if cmd_name not in COMMANDS:
            return None
        with seldom_collected():
            command = import_module(f"attest_mav.cli.{cmd_name}").command
        if not isinstance(command, click.Command):
            raise TypeError(f"attest_mav.cli.{cmd_name}.command is not a click command")
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands in --help without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


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
    """Entry point: errors meant for the user become one line and their exit code.

    click's own ``main`` is not used: it ends with 1 when a reader leaves or the user interrupts, which means something
    else here.
    """
    try:
        code = run(sys.argv[1:])
    except BrokenPipeError:
        give_up_stdout()
        code = READER_LEFT
    except KeyboardInterrupt:
        code = INTERRUPTED
    except AttestMavError as error:
        code = report(error)
    except OSError as error:
        if error.errno not in FULL:
            raise
        give_up_stdout()
        code = report(UnwritableError(f"cannot write standard output: {error.strerror}"))
    atexit.register(gc.freeze)  # what is left goes with the process: no search for cycles in it
    sys.exit(code)


def run(arguments: list[str]) -> int:
    """Run the command; its exit code."""
    try:
        with group.make_context("attest-mav", arguments) as ctx:
            group.invoke(ctx)
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.ClickException as error:
        error.show()
        return error.exit_code
    return 0


def report(error: AttestMavError) -> int:
    """Print the error in one line; the exit code."""
    from attest_mav.config.text import printable  # noqa: PLC0415 (costs 15 ms)

    click.echo(f"attest-mav: error: {printable(str(error))}", err=True)
    return error.exit_code
