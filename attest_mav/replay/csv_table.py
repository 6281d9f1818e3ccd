"""Compared attitudes as comma-separated values, one row each."""

import csv
from math import degrees, isfinite
from typing import Any, Final, Protocol

from attest_mav.algebra import q_to_euler
from attest_mav.innovation import Aid, Innovation
from attest_mav.replay.comparison import ComparedAttitude

HEADER: Final = (
    "log",
    "filter",
    "t_s",
    "time_boot_s",
    "roll_deg",
    "pitch_deg",
    "yaw_deg",
    "q_w",
    "q_x",
    "q_y",
    "q_z",
    "north",
    "tilt_error_deg",
    "heading_error_deg",
    "tilt_sigma_deg",
    "heading_sigma_deg",
    "counted",
    *(f"{aid.name.lower()}_{column}" for aid in Aid for column in ("fusion", "nis")),
)
"""t_s counts from the first inertial sample, on the sensor's clock; counted is 1 for rows that enter the figures.

Each aid has two columns, filled in the steps in which it had something to say: what became of its measurement, and the
normalised innovation squared.
"""


class TextSink(Protocol):
    """Takes text, for example a file object."""

    def write(self, text: str, /) -> object:
        """Take more text."""


class CsvTable:
    """One table for the attitudes of several logs, with one header."""

    def __init__(self, sink: TextSink) -> None:
        self._csv: Final = csv.writer(sink, lineterminator="\n")
        self._csv.writerow(HEADER)

    def rows_of(self, log: str) -> "CsvRows":
        """The part of the table for the log of that name."""
        return CsvRows(self._csv, log)


class CsvRows:
    """Writes the attitudes of one log. Fields without a value are empty."""

    def __init__(self, writer: Any, log: str) -> None:
        self._csv: Final = writer
        self._log: Final = log

    def write(self, compared: ComparedAttitude) -> None:
        """Write one row."""
        attitude = compared.attitude
        roll, pitch, yaw = q_to_euler(attitude.q_nb)
        self._csv.writerow(
            (
                self._log,
                compared.name,
                f"{attitude.elapsed_s:.6f}",
                f"{attitude.t_ns * 1e-9:.6f}",
                f"{degrees(roll):.6f}",
                f"{degrees(pitch):.6f}",
                f"{degrees(yaw):.6f}",
                *(f"{part:.9f}" for part in attitude.q_nb),
                attitude.north.name.lower(),
                _degrees(compared.tilt),
                _degrees(compared.heading),
                _degrees(attitude.tilt_sigma),
                _degrees(attitude.heading_sigma),
                int(attitude.counted and compared.tilt is not None),
                *_aid_columns(attitude.innovations),
            )
        )


def _degrees(angle: float | None) -> str:
    return "" if angle is None or not isfinite(angle) else f"{degrees(angle):.6f}"


def _aid_columns(innovations: tuple[Innovation, ...]) -> list[str]:
    """Fusion and normalised innovation squared of each aid, empty for those without a record."""
    columns = [""] * (2 * len(Aid))
    for innovation in innovations:
        columns[2 * innovation.aid] = innovation.fusion.name.lower()
        nis = innovation.nis
        columns[2 * innovation.aid + 1] = f"{nis:.6f}" if isfinite(nis) else ""
    return columns
