"""The options of ``attest-mav replay``: what they mean, and a sentence for values that make no sense."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations
from math import inf
from pathlib import Path
from typing import Final

from attest_mav.errors import UsageError
from attest_mav.estimation.arrivals import Arrivals
from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.own import search_here
from attest_mav.filters.registry import default_filter
from attest_mav.replay.plan import VehicleChoice
from attest_mav.replay.request import Window

AUTO: Final = "auto"
ATTITUDES: Final = ("--csv", "--parquet", "--tlog", "--report")
"""The outputs that are made from every attitude of a log."""
ONE_LOG: Final = {
    "--tlog": "an annotated log cannot hold several",
    "--report": "a page shows one flight",
    "--save-calibration": "the errors of the sensors are those at the end of a flight",
}
"""Outputs that are made of a single log, with the reason."""
HERE_ALONE: Final = ("--tlog", "--report", "--save-calibration")
"""Outputs that the process of the command makes itself."""
LARGEST_ID: Final = 255
"""Of a MAVLink system or component."""


def filters_of(text: str, named: Callable[[str], AttitudeFilter]) -> tuple[AttitudeFilter, ...]:
    """The filters of a list of names with commas; none for ``AUTO``. named: makes the filter of a name."""
    names = [name.strip() for name in text.split(",")]
    if names == [AUTO]:
        return ()
    if AUTO in names:
        raise UsageError(f"--filter {text}: {AUTO} stands alone; expected it, or names of filters")
    if any(":" in name for name in names):
        search_here(str(Path.cwd()))
    if len(set(names)) < len(names):
        raise UsageError(f"--filter {text}: a filter is named twice")
    return tuple(named(name) for name in names)


def configured(
    text: str, config_file: str | None, changes: Sequence[str]
) -> tuple[tuple[AttitudeFilter, ...], PipelineSettings]:
    """The filters of a list of names, and the settings beside them, as a configuration has them or by default."""
    if config_file is None and not changes:
        return filters_of(text, default_filter), PipelineSettings()
    # Costs 60 ms, which a replay without a configuration does not need.
    from attest_mav.cli.config import load  # noqa: PLC0415
    from attest_mav.service.assembly import pipeline_settings  # noqa: PLC0415

    config = load(config_file, changes)
    chosen = filters_of(text, config.filter.named) or (config.filter.build(),)
    return chosen, replace(pipeline_settings(config), arrivals=Arrivals.RECORDED)


def vehicle_of(text: str | None) -> VehicleChoice | None:
    """The vehicle of ``SYSTEM`` or ``SYSTEM/COMPONENT``."""
    if text is None:
        return None
    system, slash, component = text.partition("/")
    numbers = [system, component] if slash else [system]
    if not all(number.isdecimal() and int(number) <= LARGEST_ID for number in numbers):
        raise UsageError(f"--vehicle {text}: expected SYSTEM or SYSTEM/COMPONENT, numbers from 0 to {LARGEST_ID}")
    return int(system), int(component) if slash else None


def window_of(start_s: float, end_s: float, skip_s: float) -> Window:
    """The part of the log to read; UsageError for values that make no sense."""
    for option, value in (("--start", start_s), ("--skip", skip_s)):
        if not 0.0 <= value < inf:
            raise UsageError(f"{option} {value:g}: expected seconds, 0 or more")
    if not end_s > start_s:
        raise UsageError(f"--end {end_s:g}: expected more than --start, which is {start_s:g} s")
    return Window(start_s, end_s, skip_s)


def check_declination(declination_deg: float | None) -> None:
    """Refuse what is no angle."""
    if declination_deg is not None and not -180.0 <= declination_deg <= 180.0:
        raise UsageError(f"--declination {declination_deg:g}: expected degrees from -180 to 180, east positive")


def check_outputs(logs: Sequence[str], outputs: dict[str, str | None]) -> None:
    """Refuse outputs (paths by option) that would replace an input or each other."""
    for option, reason in ONE_LOG.items():
        if outputs[option] is not None and len(logs) > 1:
            raise UsageError(f"{option} takes one LOG: {reason}")
    for option in (*ATTITUDES, "--save-calibration"):
        if outputs[option] is not None and outputs["--results"] is not None:
            lacks = "attitudes" if option in ATTITUDES else "errors of sensors"
            raise UsageError(f"{option} and --results: a result that is kept has no {lacks}; expected one of them")
    paths = {option: Path(path) for option, path in outputs.items() if path is not None}
    for option, output in paths.items():
        for name in logs:
            if _is_same_file(output, Path(name)):
                raise UsageError(f"{option} {output} would replace the log it is made from")
    for (one, first), (other, second) in combinations(paths.items(), 2):
        if first.resolve() == second.resolve():
            raise UsageError(f"{one} and {other} are both {first}: expected two files")


def check_workers(workers: int | None, is_alone: bool) -> None:
    """Refuse several processes for a single log, and none at all."""
    if workers is not None and (workers < 1 or (workers > 1 and is_alone)):
        expected = "1 with a single log" if workers > 1 else "1 or more processes"
        raise UsageError(f"--workers {workers}: expected {expected}")


def check_cluster(scheduler: str | None, workers: int | None, outputs: dict[str, str | None]) -> None:
    """Refuse with a cluster what needs the attitudes of a log in this process."""
    if scheduler is None:
        return
    if workers is not None:
        raise UsageError("--dask and --workers: the cluster has its own workers; expected one of them")
    for option in HERE_ALONE:
        if outputs[option] is not None:
            raise UsageError(f"--dask and {option}: the workers send figures and no attitudes; expected one of them")


def _is_same_file(one: Path, other: Path) -> bool:
    return one.resolve() == other.resolve() or (one.is_file() and other.is_file() and one.samefile(other))
