"""The measurements of a flight, each at its own instant and seen from the node behind it.

The velocity of a fix is that of the node less the motion since: the residuals and Jacobians are those of
``velocity_aided.aids``, for instants that lie at most one interval before the node.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attest_mav.smoothing.intervals import Intervals
from attest_mav.smoothing.iron import Iron
from attest_mav.smoothing.parts import Part
from attest_mav.smoothing.readings import Fixes, Readings
from attest_mav.smoothing.rotations import Array, cross_matrices, from_vector, matrices, multiply, turned
from attest_mav.smoothing.tables import Table


@dataclass(frozen=True)
class Lags:
    """How much older a measurement is than the low-passed inertial readings of its time, s."""

    field_s: float
    fix_s: float


@dataclass(frozen=True)
class FixRows:
    """Velocity fixes of a part in order of their nodes."""

    node: NDArray[np.int64]
    """Number in the part of the node behind the instant of the fix."""
    velocity: Array
    """NED, m/s."""
    axes: NDArray[np.int64]
    """2, or 3 where the vertical velocity is measured."""
    reported: Array
    """Variance that the receiver reports, (m/s)^2."""
    age_s: Array
    """From the instant to the node, s."""
    gain: Array
    """Integral of the specific force since the instant, in the body axes of the node, m/s."""
    force: Array
    """Specific force at the instant, in the body axes of the node, m/s^2."""
    nominal_bias: Array
    """Of the accelerometer, without which gain and force are, m/s^2."""


@dataclass(frozen=True)
class FieldRows:
    """Magnetometer readings of a part in order of their nodes."""

    node: NDArray[np.int64]
    t_s: Array
    """Instant of the reading, s."""
    field: Array
    """Body, without the iron that is known before, gauss."""
    iron_sigma: Array
    """1-sigma of that iron on each axis, gauss."""
    back: Array
    """Matrix from the body at the instant to that at the node."""
    rate: Array
    """Rate of the body at the instant, rad/s."""
    turning: Array
    """[rate]x."""


def fix_rows(part: Part, intervals: Intervals, fixes: Fixes, lags: Lags) -> FixRows:
    """The fixes that lie within the intervals."""
    begin, end = (
        int(np.searchsorted(fixes.t_s - lags.fix_s, limit_s, side="right" if behind_equal else "left"))
        for limit_s, behind_equal in _limits(part)
    )
    fixes = fixes.rows(begin, end)
    t_s = fixes.t_s - lags.fix_s
    node, row, kept = _places(part, t_s)
    node, row, t_s = node[kept], row[kept], t_s[kept]
    readings = part.readings
    since_row_s = t_s - readings.t_s[row]
    bias = intervals.nominal.accel_bias[node - 1]
    at_row = matrices(intervals.turn_at[row])
    force = turned(at_row, readings.accel[row] - bias)
    slope = _force_slope(readings, intervals, row, bias, force)
    gained = intervals.gain_at[row] + since_row_s[:, np.newaxis] * (force + 0.5 * since_row_s[:, np.newaxis] * slope)
    into = np.swapaxes(intervals.turn[node - 1], 1, 2)
    return FixRows(
        node,
        fixes.velocity[kept],
        np.where(fixes.has_vertical[kept], 3, 2),
        fixes.sigma[kept] ** 2,
        part.node_s[node] - t_s,
        turned(into, intervals.gain[node - 1] - gained),
        turned(into, force + since_row_s[:, np.newaxis] * slope),
        bias,
    )


def _force_slope(readings: Readings, intervals: Intervals, row: NDArray[np.int64], bias: Array, force: Array) -> Array:
    """Change of the specific force with time behind a reading, in the axes of ``force``, m/s^3."""
    step_s = readings.t_s[row + 1] - readings.t_s[row]
    rate = readings.gyro[row] * step_s[:, np.newaxis]
    behind = matrices(multiply(intervals.turn_at[row], from_vector(rate)))
    out: Array = (turned(behind, readings.accel[row + 1] - bias) - force) / step_s[:, np.newaxis]
    return out


def field_rows(part: Part, intervals: Intervals, fields: Table, lags: Lags, iron: Iron) -> FieldRows:
    """The new readings of the magnetometer that lie within the intervals. fields: of the recording."""
    begin, end = (
        fields.place(limit_s, lags.field_s, behind_equal=behind_equal) for limit_s, behind_equal in _limits(part)
    )
    new = fields.rows(begin, end)
    t_s = new["t_s"] - lags.field_s
    node, row, kept = _places(part, t_s)
    node, row, t_s = node[kept], row[kept], t_s[kept]
    rate = part.readings.gyro[row] - intervals.nominal.gyro_bias[node - 1]
    since_row_s = (t_s - part.readings.t_s[row])[:, np.newaxis]
    then = multiply(intervals.turn_at[row], from_vector(rate * since_row_s))
    back = np.matmul(np.swapaxes(intervals.turn[node - 1], 1, 2), matrices(then))
    known, sigma = iron.at(begin, end)
    return FieldRows(node, t_s, (new["field"] - known)[kept], sigma[kept], back, rate, cross_matrices(rate))


def _limits(part: Part) -> tuple[tuple[float, bool], tuple[float, bool]]:
    """The times between which the instants of a part lie, s, each with whether those equal to it lie before it."""
    begin_s, end_s = part.node_s[[0, -1]].tolist()
    return (begin_s, part.first > 0), (end_s, True)


def _places(part: Part, t_s: Array) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """For each instant of a part the node behind it, the reading before it, and whether its motion is known."""
    nodes = part.rows
    node = np.clip(np.searchsorted(part.node_s, t_s, side="left"), 1, len(nodes) - 1)
    row = np.searchsorted(part.readings.t_s, t_s, side="right") - 1
    row = np.clip(row, nodes[node - 1], nodes[node] - 1)
    return node, row, ~part.is_gap[node - 1]
