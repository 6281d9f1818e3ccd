"""Filters over arrays."""

from typing import Final

import numpy as np
import numpy.typing as npt

from attest_mav.estimation.sequence import FilterSequence
from attest_mav.estimation.sequence_rows import INNOVATION_WIDTH, STATE_WIDTH, ReadingRows, run_rows
from attest_mav.filters.base import AttitudeFilter
from attest_mav.library.readings import Array, Readings, nanoseconds
from attest_mav.library.solution import Innovations, Solution, continuous, in_frames

STRETCH: Final = 20_000
"""Readings that are held as Python's floats at a time: some 10 MB."""


def run(
    attitude_filter: AttitudeFilter,
    t: npt.ArrayLike,
    gyro: npt.ArrayLike,
    accel: npt.ArrayLike,
    mag: npt.ArrayLike | None = None,
    velocity: npt.ArrayLike | None = None,
    frames: str = "FRD/NED",
) -> Solution:
    """The attitude after each reading.

    t: (n,), s, increasing. gyro: (n, 3), rad/s. accel: (n, 3), specific force, m/s^2. mag: (n, 3), gauss, or None.
    velocity: (n, 3), over ground, m/s, NaN in the rows without a new fix, or None. frames: the axes of body and world,
    "FRD/NED", "FLU/ENU" or "FLU/NWU". ``Readings`` has more: fixes at times of their own, declination, uncertainties.

    The first reading aligns a filter by gravity and field; after more than a second without readings the filter starts
    again. Without a velocity a sensor in a hand is assumed, which moves but stays in place.

    ArgumentError (a ValueError) names the argument that does not fit.
    """
    return run_readings(attitude_filter, Readings(t, gyro, accel, mag, velocity, frames=frames))


def run_readings(attitude_filter: AttitudeFilter, readings: Readings) -> Solution:
    """The attitude after each reading; see ``run``."""
    sequence = FilterSequence(attitude_filter, readings.field, in_place=readings.velocity is None)
    fixes = readings.fixes()
    states: list[Array] = []
    innovations: list[Array] = []
    taken = 0
    for first in range(0, len(readings), STRETCH):
        rows = _stretch(readings, slice(first, first + STRETCH))
        until = taken
        while until < len(fixes) and fixes[until].t_ns <= rows.t_ns[-1]:
            until += 1
        found = run_rows(sequence, rows, fixes[taken:until], first)
        taken = until
        states.append(_columns(found.states, STATE_WIDTH))
        innovations.append(_columns(found.innovations, INNOVATION_WIDTH))
    return _solution(readings, sequence, np.concatenate(states), np.concatenate(innovations))


def _stretch(readings: Readings, rows: slice) -> ReadingRows:
    mag = None if readings.mag is None else readings.mag[rows].tolist()
    return ReadingRows(nanoseconds(readings.t[rows]), readings.gyro[rows].tolist(), readings.accel[rows].tolist(), mag)


def _columns(flat: list[float], width: int) -> Array:
    return np.fromiter(flat, np.float64, len(flat)).reshape(-1, width)


def _solution(readings: Readings, sequence: FilterSequence, states: Array, rows: Array) -> Solution:
    frames = readings.frames
    biases = states[:, 6:9] * np.array(frames.body_vector((1.0, 1.0, 1.0)))
    numbers = rows[:, :3].astype(np.int64)
    return Solution(
        t=readings.t,
        attitudes=continuous(in_frames(states[:, :4], frames)),
        tilt_sigma=states[:, 4],
        heading_sigma=states[:, 5],
        gyro_biases=biases,
        aligned=states[:, 9] > 0.0,
        innovations=Innovations(numbers[:, 0], numbers[:, 1], numbers[:, 2], rows[:, 3:6], rows[:, 6:9]),
        north=sequence.north,
        frames=frames,
    )
