"""Filters over arrays."""

from collections.abc import Callable, Iterator
from functools import partial
from struct import pack
from typing import Final, TypeVar

import numpy as np
import numpy.typing as npt

from attest_mav.estimation.sequence import FilterSequence
from attest_mav.estimation.sequence_rows import (
    ELEMENTS,
    INNOVATION_WIDTH,
    STATE_WIDTH,
    Columns,
    InnovationColumns,
    ReadingRows,
    StateColumns,
    run_rows,
)
from attest_mav.filters.base import AttitudeFilter
from attest_mav.library.readings import Array, Readings, nanoseconds
from attest_mav.library.solution import Innovations, Solution, continuous, in_frames, joined

STRETCH: Final = 500
"""Readings that are held as Python's floats at a time: few enough to stay in the processor's cache."""

_Found = TypeVar("_Found", bound=Columns)


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
    sequence = sequence_of(attitude_filter, readings)
    parts = [_floats(found.values, STATE_WIDTH) for found in stretches(sequence, readings, StateColumns)]
    states = np.concatenate(parts)
    frames = readings.frames
    biases = states[:, 6:9] * np.array(frames.body_vector((1.0, 1.0, 1.0)))
    return Solution(
        t=readings.t,
        attitudes=continuous(in_frames(states[:, :4], frames)),
        tilt_sigma=states[:, 4],
        heading_sigma=states[:, 5],
        gyro_biases=biases,
        aligned=states[:, 9] > 0.0,
        north=sequence.north,
        frames=frames,
        find_innovations=partial(_innovations_of, attitude_filter, readings),
    )


def _innovations_of(attitude_filter: AttitudeFilter, readings: Readings) -> Innovations:
    """The records of the aids, by a second run over the readings."""
    parts, first = [], 0
    for found in stretches(sequence_of(attitude_filter, readings), readings, InnovationColumns):
        parts.append(_innovations(found, first))
        first += found.count
    return joined(parts)


def sequence_of(attitude_filter: AttitudeFilter, readings: Readings) -> FilterSequence:
    """The filter before the first reading."""
    return FilterSequence(attitude_filter, readings.field, in_place=readings.velocity is None)


def stretches(sequence: FilterSequence, readings: Readings, make: Callable[[], _Found]) -> Iterator[_Found]:
    """Run over the readings a stretch at a time; the columns of each."""
    fixes = readings.fixes()
    taken = 0
    for first in range(0, len(readings), STRETCH):
        rows = _stretch(readings, slice(first, first + STRETCH))
        until = taken
        while until < len(fixes) and fixes[until].t_ns <= rows.t_ns[-1]:
            until += 1
        columns = make()
        run_rows(sequence, rows, fixes[taken:until], columns)
        taken = until
        yield columns


def _stretch(readings: Readings, rows: slice) -> ReadingRows:
    mag = None if readings.mag is None else readings.mag[rows].ravel().tolist()
    gyro, accel = readings.gyro[rows].ravel().tolist(), readings.accel[rows].ravel().tolist()
    return ReadingRows(nanoseconds(readings.t[rows]), gyro, accel, mag)


def _floats(flat: list[float], width: int) -> Array:
    """The flat rows as an array; packing takes half the time of numpy's own ways."""
    return np.frombuffer(pack(f"{len(flat)}d", *flat)).reshape(-1, width)


def _innovations(found: InnovationColumns, first: int) -> Innovations:
    reading, aid, fusion = [np.array(one, np.int64) for one in (found.readings, found.aids, found.fusions)]
    values = _floats(found.values, INNOVATION_WIDTH)
    return Innovations(reading + first, aid, fusion, values[:, :ELEMENTS], values[:, ELEMENTS:])
