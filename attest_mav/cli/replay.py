"""``attest-mav replay``: filters over recorded flights, compared with a reference."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from io import TextIOWrapper
from itertools import combinations
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
from attest_mav.replay.junit import LogResult, junit_xml
from attest_mav.replay.limits import LIMITED, Checked, Limit, check, parse_limit
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
@click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="NAME=VALUE",
    help=f"Exit with 1 where a figure is larger; of {', '.join(LIMITED)}. May be given several times.",
)
@click.option("--junit", "junit_path", metavar="FILE", help="Write the outcome of each log and limit as JUnit's XML.")
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
    limits: tuple[str, ...],
    junit_path: str | None,
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
    _check_outputs(logs, {"--csv": csv_path, "--tlog": tlog_path, "--junit": junit_path})
    showing = _Showing(tuple(parse_limit(text) for text in limits), json_lines)
    window = _window(start_s, end_s, skip_s)
    request = Request(_filters(filters), imu, reference, declination_deg, window, _vehicle(vehicle))
    results: list[LogResult] = []
    with ExitStack() as stack:
        table = None if csv_path is None else stack.enter_context(_csv_table(csv_path))
        annotated = None if tlog_path is None else stack.enter_context(atomic_write(tlog_path))
        stack.enter_context(_junit(junit_path, results))
        exit_code = _replay_all(logs, _Work(request, table, annotated), showing, results)
        if all(one.error for one in results):
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


@dataclass(frozen=True)
class _Showing:
    """The way in which the report on a log is shown, and the limits that are held against it."""

    limits: tuple[Limit, ...]
    json_lines: bool

    def __call__(self, report: Report) -> list[Checked]:
        """Print the report with its limits; the limits as they came out."""
        checked = check(report, self.limits)
        if self.json_lines:
            click.echo(json.dumps({**report, "limits": [one.as_json() for one in checked]}, allow_nan=False))
            return checked
        # Costs 100 ms, which a script that reads JSON does not need.
        from attest_mav.cli.replay_table import print_report  # noqa: PLC0415

        print_report(report)
        for one in checked:
            click.echo(f"  limit {'kept  ' if one.passes else 'MISSED'} {one}")
        return checked


def _replay_all(logs: tuple[str, ...], work: _Work, show: _Showing, results: list[LogResult]) -> int:
    """Print the outcome of every log: the exit code of the last failure, else 1 for a limit that was missed."""
    exit_code = 0
    for outcome in replay_files(logs, work):
        if outcome.error is not None:
            click.echo(f"attest-mav: error: {outcome.error}", err=True)
            exit_code = outcome.error.exit_code
            results.append(LogResult(outcome.path, error=str(outcome.error)))
        elif outcome.report is not None:
            results.append(LogResult(outcome.path, show(outcome.report)))
    is_missed = any(not one.passes for result in results for one in result.checked)
    return exit_code or int(is_missed)


@contextmanager
def _junit(path: str | None, results: list[LogResult]) -> Iterator[None]:
    """Write the results in the end, where a path is given; also if no log could be read."""
    try:
        yield
    finally:
        if path is not None and results:
            with atomic_write(path) as file:
                file.write(junit_xml(results))


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


def _check_outputs(logs: tuple[str, ...], outputs: dict[str, str | None]) -> None:
    """Refuse outputs (paths by option) that would replace an input or each other."""
    if outputs["--tlog"] is not None and len(logs) > 1:
        raise UsageError("--tlog takes one LOG: an annotated log cannot hold several")
    paths = {option: Path(path) for option, path in outputs.items() if path is not None}
    for option, output in paths.items():
        for name in logs:
            if _is_same_file(output, Path(name)):
                raise UsageError(f"{option} {output} would replace the log it is made from")
    for (one, first), (other, second) in combinations(paths.items(), 2):
        if first.resolve() == second.resolve():
            raise UsageError(f"{one} and {other} are both {first}: expected two files")


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
