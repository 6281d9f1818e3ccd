"""``attest-mav replay``: filters over recorded flights, compared with a reference."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from io import TextIOWrapper
from math import inf
from pathlib import Path
from typing import Any, Final

import click

from attest_mav.cli.progress import ProgressBar
from attest_mav.errors import AttestMavError, UnreadableDataError, UnwritableError, UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.registry import default_filter, filter_names
from attest_mav.logs.detect import HEAD_BYTES, require_format
from attest_mav.logs.tlog.survey import IMU_MESSAGES, NAMED_REFERENCES
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.replay.engine import Outputs, Request, replay
from attest_mav.replay.flight import Window
from attest_mav.replay.plan import check_names
from attest_mav.replay.report import as_json
from attest_mav.replay.rows import RowWriter
from attest_mav.runtime.files import atomic_write, open_log

AUTO: Final = "auto"
FORMAT_NAMES: Final = {"dataflash": "a DataFlash log", "ulog": "a ULog"}


@click.command("replay")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option(
    "--filter",
    "filters",
    default=AUTO,
    show_default=True,
    metavar="A,B",
    help=f"Filters to run, of {', '.join(filter_names())}; {AUTO}: velocity-aided where the log has a velocity, else "
    "gradient-descent.",
)
@click.option("--imu", metavar="MESSAGE", help=f"Inertial message to use, of {', '.join(IMU_MESSAGES)}.")
@click.option("--reference", metavar="MESSAGE", help=f"What to compare with, of {', '.join(NAMED_REFERENCES)}.")
@click.option(
    "--skip", "skip_s", default=30.0, show_default=True, metavar="SECONDS", help="Not counted: so long after alignment."
)
@click.option("--start", "start_s", default=0.0, metavar="S", help="Read from S seconds after the first sample.")
@click.option("--end", "end_s", default=inf, metavar="S", help="Read until S seconds after the first sample.")
@click.option("--csv", "csv_path", metavar="FILE", help="Write every attitude with its errors.")
@click.option("--tlog", "tlog_path", metavar="FILE", help="Write the log with the first filter's attitudes woven in.")
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
    skip_s: float,
    start_s: float,
    end_s: float,
    csv_path: str | None,
    tlog_path: str | None,
    json_lines: bool,
    declination_deg: float | None,
) -> None:
    """Run filters over LOGs and compare them, and the autopilot's own attitude, with a reference.

    LOG is a telemetry log (tlog). Messages that are not named are chosen: the best inertial message, and a simulator's
    truth as reference where there is one. Errors are in degrees: the angle between the gravity directions (tilt), and
    what is left (heading).
    """
    check_names(imu, reference)
    _check_declination(declination_deg)
    _check_outputs(logs, csv_path, tlog_path)
    request = Request(_filters(filters), imu, reference, declination_deg, _window(start_s, end_s, skip_s))
    with ExitStack() as stack:
        rows = None if csv_path is None else stack.enter_context(_csv_rows(csv_path))
        woven = None if tlog_path is None else stack.enter_context(atomic_write(tlog_path))
        exit_code, done = _replay_all(logs, request, Outputs(rows, woven), json_lines)
        if not done:
            # Leaving the block by an exception, so that no output file appears.
            click.get_current_context().exit(exit_code)
    click.get_current_context().exit(exit_code)


def _replay_all(logs: tuple[str, ...], request: Request, outputs: Outputs, json_lines: bool) -> tuple[int, int]:
    """Replay every log, whatever happens to the others: the last failure's exit code, and how many succeeded."""
    dialect = load_dialect()
    exit_code = done = 0
    for name in logs:
        try:
            report = _replay_one(name, dialect, request, outputs)
        except UnwritableError:
            raise
        except AttestMavError as error:
            click.echo(f"attest-mav: error: {error}", err=True)
            exit_code = error.exit_code
            continue
        done += 1
        if json_lines:
            click.echo(json.dumps(report, allow_nan=False))
        else:
            # Costs 100 ms, which a script that reads JSON does not need.
            from attest_mav.cli.replay_table import print_report  # noqa: PLC0415

            print_report(report)
    return exit_code, done


def _replay_one(name: str, dialect: Dialect, request: Request, outputs: Outputs) -> dict[str, Any]:
    """The report on one log. Every error names the log."""
    with open_log(name) as mapped, ProgressBar(name) as bar:
        log_format = require_format(mapped[:HEAD_BYTES], name)
        if log_format != "tlog":
            raise UnreadableDataError(f"{name}: {FORMAT_NAMES[log_format]} cannot be read yet; expected a tlog")
        if isinstance(outputs.rows, RowWriter):
            outputs.rows.log = name
        try:
            result = replay(mapped, dialect, request, replace(outputs, progress=bar.show))
        except UnreadableDataError as error:
            raise UnreadableDataError(f"{name}: {error}") from None
        return as_json(name, log_format, result)


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


def _window(start_s: float, end_s: float, skip_s: float) -> Window:
    """The part of the log to read; UsageError when it cannot be meant."""
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
        raise UsageError("--tlog takes one LOG: a woven log cannot hold several")
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
def _csv_rows(path: str) -> Iterator[RowWriter]:
    """Rows into a file that appears when all of them are written."""
    with atomic_write(path) as file:
        # The name of a log need not be text; its bytes come out as they are.
        text = TextIOWrapper(file, encoding="utf-8", errors="surrogateescape", newline="")
        yield RowWriter(text)
        text.detach()
