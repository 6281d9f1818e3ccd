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


class SolutionRows:
    """The columns that a filter leaves."""

    def __init__(self) -> None:
        self.states: Final[list[float]] = []
        """``STATE_WIDTH`` floats a reading."""
        self.readings: Final[list[int]] = []
        """Of each innovation, the number of the reading."""
        self.aids: Final[list[int]] = []
        """Of each innovation, its ``Aid``."""
        self.fusions: Final[list[int]] = []
        """Of each innovation, its ``Fusion``."""
        self.values: Final[list[float]] = []
        """Of each innovation, ``INNOVATION_WIDTH`` floats."""


def run_rows(
    sequence: FilterSequence, readings: ReadingRows, fixes: list[VelocitySample], first: int = 0
) -> SolutionRows:
    """The filter over the readings. A fix is used from the first reading on that is not earlier.

    fixes: in order of time. first: the number of the first reading, for the rows of innovations.
    """
    found = SolutionRows()
    mags = readings.mag
    next_fix = 0
    for k in range(len(readings.t_ns)):
        t_ns = readings.t_ns[k]
        while next_fix < len(fixes) and fixes[next_fix].t_ns <= t_ns:
            sequence.give_velocity(fixes[next_fix])
            next_fix += 1
        mag = None if mags is None else _field(mags, k)
        state = sequence.advance(t_ns, _vector(readings.gyro, k), _vector(readings.accel, k), mag)
        if state is None:
            found.states.extend((nan, nan, nan, nan, nan, nan, nan, nan, nan, 0.0))
            continue
        _add_state(found.states, state)
        for one in state.innovations:
            _add_innovation(found, first + k, one)
    return found


def _add_state(column: list[float], state: FilterState) -> None:
    """Append what a filter shows; the attitude is NaN while it is not aligned."""
    q, bias = state.q_nb, state.gyro_bias
    aligned = state.aligned
    if aligned:
        column.append(q[0])
        column.append(q[1])
        column.append(q[2])
        column.append(q[3])
        column.append(state.tilt_sigma)
        column.append(state.heading_sigma)
    else:
        column.extend((nan, nan, nan, nan, nan, nan))
    column.append(bias[0])
    column.append(bias[1])
    column.append(bias[2])
    column.append(1.0 if aligned else 0.0)


def _add_innovation(found: SolutionRows, number: int, one: Innovation) -> None:
    """Append a record. Elements beyond the third are left out."""
    found.readings.append(number)
    found.aids.append(one.aid)
    found.fusions.append(one.fusion)
    _add_padded(found.values, one.residual)
    _add_padded(found.values, one.variance)


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
