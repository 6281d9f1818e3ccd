"""The watch on the magnetic field from both directions of time: a disturbance is known before it begins to mislead.

Strength and dip below the horizontal are compared with the usual ones; a deviation is taken, as by the live filter, as
the size of the disturbance of the heading that does not show. The dip needs the attitude, so it is watched from the
second pass on. Usual is the field of most of a flight. In place it is that of the beginning: indoors the field turns
and changes by some per cent within a metre, and north is the one of the place where the readings begin.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.aids.magnetometer import LAG_ERROR_S
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.backward import Smoothed
from attest_mav.smoothing.intervals import held_largest
from attest_mav.smoothing.measurements import FieldRows
from attest_mav.smoothing.model import M
from attest_mav.smoothing.rotations import Array, turned

MEMORY_S: Final = 10.0
"""A disturbance is as large as it was seen within about this time before or behind, s."""
BEGINNING_S: Final = 10.0
"""In place the field of so long is the usual one, s."""


@dataclass(frozen=True)
class FieldWatch:
    """The watch over a recording."""

    in_place: bool
    """Usual is the field of the beginning, not that of most of the flight."""
    parameters: FlightParameters

    def strength_deviation(self, rows: FieldRows) -> Array:
        """The deviation of the strength alone at each reading, as a share of the field, beyond what the iron may do."""
        length = np.sqrt((rows.field**2).sum(axis=1))
        by_iron = 3.0 * self.parameters.hard_iron / self._usual(rows, length)
        return _held(rows, np.maximum(0.0, self._strength(rows, length) - by_iron))

    def deviation(self, rows: FieldRows, smoothed: Smoothed) -> Array:
        """The deviation of strength and dip at each reading, by smoothed attitude and iron, as a share of the field."""
        free = rows.field - smoothed.x[rows.node][:, M]
        length = np.sqrt((free**2).sum(axis=1))
        then = np.matmul(smoothed.attitude[rows.node], rows.back)
        sine = turned(then, free)[:, 2] / length
        tilt_sigma = np.sqrt(smoothed.spread[rows.node][:, :2].sum(axis=1))
        rate = np.sqrt((rows.rate**2).sum(axis=1))
        allowed = self.parameters.disturbance_free + 3.0 * tilt_sigma + LAG_ERROR_S * rate
        dip = np.maximum(0.0, np.abs(sine - self._usual(rows, sine)) - allowed)
        return _held(rows, np.hypot(self._strength(rows, length), dip))

    def _strength(self, rows: FieldRows, length: Array) -> Array:
        """Deviation of the strength beyond what is free."""
        off = np.abs(length / self._usual(rows, length) - 1.0)
        out: Array = np.maximum(0.0, off - self.parameters.disturbance_free)
        return out

    def _usual(self, rows: FieldRows, values: Array) -> float:
        """The value of most of the readings that are the measure."""
        chosen = values[rows.t_s < rows.t_s[0] + BEGINNING_S] if self.in_place and len(values) else values
        return float(np.median(chosen)) if len(chosen) else 1.0


def _held(rows: FieldRows, values: Array) -> Array:
    """The largest value near each reading in time."""
    ahead = held_largest(values, rows.t_s, MEMORY_S)
    behind = held_largest(values[::-1], -rows.t_s[::-1], MEMORY_S)[::-1]
    out: Array = np.maximum(ahead, behind)
    return out
