"""The table of a study, at most 80 columns wide, and its lines as JSON."""

from math import isfinite
from typing import Final

from attest_mav.evaluation.fault_study.card import bounds_of
from attest_mav.evaluation.fault_study.figures import FaultFigures, is_within

HEADER: Final = f"{'fault':23}{'autopilot':>9}{'ours':>10}{'99%':>6}{'dis':>6}{'blind':>6}{'false':>6}{'mute':>6} named"
SHORT: Final = {"RAW_IMU": "raw", "SCALED_IMU2": "imu2", "SCALED_IMU": "imu1", "SCALED_IMU3": "imu3"}
"""Names of inertial streams in the last column."""
COLUMN_FIGURES: Final = ("ours 99%", "disagree", "blind", "false", "mute")
WIDTHS: Final = (6, 6, 6, 6, 6)


def lines_of(found: FaultFigures) -> str:
    """One row: degrees as tilt/heading, seconds; ! behind a figure that misses its bound."""
    figures = found.figures
    pair = f"{_pair(found, 'autopilot tilt', 'autopilot heading'):>9}{_pair(found, 'ours', 'ours heading'):>10}"
    cells = "".join(f"{_cell(found, name):>{width}}" for name, width in zip(COLUMN_FIGURES, WIDTHS, strict=True))
    named = ""
    if found.named:
        mark = "?" if figures["named right"] == 0.0 else ""
        named = f" {SHORT.get(found.named, found.named[:4])}{figures['named']:.1f}{mark}"
    return f"{found.fault.name[:23]:23}{pair}{cells}{named}"


def missed(found: FaultFigures) -> list[str]:
    """Names of the figures that miss their bounds."""
    bounds = bounds_of(found.fault.group)
    return [name for name, (low, high) in bounds.items() if not is_within(found.figures[name], low, high)]


def as_json(log: str, found: FaultFigures) -> dict[str, object]:
    """A row as a JSON object; what is not a number becomes null."""
    figures = {name: value if isfinite(value) else None for name, value in found.figures.items()}
    return {"log": log, "fault": found.fault.name, **figures, "source": found.named, "missed": missed(found)}


def _pair(found: FaultFigures, tilt: str, heading: str) -> str:
    mark = "!" if tilt in missed(found) else ""
    return f"{_number(found.figures[tilt])}/{_number(found.figures[heading])}{mark}"


def _cell(found: FaultFigures, name: str) -> str:
    value = found.figures[name]
    mark = "!" if name in missed(found) else ""
    return "-" if not isfinite(value) else f"{value:.2f}{mark}" if value < 10.0 else f"{value:.0f}{mark}"


def _number(value: float) -> str:
    """A number of degrees with as many digits as fit."""
    if not isfinite(value):
        return "-"
    return f"{value:.0f}" if value >= 10.0 else f"{value:.1f}" if value >= 1.0 else f"{value:.2f}"
