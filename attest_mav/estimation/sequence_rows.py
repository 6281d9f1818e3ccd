"""A filter over many readings at once: lists of floats in, flat columns of floats out.

The loop stands in the compiled core, so that a filter over arrays costs little more than its steps.
"""

from math import isfinite, nan
from typing import Final

from attest_mav.estimation.sequence import FilterSequence
from attest_mav.filters.base import FilterState
from attest_mav.innovation import Innovation
from attest_mav.samples import VelocitySample
from attest_mav.types import Vec3

Flat = list[float]
"""Three floats a row, one after the other: lists of rows would take twice as long."""

STATE_WIDTH: Final = 10
"""Quaternion (4), tilt and heading sigma, gyro bias (3), and 1 where the filter is aligned, else 0."""
ELEMENTS: Final = 3
"""Scalar measurements in one row of innovations; the rest of the row is NaN."""
INNOVATION_WIDTH: Final = 2 * ELEMENTS
"""Residuals and variances."""


class ReadingRows:
    """The readings of a stretch: times in ns, and three floats for each; mag None without a magnetometer."""

    def __init__(self, t_ns: list[int], gyro: Flat, accel: Flat, mag: Flat | None) -> None:
        self.t_ns: Final = t_ns
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.mag: Final = mag


class Columns:
    """What is kept of a filter's states: here nothing."""

    def add(self, state: FilterState | None) -> None:
        """Take the state after one reading more; None while there is none."""


class StateColumns(Columns):
    """Attitude, sigmas and gyro bias after each reading."""

    def __init__(self) -> None:
        self.values: Final[list[float]] = []
        """``STATE_WIDTH`` floats a reading."""

    def add(self, state: FilterState | None) -> None:
        """Append what the filter shows; the attitude is NaN while it is not aligned."""
        column = self.values
        if state is None or not state.aligned:
            bias = (nan, nan, nan) if state is None else state.gyro_bias
            column.extend((nan, nan, nan, nan, nan, nan, bias[0], bias[1], bias[2], 0.0))
            return
        q, bias = state.q_nb, state.gyro_bias
        column.append(q[0])
        column.append(q[1])
        column.append(q[2])
        column.append(q[3])
        column.append(state.tilt_sigma)
        column.append(state.heading_sigma)
        column.append(bias[0])
        column.append(bias[1])
        column.append(bias[2])
        column.append(1.0)


class InnovationColumns(Columns):
    """The records of the aids."""

    def __init__(self) -> None:
        self.count = 0
        """Readings so far."""
        self.readings: Final[list[int]] = []
        """Of each innovation, the number of the reading."""
        self.aids: Final[list[int]] = []
        """Of each innovation, its ``Aid``."""
        self.fusions: Final[list[int]] = []
        """Of each innovation, its ``Fusion``."""
        self.values: Final[list[float]] = []
        """Of each innovation, ``INNOVATION_WIDTH`` floats."""

    def add(self, state: FilterState | None) -> None:
        """Append the records of this step."""
        if state is not None:
            for one in state.innovations:
                self._add_record(one)
        self.count += 1

    def _add_record(self, one: Innovation) -> None:
        """Append a record. Elements beyond the third are left out."""
        self.readings.append(self.count)
        self.aids.append(one.aid)
        self.fusions.append(one.fusion)
        _add_padded(self.values, one.residual)
        _add_padded(self.values, one.variance)


def run_rows(sequence: FilterSequence, readings: ReadingRows, fixes: list[VelocitySample], columns: Columns) -> None:
    """Let the filter take the readings. A fix is used from the first reading on that is not earlier.

    fixes: in order of time. columns: take the filter's state after each reading.
    """
    mags = readings.mag
    next_fix = 0
    for k in range(len(readings.t_ns)):
        t_ns = readings.t_ns[k]
        while next_fix < len(fixes) and fixes[next_fix].t_ns <= t_ns:
            sequence.give_velocity(fixes[next_fix])
            next_fix += 1
        mag = None if mags is None else _field(mags, k)
        columns.add(sequence.advance(t_ns, _vector(readings.gyro, k), _vector(readings.accel, k), mag))


def _add_padded(column: list[float], values: tuple[float, ...]) -> None:
    count = len(values)
    column.append(values[0] if count > 0 else nan)
    column.append(values[1] if count > 1 else nan)
    column.append(values[2] if count > 2 else nan)


def _vector(rows: Flat, k: int) -> Vec3:
    return (rows[3 * k], rows[3 * k + 1], rows[3 * k + 2])


def _field(rows: Flat, k: int) -> Vec3 | None:
    """The field of a row; None where it is not finite or zero, as of a sensor that has no new reading."""
    x, y, z = rows[3 * k], rows[3 * k + 1], rows[3 * k + 2]
    return (x, y, z) if isfinite(x + y + z) and (x != 0.0 or y != 0.0 or z != 0.0) else None
