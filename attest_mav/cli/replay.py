"""``attest-mav replay``: filters over recorded flights, compared with a reference."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from io import TextIOWrapper
from math import inf
from pathlib import Path
from typing import IO, Final

import click

from attest_mav.cli.progress import ProgressBar
from attest_mav.errors import UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.registry import default_filter, filter_names
from attest_mav.logs.formats import inertial_names, reference_names
from attest_mav.replay.batch import Report, replay_file, replay_files
from attest_mav.replay.csv_table import CsvTable
from attest_mav.replay.plan import VehicleChoice, check_names
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.runtime.files import atomic_write, open_log

AUTO: Final = "auto"
LARGEST_ID: Final = 255
"""Of a MAVLink system or component."""


@click.command("replay")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option(
    "--filter",
    "filters",
    default=AUTO,
    show_default=True,
    metavar="A,B",
    help=f"Filters to run, of {', '.join(filter_names())}; {AUTO}: velocity-aided, whether or not there is a velocity.",
)
@click.option("--imu", metavar="MESSAGE", help=f"Inertial message to use, of {', '.join(inertial_names())}.")
@click.option("--reference", metavar="MESSAGE", help=f"What to compare with, of {', '.join(reference_names())}.")
@click.option(
    "--vehicle",
    metavar="SYSTEM[/COMPONENT]",
    help="Vehicle to read where a log has several; the one with most inertial messages if not given.",
)
@click.option(
    "--skip", "skip_s", default=30.0, show_default=True, metavar="SECONDS", help="Not counted: so long after alignment."
)
@click.option("--start", "start_s", default=0.0, metavar="S", help="Read from S seconds after the first sample.")
@click.option("--end", "end_s", default=inf, metavar="S", help="Read until S seconds after the first sample.")
@click.option("--csv", "csv_path", metavar="FILE", help="Write every attitude with its errors.")
@click.option("--tlog", "tlog_path", metavar="FILE", help="Write the log with the first filter's attitudes inserted.")
@click.option("--json", "json_lines", is_flag=True, help="Print one JSON object a log, one a line.")
@click.option(
    "--declination",
    "declination_deg",
    type=float,
    metavar="DEG",
    help="East positive; looked up by the log's position and date if not given.",
)
def command(
    logs: tuple[str, ...],
    filters: str,
    imu: str | None,
    reference: str | None,
    vehicle: str | None,
    skip_s: float,
    start_s: float,
    end_s: float,
    csv_path: str | None,
    tlog_path: str | None,
    json_lines: bool,
    declination_deg: float | None,
) -> None:
    """Run filters over LOGs and compare them, and the autopilot's own attitude, with a reference.

    LOG is a telemetry log (tlog) or a bare MAVLink stream. Messages that are not named are chosen: the best inertial
    message, and a simulator's truth as reference where there is one. Errors are in degrees: the angle between the
    gravity directions (tilt), and what is left (heading).
    """
    check_names(imu, reference)
    _check_declination(declination_deg)
    _check_outputs(logs, csv_path, tlog_path)
    window = _window(start_s, end_s, skip_s)
    request = Request(_filters(filters), imu, reference, declination_deg, window, _vehicle(vehicle))
    with ExitStack() as stack:
        table = None if csv_path is None else stack.enter_context(_csv_table(csv_path))
        annotated = None if tlog_path is None else stack.enter_context(atomic_write(tlog_path))
        exit_code, done = _replay_all(logs, _Work(request, table, annotated), json_lines)
        if not done:
            # Leaving the block by an exception, so that no output file appears.
            click.get_current_context().exit(exit_code)
    click.get_current_context().exit(exit_code)


@dataclass(frozen=True)
class _Work:
    """The work on each log, with a progress bar and the files that are written beside the report."""

    request: Request
    table: CsvTable | None
    annotated: IO[bytes] | None

    def __call__(self, path: str) -> Report:
        attitudes = None if self.table is None else self.table.rows_of(path)
        with ProgressBar(path) as bar:
            return replay_file(path, self.request, open_log, Outputs(attitudes, self.annotated, bar.show))


def _replay_all(logs: tuple[str, ...], work: _Work, json_lines: bool) -> tuple[int, int]:
    """Print the outcome of every log: the last failure's exit code, and the number of logs without one."""
    exit_code = done = 0
    for outcome in replay_files(logs, work):
        if outcome.error is not None:
            click.echo(f"attest-mav: error: {outcome.error}", err=True)
            exit_code = outcome.error.exit_code
        elif outcome.report is not None:
            done += 1
            _show(outcome.report, json_lines)
    return exit_code, done


