"""The result of ``attest-mav tune`` as tables for people."""

from pathlib import PurePath
from typing import Any, Final

import click

from attest_mav.cli.text_table import TextTable, figures, screen_width, words

SHOWN: Final = 10
"""So many points and logs are shown."""


def print_result(result: dict[str, Any]) -> None:
    """Print the object of ``attest_mav.cli.tune.as_object`` on standard output."""
    width = screen_width()
    click.secho(f"{result['filter']}, cost {result['cost']}: degrees, mean over the logs", bold=True)
    for table in (_points(result), _flatness(result), _logs(result)):
        click.echo(table.text(width), nl=False)
    for remark in _remarks(result):
        click.echo(f"  {remark}")
    click.echo(f"\n{result['toml']}", nl=False)


def _points(result: dict[str, Any]) -> TextTable:
    """The configured values and the best points."""
    points = result["points"]
    table = TextTable(words("values"), *figures("tuning\nlogs", "checking\nlogs"))
    for label, one in [("configured: ", result["configured"]), *(("", one) for one in points[:SHOWN])]:
        values = ", ".join(f"{name} {_value(value)}" for name, value in one["parameters"].items())
        table.add_row(label + values, _cost(one["cost"]), _cost(one["check_cost"]))
    if len(points) > SHOWN:
        table.caption = f"{SHOWN} of {len(points)} points; --json has all"
    return table


def _flatness(result: dict[str, Any]) -> TextTable:
    """The cost one step of each parameter away from the best point, and its change."""
    best = result["points"][0]["cost"]
    table = TextTable(words("around the best"), *figures("below", "cost", "best", "above", "cost", "largest\nchange"))
    for one in result["flatness"]:
        sides = [one[side] for side in ("below", "above")]
        costs = [side["cost"] for side in sides if side is not None and side["cost"] is not None]
        change = (
            "-" if not costs or not best else f"{100.0 * max([cost / best - 1.0 for cost in costs], key=abs):+.1f} %"
        )
        cells = [("end", "") if side is None else (side["value"], _cost(side["cost"])) for side in sides]
        table.add_row(one["name"], *cells[0], one["best"], *cells[1], change)
    return table


def _logs(result: dict[str, Any]) -> TextTable:
    """Each log with its cost before and after."""
    table = TextTable(words("log"), words("part"), words("reference"), *figures("configured", "best"))
    for one in result["logs"][:SHOWN]:
        name = click.format_filename(PurePath(one["log"]).name)
        role = "checks" if one["checks"] else "tunes"
        table.add_row(name, role, one["reference"], _cost(one["configured"]), _cost(one["best"]))
    if len(result["logs"]) > SHOWN:
        table.caption = f"{SHOWN} of {len(result['logs'])} logs; --json has all"
    return table


def _remarks(result: dict[str, Any]) -> list[str]:
    """Sentences on what speaks against the result."""
    remarks = []
    best, configured = result["points"][0], result["configured"]
    if len({one["log"] for one in result["logs"]}) == 1:
        end_s = result["logs"][0]["window"]["end_s"]
        remarks.append(f"one log: its first {end_s:.0f} s tune, the rest checks")
    at_end = [one["name"] for one in result["flatness"] if one["at_end"]]
    if at_end:
        remarks.append(f"at an end of its range: {', '.join(at_end)}; a wider range may be better")
    checks = best["check_cost"], configured["check_cost"]
    if None not in checks and checks[0] >= checks[1]:
        remarks.append("on the logs that check, the best point is no better than the configured values")
    if result["unusable"]:
        remarks.append(f"{len(result['unusable'])} logs could not be used; the errors say why")
    return remarks


def _cost(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _value(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)
