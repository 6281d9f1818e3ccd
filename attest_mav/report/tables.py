"""The figures of a replay as HTML tables. Every text is escaped: names and messages come from logs."""

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any, Final

from attest_mav.replay.peaks import time_of_day

MOST_ROWS: Final = 200
"""Rows of one table."""
LONG_TEXT: Final = 24
"""Characters of a text that gets a column as wide as a sentence."""
LACK: Final = "-"
"""The cell of a figure that there is not."""


def table(caption: str, headers: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """One table; "" without rows."""
    if not rows:
        return ""
    head = "".join(f'<th scope="col">{escape(one)}</th>' for one in headers)
    body = "".join(_row(row) for row in rows[:MOST_ROWS])
    left_out = len(rows) - MOST_ROWS
    rest = f'<p class="rest">{left_out} more rows are left out.</p>' if left_out > 0 else ""
    return (
        f'<h3>{escape(caption)}</h3><div class="table"><table aria-label="{escape(caption)}">'
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{rest}</div>"
    )


def _row(row: Sequence[str]) -> str:
    first, *others = row
    cells = "".join(f"<td{_kind(cell)}>{escape(cell)}</td>" for cell in others)
    return f'<tr><th scope="row">{escape(first)}</th>{cells}</tr>'


def _kind(cell: str) -> str:
    """The class of a cell of text, which needs a width."""
    return ' class="text"' if len(cell) > LONG_TEXT else ""


def error_table(report: dict[str, Any]) -> str:
    """Errors of every filter and of the autopilot's own attitude."""
    reference = report["reference"]
    against = "without a reference" if reference is None else f"against {reference['message']}"
    skip = report["window"]["skip_s"]
    return table(
        f"Errors {against}, degrees, from {skip:g} s after alignment",
        ("", "tilt rms", "p95", "max", "heading rms", "p95", "max", "samples"),
        [
            (name, *_spread(one["tilt_deg"]), *_spread(one["heading_deg"]), str(one["samples"]))
            for name, one in _compared(report)
        ],
    )


def peak_table(report: dict[str, Any]) -> str:
    """The largest errors: when they were, in log time and by the clock, and what the vehicle did then."""
    rows = [
        (name, angle, *_peak(one[f"{angle}_deg"]))
        for name, one in _compared(report)
        for angle in ("tilt", "heading")
        if one[f"{angle}_deg"] is not None
    ]
    return table("Largest errors", ("", "angle", "error, °", "log time, s", "time of day, UTC", "phase"), rows)


def _compared(report: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """What is compared with the reference, by name: filters, smoothed attitude, the autopilot's own."""
    own, smoothed = report["autopilot"], report["smoothed"]
    named = [(one["name"], one) for one in report["filters"]]
    if smoothed is not None and smoothed["samples"]:
        named.append((smoothed["name"], smoothed))
    if own is not None:
        named.append((f"autopilot's {own['message']}", own))
    return named


def _peak(spread: dict[str, Any]) -> list[str]:
    unix_s = spread["max_at_unix_s"]
    clock = LACK if unix_s is None else time_of_day(unix_s)
    return [figure(spread["max"]), f"{spread['max_at_s']:.1f}", clock, spread["max_phase"]]


def _spread(spread: dict[str, float] | None) -> list[str]:
    return [LACK] * 3 if spread is None else [figure(spread[name]) for name in ("rms", "p95", "max")]


def consistency_table(report: dict[str, Any]) -> str:
    """Errors and innovations in units of the filter's own sigma."""
    rows = []
    for one in report["filters"]:
        consistency = one["consistency"]
        if consistency is not None:
            shares = [_shares(consistency[name]) for name in ("tilt", "heading")]
            nis = [consistency["nis"][name] for name in ("velocity", "magnetometer")]
            means = [LACK if one is None else figure(one["mean"]) for one in nis]
            rows.append((one["name"], *shares[0], *shares[1], *means))
    return table(
        "Consistency with the filter's own sigma (1 where sigma tells the truth)",
        (
            "",
            "tilt in 1 sigma",
            "3 sigma",
            "rms",
            "heading in 1 sigma",
            "3 sigma",
            "rms",
            "NIS velocity",
            "NIS magnetometer",
        ),
        rows,
    )


def _shares(shares: dict[str, float] | None) -> list[str]:
    if shares is None:
        return [LACK] * 3
    return [f"{100 * shares['within_1']:.1f}%", f"{100 * shares['within_3']:.1f}%", f"{shares['rms']:.2f}"]


def verdict_table(report: dict[str, Any]) -> str:
    """The intervals of the verdict."""
    return table(
        f"Verdict beside {report['verdict']['filter']}",
        ("state", "begin, s", "end, s", "reason", "largest tilt, °", "heading, °", "sensors and reports"),
        [
            (
                one["state"] if one["state"] != "disagree" else "DISAGREE",
                f"{one['start_s']:.1f}",
                f"{one['end_s']:.1f}",
                one["reason"],
                _optional(one["peak_tilt_deg"]),
                _optional(one["peak_heading_deg"]),
                "; ".join([*one["sensors"], *one["autopilot_reports"]]),
            )
            for one in report["verdict"]["intervals"]
        ],
    )


def lane_table(report: dict[str, Any]) -> str:
    """The inertial streams with their faults."""
    return table(
        "Inertial streams",
        ("message", "samples", "rate, Hz", "gaps", "faults"),
        [
            (
                one["message"],
                str(one["samples"]),
                _optional(one["rate_hz"]),
                str(one["gaps"]),
                "; ".join(f"{_span(fault)}: {fault['text']}" for fault in one["faults"]) or "none",
            )
            for one in report["lanes"]
        ],
    )


def _span(fault: dict[str, Any]) -> str:
    end = "the end" if fault["end_s"] is None else f"{fault['end_s']:.1f} s"
    return f"{fault['start_s']:.1f} s to {end}"


def notes_of(report: dict[str, Any]) -> str:
    """The notes as a list; "" without any."""
    return _list(f"Note: {note}" for note in report["notes"])


def facts_of(report: dict[str, Any]) -> str:
    """The log in one line of facts."""
    imu, reference, north = report["imu"], report["reference"], report["north"]
    rate = "" if imu["rate_hz"] is None else f" at {imu['rate_hz']:.1f} Hz"
    bad = f", {report['bad_bytes']} bad bytes" if report["bad_bytes"] else ""
    declination = "" if north["declination_deg"] is None else f", declination {north['declination_deg']:+.2f}°"
    return _list(
        [
            f"{report['format']}, {report['frames']} frames, {report['duration_s']:.1f} s{bad}",
            f"Vehicle {report['vehicle']['system']}/{report['vehicle']['component']}",
            f"Inertial: {imu['message']}, {imu['samples']} samples{rate}, gaps: {imu['gaps']}",
            "Reference: none" if reference is None else f"Reference: {reference['message']}{_sigma(reference)}",
            f"Headings from {north['reference']} north{declination}",
        ]
    )


def _sigma(reference: dict[str, Any]) -> str:
    """The uncertainty of a smoothed reference, "" for one that does not tell it."""
    sigma = reference["sigma"]
    spreads = [] if sigma is None else [(name, sigma[f"{name}_deg"]) for name in ("tilt", "heading")]
    parts = [f"{name} sigma {figure(one['rms'])}° rms" for name, one in spreads if one is not None]
    return "".join(f", {part}" for part in parts)


def _list(items: Iterable[str]) -> str:
    lines = "".join(f"<li>{escape(one)}</li>" for one in items)
    return f"<ul>{lines}</ul>" if lines else ""


def figure(value: float) -> str:
    """A figure with three digits."""
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def _optional(value: float | None) -> str:
    return LACK if value is None else figure(value)
