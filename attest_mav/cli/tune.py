"""``attest-mav tune``: parameters of a filter, searched on some logs and checked on others."""

import json
import os
from functools import partial
from math import isfinite
from typing import Any

import click

from attest_mav.cli.progress import ProgressBar
from attest_mav.cli.replay_options import window_of
from attest_mav.cli.tune_requests import OwnRequestMaker, RequestMaker
from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.evaluation.tuning.search import (
    CONFIGURED,
    Costs,
    Found,
    LogPart,
    Neighbour,
    Trial,
    measure,
    search,
    split,
)
from attest_mav.evaluation.tuning.space import Point, grid_points, random_points
from attest_mav.filters.registry import filter_names
from attest_mav.replay.limits import SPREADS
from attest_mav.replay.request import Request, Window
from attest_mav.runtime.files import open_log
from attest_mav.runtime.log_paths import log_paths


@click.command("tune")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option(
    "--filter",
    "name",
    required=True,
    metavar="NAME",
    help=f"The filter, of {', '.join(filter_names())}, or MODULE:CLASS.",
)
@click.option(
    "--param",
    "texts",
    multiple=True,
    required=True,
    metavar="NAME=VALUES",
    help="LOW:HIGH, LOW:HIGH:log or A,B,C: the values that a parameter may have. May be given several times.",
)
@click.option("--steps", default=5, show_default=True, metavar="N", help="Values of a range in the grid.")
@click.option("--runs", type=int, metavar="N", help="N points at random instead of the grid.")
@click.option("--seed", default=1, show_default=True, help="Of the random points.")
@click.option(
    "--cost",
    "figure",
    default="tilt.rms",
    show_default=True,
    metavar="FIGURE",
    help=f"What is to be small, of {', '.join(SPREADS)}; degrees, the mean over the logs.",
)
@click.option("--check-every", "every", default=3, show_default=True, metavar="N", help="Every Nth log checks.")
@click.option("--config", "config_file", metavar="FILE", help="Configuration (TOML) with all other values.")
@click.option("--set", "changes", metavar="KEY=VALUE", multiple=True, help="A value, instead of the configuration's.")
@click.option(
    "--skip", "skip_s", default=30.0, show_default=True, metavar="SECONDS", help="Not counted: so long after alignment."
)
@click.option("--workers", type=int, metavar="N", help="Processes; one a core if not given.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of tables.")
def command(
    logs: tuple[str, ...],
    name: str,
    texts: tuple[str, ...],
    steps: int,
    runs: int | None,
    seed: int,
    figure: str,
    every: int,
    config_file: str | None,
    changes: tuple[str, ...],
    skip_s: float,
    workers: int | None,
    as_json: bool,
) -> None:
    """Search parameters of a filter that bring it near to the reference of each LOG.

    Two of three logs choose the parameters, the third checks the choice; of a single log the first half chooses and the
    second half checks. The tables show the best points, how much the cost changes around the best one, and the logs; in
    the end stands TOML for the configuration.
    """
    check_options(figure, steps, every, runs)
    base = Request(window=window_of(0.0, float("inf"), skip_s))
    maker = OwnRequestMaker if ":" in name else RequestMaker
    requests = maker(name, texts, (config_file, changes), base)
    parameters = requests.parameters
    points = grid_points(parameters, steps) if runs is None else random_points(parameters, runs, seed)
    for point in points:
        requests.of(point)  # a value that cannot be is refused before the work begins
    found, unusable = run(log_paths(logs), requests, points, (figure, steps, every), workers)
    result = as_object(name, figure, requests, found, unusable)
    if as_json:
        click.echo(json.dumps(result, allow_nan=False))
    else:
        from attest_mav.cli.tune_table import print_result  # noqa: PLC0415 (costs 100 ms)

        print_result(result)
    if unusable:
        click.get_current_context().exit(UnreadableDataError.exit_code)


def check_options(figure: str, steps: int, every: int, runs: int | None) -> None:
    """Refuse what makes no sense."""
    if figure not in SPREADS:
        raise UsageError(f"--cost {figure}: expected one of {', '.join(SPREADS)}")
    for option, value, least in (("--steps", steps, 2), ("--check-every", every, 2), ("--runs", runs, 1)):
        if value is not None and value < least:
            raise UsageError(f"{option} {value}: expected {least} or more")


def run(
    paths: list[str], requests: RequestMaker, points: list[Point], settings: tuple[str, int, int], workers: int | None
) -> tuple[Found, list[str]]:
    """Measure the logs as configured, leave those out that give no cost, and search; the reasons of those left out."""
    from attest_mav.runtime.processes import processes  # noqa: PLC0415 - with it comes multiprocessing

    figure, steps, every = settings
    one_by_one = partial(measure, figure=figure, open_log=open_log)
    with processes(workers or os.cpu_count()) as task_map, ProgressBar("replays") as bar:
        configured_request = requests.of(CONFIGURED)
        trials = [Trial(path, configured_request) for path in paths]
        measured = list(zip(paths, task_map(one_by_one, trials), strict=True))
        usable = [(path, one) for path, one in measured if one.cost is not None]
        unusable = [one.error for _, one in measured if one.cost is None]
        for error in unusable:
            click.echo(f"attest-mav: error: {error}", err=True)
        if not usable:
            raise UnreadableDataError("no log can be used to tune; expected at least one with a reference")
        parts = split(usable, every, requests.base.window)
        total = (len(points) + 1) * sum([not part.checks for part in parts])
        costs = Costs(requests.of, one_by_one, task_map, lambda count: bar.show(min(1.0, count / total)))
        return search(costs, parts, requests.parameters, points, steps), unusable


def as_object(name: str, figure: str, requests: RequestMaker, found: Found, unusable: list[str]) -> dict[str, Any]:
    """The result as one JSON object; costs in degrees, null for none."""
    return {
        "filter": name,
        "cost": figure,
        "configured": _costs(requests.values(CONFIGURED), found.configured, found.configured_check),
        "points": [_costs(requests.values(point), cost, found.checked.get(point)) for point, cost in found.ranked],
        "flatness": [
            {
                "name": one.name,
                "best": one.best,
                "at_end": one.at_end,
                "below": _neighbour(one.below),
                "above": _neighbour(one.above),
            }
            for one in found.flatness
        ],
        "logs": [_log(part, found) for part in found.parts],
        "unusable": unusable,
        "toml": requests.toml(found.best),
    }


def _costs(values: dict[str, Any], tuning: float, checking: float | None) -> dict[str, Any]:
    return {"parameters": values, "cost": _number(tuning), "check_cost": _number(checking)}


def _neighbour(one: Neighbour | None) -> dict[str, Any] | None:
    return None if one is None else {"value": one.text, "cost": _number(one.cost)}


def _log(part: LogPart, found: Found) -> dict[str, Any]:
    before, after = found.of_log(part)
    return {
        "log": part.path,
        "checks": part.checks,
        "window": _window(part.window),
        "reference": before.reference,
        "configured": _number(before.cost),
        "best": _number(after.cost),
    }


def _window(window: Window) -> dict[str, float | None]:
    return {"start_s": window.start_s, "end_s": _number(window.end_s)}


def _number(value: float | None) -> float | None:
    """Six decimals; None for what is no number."""
    return None if value is None or not isfinite(value) else round(value, 6)
