"""The watch on the magnetic field from both directions of time: a disturbance is known before it begins to mislead.

Strength and dip below the horizontal are compared with those of the whole flight; a deviation is taken, as by the live
filter, as the size of the disturbance of the heading that does not show. The dip needs the attitude, so it is watched
from the second pass on.
"""

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


def strength_deviation(rows: FieldRows, parameters: FlightParameters) -> Array:
    """The deviation of the strength alone at each reading, as a share of the field, beyond what the iron may do."""
    length = np.sqrt((rows.field**2).sum(axis=1))
    return _held(rows, np.maximum(0.0, _strength(length, parameters) - 3.0 * parameters.hard_iron / _usual(length)))


def deviation(rows: FieldRows, smoothed: Smoothed, parameters: FlightParameters) -> Array:
    """The deviation of strength and dip at each reading, by the smoothed attitude and iron, as a share of the field."""
    free = rows.field - smoothed.x[rows.node][:, M]
    length = np.sqrt((free**2).sum(axis=1))
    then = np.matmul(smoothed.attitude[rows.node], rows.back)
    sine = turned(then, free)[:, 2] / length
    tilt_sigma = np.sqrt(smoothed.spread[rows.node][:, :2].sum(axis=1))
    rate = np.sqrt((rows.rate**2).sum(axis=1))
    allowed = parameters.disturbance_free + 3.0 * tilt_sigma + LAG_ERROR_S * rate
    dip = np.maximum(0.0, np.abs(sine - _usual(sine)) - allowed)
    return _held(rows, np.hypot(_strength(length, parameters), dip))


def _strength(length: Array, parameters: FlightParameters) -> Array:
    """Deviation of the strength beyond what is free."""
    out: Array = np.maximum(0.0, np.abs(length / _usual(length) - 1.0) - parameters.disturbance_free)
    return out


def _usual(values: Array) -> float:
    """The value of most of the flight."""
    return float(np.median(values)) if len(values) else 1.0


def _held(rows: FieldRows, values: Array) -> Array:
    """The largest value near each reading in time."""
    ahead = held_largest(values, rows.t_s, MEMORY_S)
    behind = held_largest(values[::-1], -rows.t_s[::-1], MEMORY_S)[::-1]
    out: Array = np.maximum(ahead, behind)
    return out
