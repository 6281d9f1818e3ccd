"""The report of a replay as a table for people."""

from collections.abc import Iterator
from math import floor, log10
from typing import Any

import click

from attest_mav.cli.text_table import TextTable, figures, folded, screen_width, words
from attest_mav.replay.peaks import time_of_day

VERDICT_ROWS = 12
"""Intervals of the verdict that the table shows at most."""
CONSISTENT = ("63.2", "98.2", "99.9", "1.00", "68.3", "95.4", "99.7", "1.00")
"""Shares within 1, 2 and 3 sigma and rms, of tilt and heading (``attest_mav.replay.consistency``)."""


def print_report(report: dict[str, Any]) -> None:
    """Print one log's report (``attest_mav.replay.report.as_json``) on standard output."""
    width = screen_width()
    click.secho(click.format_filename(report["log"]), bold=True)
    for label, text in _header(report):
        click.echo(f"  {label:<10} {text}")
    for table in _tables(report):
        click.echo(table.text(width), nl=False)
    for interval in _shown(report["verdict"]["intervals"]):
        if interval["sensors"] or interval["autopilot_reports"]:
            click.echo(folded(_remark(interval), width, indent="  "))


def _tables(report: dict[str, Any]) -> Iterator[TextTable]:
    """The tables that have something to show."""
    yield _table(report)
    if any(one["tilt_deg"] is not None for one in _rows(report)):
        yield _peak_table(report)
    if any(one["consistency"] is not None for one in report["filters"]):
        yield _sigma_table(report)
        yield _innovation_table(report)
    if report["verdict"]["intervals"]:
        yield _verdict_table(report["verdict"])


def _header(report: dict[str, Any]) -> list[tuple[str, str]]:
    """Lines above the table: the log, its messages, the north and the notes."""
    imu, reference, window = report["imu"], report["reference"], report["window"]
    bad = f", {report['bad_bytes']} bad bytes" if report["bad_bytes"] else ""
    rate = "" if imu["rate_hz"] is None else f" at {imu['rate_hz']:.1f} Hz"
    lines = [
        ("log", f"{report['format']}, {report['frames']} frames, {report['duration_s']:.1f} s{bad}"),
        ("inertial", f"{imu['message']}, {imu['samples']} samples{rate}, {_count(imu['gaps'], 'gap')}"),
        ("reference", "none: nothing to compare with"),
        ("north", _north(report["north"])),
        ("errors", f"in degrees, from {window['skip_s']:g} s after alignment"),
    ]
    if reference is not None:
        lines[2] = ("reference", f"{reference['message']}, {reference['samples']} samples")
    return [*lines, *(("note", note) for note in report["notes"])]


def _north(north: dict[str, Any]) -> str:
    if north["reference"] == "magnetic":
        return "magnetic: the declination is not known; --declination gives it"
    return f"true; declination {north['declination_deg']:+.2f} deg, {north['source']}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _compared(report: dict[str, Any]) -> list[dict[str, Any]]:
    """The filters, and the smoothed attitude where it is compared."""
    smoothed = report["smoothed"]
    return [*report["filters"], *([] if smoothed is None or not smoothed["samples"] else [smoothed])]


def _table(report: dict[str, Any]) -> TextTable:
    """One row a filter, and the autopilot's own below them."""
    heading = "heading" if report["north"]["reference"] == "true" else "magn.\nheading"
    table = _figure_table("error", "tilt\nrms", "p95", "max", f"{heading}\nrms", "p95", "max", "compared\nsamples")
    for one in _compared(report):
        table.add_row(one["name"], *_figures(one), str(one["samples"]))
    own = report["autopilot"]
    if own is not None:
        table.add_row(f"autopilot's {own['message']}", *_figures(own), str(own["samples"]), dim=True)
    return table


def _rows(report: dict[str, Any]) -> list[dict[str, Any]]:
    """What was compared with the reference: the filters, and the autopilot's own attitude."""
    own = report["autopilot"]
    return report["filters"] if own is None else [*report["filters"], {**own, "name": f"autopilot's {own['message']}"}]


def _peak_table(report: dict[str, Any]) -> TextTable:
    """Instant and phase of the largest errors; the time of day, UTC, where the log tells it."""
    rows = _rows(report)
    has_utc = any(one["tilt_deg"] is not None and one["tilt_deg"]["max_at_unix_s"] is not None for one in rows)
    at = "UTC" if has_utc else "s"
    table = _figure_table("largest error", f"tilt\nat {at}", "phase", f"heading\nat {at}", "phase")
    for one in rows:
        table.add_row(one["name"], *_peak(one["tilt_deg"], has_utc), *_peak(one["heading_deg"], has_utc))
    return table


