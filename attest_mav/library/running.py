"""Filters over arrays."""

from typing import Final

import numpy as np
import numpy.typing as npt

from attest_mav.estimation.sequence import FilterSequence
from attest_mav.estimation.sequence_rows import (
    ELEMENTS,
    INNOVATION_WIDTH,
    STATE_WIDTH,
    ReadingRows,
    SolutionRows,
    run_rows,
)
from attest_mav.filters.base import AttitudeFilter
from attest_mav.library.readings import Array, Readings, nanoseconds
from attest_mav.library.solution import Innovations, Solution, continuous, in_frames, joined

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
    innovations: list[Innovations] = []
    taken = 0
    for first in range(0, len(readings), STRETCH):
        rows = _stretch(readings, slice(first, first + STRETCH))
        until = taken
        while until < len(fixes) and fixes[until].t_ns <= rows.t_ns[-1]:
            until += 1
        found = run_rows(sequence, rows, fixes[taken:until], first)
        taken = until
        states.append(_floats(found.states, STATE_WIDTH))
        innovations.append(_innovations(found))
    return _solution(readings, sequence, np.concatenate(states), joined(innovations))


def _stretch(readings: Readings, rows: slice) -> ReadingRows:
    mag = None if readings.mag is None else readings.mag[rows].ravel().tolist()
    gyro, accel = readings.gyro[rows].ravel().tolist(), readings.accel[rows].ravel().tolist()
    return ReadingRows(nanoseconds(readings.t[rows]), gyro, accel, mag)


def _floats(flat: list[float], width: int) -> Array:
    return np.fromiter(flat, np.float64, len(flat)).reshape(-1, width)


def _innovations(found: SolutionRows) -> Innovations:
    reading, aid, fusion = [np.fromiter(one, np.int64, len(one)) for one in (found.readings, found.aids, found.fusions)]
    values = _floats(found.values, INNOVATION_WIDTH)
    return Innovations(reading, aid, fusion, values[:, :ELEMENTS], values[:, ELEMENTS:])


def _solution(readings: Readings, sequence: FilterSequence, states: Array, innovations: Innovations) -> Solution:
    frames = readings.frames
    biases = states[:, 6:9] * np.array(frames.body_vector((1.0, 1.0, 1.0)))
    return Solution(
        t=readings.t,
        attitudes=continuous(in_frames(states[:, :4], frames)),
        tilt_sigma=states[:, 4],
        heading_sigma=states[:, 5],
        gyro_biases=biases,
        aligned=states[:, 9] > 0.0,
        innovations=innovations,
        north=sequence.north,
        frames=frames,
    )
