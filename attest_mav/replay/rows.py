"""Attitudes and their errors as comma-separated values, one row each."""

import csv
from math import degrees, isfinite
from typing import Final, Protocol

from attest_mav.algebra import q_to_euler
from attest_mav.replay.comparison import Row

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
)
"""t_s: from the first inertial sample, on the sensor's clock. counted: 1 when the row is part of the figures."""


class TextSink(Protocol):
    """Where the text goes: a file object, say."""

    def write(self, text: str, /) -> object:
        """Take more text."""


class RowWriter:
    """Writes the rows of one or several logs under one header. Fields without a value are empty."""

    def __init__(self, sink: TextSink) -> None:
        self.log = ""
        """Name of the log that the next rows belong to."""
        self._csv = csv.writer(sink, lineterminator="\n")
        self._csv.writerow(HEADER)

    def write(self, row: Row) -> None:
        """Write one row."""
        attitude = row.attitude
        roll, pitch, yaw = q_to_euler(attitude.q_nb)
        self._csv.writerow(
            (
                self.log,
                row.name,
                f"{attitude.elapsed_s:.6f}",
                f"{attitude.t_ns * 1e-9:.6f}",
                f"{degrees(roll):.6f}",
                f"{degrees(pitch):.6f}",
                f"{degrees(yaw):.6f}",
                *(f"{part:.9f}" for part in attitude.q_nb),
                attitude.north.name.lower(),
                _degrees(row.tilt),
                _degrees(row.heading),
                _degrees(attitude.tilt_sigma),
                _degrees(attitude.heading_sigma),
                int(attitude.counted and row.tilt is not None),
            )
        )


def _degrees(angle: float | None) -> str:
    return "" if angle is None or not isfinite(angle) else f"{degrees(angle):.6f}"