def _show(report: Report, json_lines: bool) -> None:
    if json_lines:
        click.echo(json.dumps(report, allow_nan=False))
        return
    # Costs 100 ms, which a script that reads JSON does not need.
    from attest_mav.cli.replay_table import print_report  # noqa: PLC0415

    print_report(report)


def _filters(text: str) -> tuple[AttitudeFilter, ...]:
    """The filters of a list of names with commas; none for ``AUTO``."""
    names = [name.strip() for name in text.split(",")]
    if names == [AUTO]:
        return ()
    if AUTO in names:
        raise UsageError(f"--filter {text}: {AUTO} stands alone; expected it, or names of filters")
    if len(set(names)) < len(names):
        raise UsageError(f"--filter {text}: a filter is named twice")
    return tuple(default_filter(name) for name in names)


def _vehicle(text: str | None) -> VehicleChoice | None:
    """The vehicle of ``SYSTEM`` or ``SYSTEM/COMPONENT``."""
    if text is None:
        return None
    system, slash, component = text.partition("/")
    numbers = [system, component] if slash else [system]
    if not all(number.isdecimal() and int(number) <= LARGEST_ID for number in numbers):
        raise UsageError(f"--vehicle {text}: expected SYSTEM or SYSTEM/COMPONENT, numbers from 0 to {LARGEST_ID}")
    return int(system), int(component) if slash else None


def _window(start_s: float, end_s: float, skip_s: float) -> Window:
    """The part of the log to read; UsageError for values that make no sense."""
    for option, value in (("--start", start_s), ("--skip", skip_s)):
        if not 0.0 <= value < inf:
            raise UsageError(f"{option} {value:g}: expected seconds, 0 or more")
    if not end_s > start_s:
        raise UsageError(f"--end {end_s:g}: expected more than --start, which is {start_s:g} s")
    return Window(start_s, end_s, skip_s)


def _check_declination(declination_deg: float | None) -> None:
    if declination_deg is not None and not -180.0 <= declination_deg <= 180.0:
        raise UsageError(f"--declination {declination_deg:g}: expected degrees from -180 to 180, east positive")


def _check_outputs(logs: tuple[str, ...], csv_path: str | None, tlog_path: str | None) -> None:
    """Refuse outputs that would replace an input or each other."""
    if tlog_path is not None and len(logs) > 1:
        raise UsageError("--tlog takes one LOG: an annotated log cannot hold several")
    outputs = {option: Path(path) for option, path in (("--csv", csv_path), ("--tlog", tlog_path)) if path is not None}
    for option, output in outputs.items():
        for name in logs:
            if _is_same_file(output, Path(name)):
                raise UsageError(f"{option} {output} would replace the log it is made from")
    if len(outputs) == 2 and outputs["--csv"].resolve() == outputs["--tlog"].resolve():
        raise UsageError(f"--csv and --tlog are both {csv_path}: expected two files")


def _is_same_file(one: Path, other: Path) -> bool:
    return one.resolve() == other.resolve() or (one.is_file() and other.is_file() and one.samefile(other))


@contextmanager
def _csv_table(path: str) -> Iterator[CsvTable]:
    """A table in a file that appears when all of its rows are written."""
    with atomic_write(path) as file:
        # The name of a log need not be text; its bytes come out as they are.
        text = TextIOWrapper(file, encoding="utf-8", errors="surrogateescape", newline="")
        yield CsvTable(text)
        text.detach()