def _peak(figures: dict[str, Any] | None, has_utc: bool) -> tuple[str, str]:
    """The cells of one largest error."""
    if figures is None:
        return "-", "-"
    at = time_of_day(figures["max_at_unix_s"]) if has_utc else f"{figures['max_at_s']:.1f}"
    return at, figures["max_phase"]


def _sigma_table(report: dict[str, Any]) -> TextTable:
    """One row a filter that has sigmas, and below them what a consistent one would show; ratio: error / sigma."""
    columns = [label for kind in ("tilt", "heading") for label in (f"{kind}\n1 sigma", "2", "3", "ratio\nrms")]
    table = _figure_table("its own sigma:\n% within", *columns)
    for one in _compared(report):
        if one["consistency"] is not None:
            table.add_row(one["name"], *_shares(one["consistency"]["tilt"]), *_shares(one["consistency"]["heading"]))
    table.add_row("if consistent", *CONSISTENT, dim=True)
    return table


def _innovation_table(report: dict[str, Any]) -> TextTable:
    """One row a filter that has sigmas: its innovations, and the part of the flight in which it is sure."""
    table = _figure_table("innovations", "mean NIS,\nvelocity", "mean NIS,\nmagn.", "sigma\n< 1 deg", "tilt rms\nthere")
    for one in report["filters"]:
        if one["consistency"] is not None:
            table.add_row(one["name"], *_innovation_figures(one))
    return table


def _figure_table(name: str, *labels: str) -> TextTable:
    """A table with names in its first column, and figures in the others."""
    return TextTable(words(name), *figures(*labels))


def _shown(intervals: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The intervals to show: of many, those with DISAGREE and the longest others."""
    return sorted(sorted(intervals, key=_importance)[:VERDICT_ROWS], key=_start)


def _verdict_table(verdict: dict[str, Any]) -> TextTable:
    """The intervals of the verdict beside one filter."""
    labels = ("from\ns", "to\ns", "largest\ntilt", "largest\nheading")
    table = TextTable(words(f"verdict beside\n{verdict['filter']}"), *figures(*labels), words("reason"))
    for interval in _shown(verdict["intervals"]):
        angles = [
            "-" if interval[key] is None else f"{interval[key]:.1f}" for key in ("peak_tilt_deg", "peak_heading_deg")
        ]
        times = [f"{interval[key]:.1f}" for key in ("start_s", "end_s")]
        table.add_row(_word(interval), *times, *angles, interval["reason"])
    if len(verdict["intervals"]) > VERDICT_ROWS:
        table.caption = f"{VERDICT_ROWS} of {len(verdict['intervals'])} intervals; --json has all"
    return table


def _word(interval: dict[str, Any]) -> str:
    """The verdict; the bad one stands out."""
    word: str = interval["state"]
    return word.upper() if word == "disagree" else word


def _remark(interval: dict[str, Any]) -> str:
    """The sensors of an interval, and the autopilot on itself at its end."""
    return f"{interval['start_s']:.1f} s: " + "; ".join([*interval["sensors"], *interval["autopilot_reports"]])


def _importance(interval: dict[str, Any]) -> tuple[bool, float]:
    """DISAGREE first, then the long ones."""
    return interval["state"] != "disagree", interval["start_s"] - interval["end_s"]


def _start(interval: dict[str, Any]) -> float:
    start_s: float = interval["start_s"]
    return start_s


def _innovation_figures(one: dict[str, Any]) -> list[str]:
    """The cells of one filter."""
    valid, cells = one["valid"], []
    for source in ("velocity", "magnetometer"):
        nis = one["consistency"]["nis"][source]
        cells.append("-" if nis is None else f"{nis['mean']:.2f}")
    if valid is None:
        return [*cells, "-", "-"]
    spread = valid["tilt_deg"]
    return [*cells, f"{100.0 * valid['share']:.1f} %", "-" if spread is None else _significant(spread["rms"])]


def _shares(shares: dict[str, float] | None) -> list[str]:
    """Percentages within 1, 2 and 3 sigma, cut rather than rounded up to 100, and the rms."""
    if shares is None:
        return ["-", "-", "-", "-"]
    percentages = [f"{floor(1000.0 * shares[f'within_{k}']) / 10.0:.1f}" for k in (1, 2, 3)]
    return [*percentages, f"{shares['rms']:.2f}"]


def _figures(errors: dict[str, Any]) -> list[str]:
    """Tilt and heading: rms, p95, max."""
    return [
        "-" if errors[kind] is None else _significant(errors[kind][figure])
        for kind in ("tilt_deg", "heading_deg")
        for figure in ("rms", "p95", "max")
    ]


def _significant(value: float) -> str:
    """Three significant digits, and no more than three decimals: nobody's truth is better."""
    if value < 1e-3:
        return f"{value:.3f}"
    return f"{value:.{min(3, max(0, 2 - floor(log10(value))))}f}"
