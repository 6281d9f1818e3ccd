"""``attest-mav replay``: filters over recorded flights, compared with a reference."""

from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import replace
from functools import partial
from math import inf
from typing import TYPE_CHECKING

import click

from attest_mav.cli.calibration_file import calibration_output, read_calibrations
from attest_mav.cli.collector import seldom_collected
from attest_mav.cli.replay_options import (
    AUTO,
    check_cluster,
    check_declination,
    check_outputs,
    check_workers,
    configured,
    vehicle_of,
    window_of,
)
from attest_mav.cli.replay_work import MANY, Replayed, Showing, Work, junit_file, replay_here, report_file, resumed
from attest_mav.cli.smoothing import smoothed
from attest_mav.cli.version import version_text
from attest_mav.filters.registry import filter_names
from attest_mav.logs.formats import inertial_names, reference_names
from attest_mav.logs.source import SMOOTHED
from attest_mav.replay.limits import LIMITED, parse_limit
from attest_mav.replay.plan import check_names
from attest_mav.replay.request import Request
from attest_mav.runtime.files import atomic_write
from attest_mav.runtime.log_paths import log_paths

if TYPE_CHECKING:
    from attest_mav.cli.replay_tables import Tables


@click.command("replay")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option(
    "--filter",
    "filters",
    default=AUTO,
    show_default=True,
    metavar="A,B",
    help=f"Filters to run, of {', '.join(filter_names())}, or MODULE:CLASS; {AUTO}: velocity-aided.",
)
@click.option("--imu", metavar="MESSAGE", help=f"Inertial message to use, of {', '.join(inertial_names())}.")
@click.option(
    "--reference",
    metavar="MESSAGE",
    help=f"What to compare with, of {', '.join((*reference_names(), SMOOTHED))}; {SMOOTHED} is made of all readings "
    "of the flight, before and behind each instant.",
)
@click.option(
    "--smooth", "smooths", is_flag=True, help="Compare the smoothed attitude too, where the reference is another."
)
@click.option(
    "--vehicle",
    metavar="SYSTEM[/COMPONENT]",
    help="Vehicle to read where a log has several; the one with most inertial messages if not given.",
)
@click.option(
    "--config",
    "config_file",
    metavar="FILE",
    help="Configuration (TOML) with the parameters of filters, thresholds of the verdict and sources of the aids.",
)
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="A value, instead of the configuration's.")
@click.option(
    "--calibration",
    "calibration_path",
    metavar="FILE",
    help="Begin with the sensors' errors that earlier flights of the same vehicle have shown: a file of "
    "--save-calibration, or the state file of a service.",
)
@click.option(
    "--save-calibration",
    "saved_path",
    metavar="FILE",
    help="Write those errors as this flight has shown them, beside those of other sensors in --calibration.",
)
@click.option(
    "--skip", "skip_s", default=30.0, show_default=True, metavar="SECONDS", help="Not counted: so long after alignment."
)
@click.option("--start", "start_s", default=0.0, metavar="S", help="Read from S seconds after the first sample.")
@click.option("--end", "end_s", default=inf, metavar="S", help="Read until S seconds after the first sample.")
@click.option("--csv", "csv_path", metavar="FILE", help="Write every attitude with its errors.")
@click.option(
    "--parquet",
    "parquet_path",
    metavar="FILE",
    help="Write the same as a Parquet file, with types and units (needs the extra parquet).",
)
@click.option(
    "--tlog",
    "tlog_path",
    metavar="FILE",
    help="Write the log with the smoothed attitudes inserted, or without a smoother those of the first filter.",
)
@click.option(
    "--report", "report_path", metavar="FILE", help="Write one page (HTML) with charts and figures of the log."
)
@click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="NAME=VALUE",
    help=f"Exit with 1 where a figure is larger; of {', '.join(LIMITED)}. May be given several times.",
)
@click.option("--junit", "junit_path", metavar="FILE", help="Write the outcome of each log and limit as JUnit's XML.")
@click.option(
    "--workers",
    type=int,
    metavar="N",
    help="Processes for several logs; one a core if not given.",
)
@click.option(
    "--dask",
    "scheduler",
    metavar="ADDRESS",
    help="Replay on the Dask cluster whose scheduler is at ADDRESS, HOST:PORT (needs the extra cluster). The workers "
    "read the logs, and write parts of --csv and --parquet beside them, under the same paths as here.",
)
@click.option(
    "--results",
    "results_path",
    metavar="FILE",
    help="Keep the result of each log in FILE; logs that it has, unchanged and replayed alike, are not replayed again.",
)
@click.option(
    "--as-it-came",
    is_flag=True,
    help="Filters know settings and magnetic field only from when the log tells them, as the daemon in flight.",
)
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
    smooths: bool,
    vehicle: str | None,
    config_file: str | None,
    changes: tuple[str, ...],
    calibration_path: str | None,
    saved_path: str | None,
    skip_s: float,
    start_s: float,
    end_s: float,
    csv_path: str | None,
    parquet_path: str | None,
    tlog_path: str | None,
    report_path: str | None,
    limits: tuple[str, ...],
    junit_path: str | None,
    workers: int | None,
    scheduler: str | None,
    results_path: str | None,
    as_it_came: bool,
    json_lines: bool,
    declination_deg: float | None,
) -> None:
    """Run filters over LOGs and compare them, and the autopilot's own attitude, with a reference.

    LOG is a telemetry log (tlog), a bare MAVLink stream, ArduPilot's DataFlash log (.bin, .log) or PX4's ULog.
    Messages that are not named are chosen: the best inertial message, and as reference a simulator's truth where there
    is one, else the smoothed attitude where rate and aids allow it, else the autopilot's own. Errors are in degrees:
    the angle between the gravity directions (tilt), and what is left (heading). A folder stands for all logs in it, and
    a pattern such as 'flights/*.tlog' for those that match; several logs end with a summary, the worst first.
    """
    check_names(imu, reference)
    check_declination(declination_deg)
    chosen, pipeline = configured(filters, config_file, changes)
    window = window_of(start_s, end_s, skip_s)
    request = Request(chosen, imu, reference, declination_deg, window, vehicle_of(vehicle), pipeline, as_it_came)
    known = read_calibrations(calibration_path)
    request = replace(request, smooth=smoothed, smooths_beside_truth=smooths, calibrations=known)
    paths = log_paths(logs)
    outputs = {
        "--csv": csv_path,
        "--parquet": parquet_path,
        "--tlog": tlog_path,
        "--report": report_path,
        "--junit": junit_path,
        "--results": results_path,
        "--save-calibration": saved_path,
    }
    check_outputs(paths, outputs)
    is_alone = workers == 1 or len(paths) == 1
    check_cluster(scheduler, workers, outputs)
    check_workers(workers, is_alone)
    showing = Showing(tuple(parse_limit(text) for text in limits), json_lines, len(paths) > MANY)
    with ExitStack() as stack:
        stack.enter_context(seldom_collected())
        written = stack.enter_context(_tables(csv_path, parquet_path))
        annotated = None if tlog_path is None else stack.enter_context(atomic_write(tlog_path))
        page = None if report_path is None else stack.enter_context(report_file(report_path))
        stack.enter_context(junit_file(junit_path, showing.results))
        saved = stack.enter_context(calibration_output(saved_path, known))
        replayed: Replayed = partial(replay_here, work=Work(request, written, annotated, page, saved))
        if scheduler is not None or not is_alone:
            from attest_mav.cli.replay_spread import opened_parts, replay_on_cluster, replay_spread  # noqa: PLC0415

            parts = stack.enter_context(opened_parts(written, csv_path, parquet_path))
            replayed = partial(replay_spread, request=request, workers=workers, parts=parts)
            if scheduler is not None:
                replayed = partial(replay_on_cluster, request=request, address=scheduler, parts=parts)
        outcomes = replayed(paths)
        if results_path is not None:
            from attest_mav.runtime.results import Results  # noqa: PLC0415 - for --results only

            work = (
                f"{version_text()} {chosen} {pipeline} {imu} {reference} {declination_deg} {window} {vehicle} {smooths}"
            )
            work += " as it came" if as_it_came else ""
            work += f" {known}" if known else ""
            results = Results(results_path, work)
            stack.enter_context(results.open())
            outcomes = resumed(paths, results, replayed)
        for outcome in outcomes:
            showing.take(outcome)
        showing.finish()
        if showing.nothing_was_read:
            # Leaving the block by an exception, so that no output file appears.
            click.get_current_context().exit(showing.exit_code)
    click.get_current_context().exit(showing.exit_code)


def _tables(csv_path: str | None, parquet_path: str | None) -> "AbstractContextManager[Tables | None]":
    """The tables that are wanted; their modules are loaded with them."""
    if csv_path is None and parquet_path is None:
        return nullcontext()
    from attest_mav.cli.replay_tables import tables  # noqa: PLC0415 - where they are wanted only

    return tables(csv_path, parquet_path)
