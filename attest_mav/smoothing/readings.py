"""The readings of one inertial sensor and what aids it over a whole flight."""

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.smoothing.rotations import Array
from attest_mav.smoothing.selection import median
from attest_mav.smoothing.tables import Rows, Scratch, Table
from attest_mav.types import Quat, VelocityOrigin

READING: Final = np.dtype(
    [
        ("t_ns", "<i8"),
        ("t_s", "<f8"),
        ("gyro", "<f8", 3),
        ("accel", "<f8", 3),
        ("gap_s", "<f8"),
        ("saturated", "?"),
        ("at_rest", "?"),
        ("stays", "?"),
    ]
)
"""A row of inertial readings."""
READING_FORMAT: Final = "<q8d3?"
"""The same for ``struct``."""
FIELD_READING: Final = np.dtype([("t_s", "<f8"), ("field", "<f8", 3), ("gyro", "<f8", 3)])
"""A row of a new magnetometer reading: time of its inertial sample, s, field in the body, gauss, and gyro, rad/s."""
FIELD_READING_FORMAT: Final = "<7d"


@dataclass(frozen=True)
class Readings:
    """Consecutive inertial readings, an array of each kind."""

    t_ns: NDArray[np.int64]
    """Sensor clock, ns, as the samples carry it."""
    t_s: Array
    """Time that grows over the restarts of that clock, s."""
    gyro: Array
    """Body, rad/s."""
    accel: Array
    """Specific force, body, m/s^2."""
    gap_s: Array
    """Length of the step before, s, where samples are missing in it and a rotation may have gone unseen; else 0."""
    saturated: NDArray[np.bool_]
    at_rest: NDArray[np.bool_]
    """The sensors are quiet, and the vehicle says or is known to stand."""
    stays: NDArray[np.bool_]
    """The vehicle may be taken to stay in place: it is not armed."""


@dataclass(frozen=True)
class Fixes:
    """Velocity fixes in order of their times, a row each; 49 bytes a fix."""

    t_s: Array
    """Time that the message names, on the clock of the readings, s."""
    velocity: Array
    """NED, m/s."""
    has_vertical: NDArray[np.bool_]
    sigma: Array
    """As the receiver reports it, m/s; 0 where it reports none."""

    def rows(self, begin: int, end: int) -> "Fixes":
        """Some of them."""
        some = slice(begin, end)
        return Fixes(self.t_s[some], self.velocity[some], self.has_vertical[some], self.sigma[some])


@dataclass(frozen=True)
class Stretch:
    """A part of the readings without a gap. Its attitude is known at one of them, from an alignment."""

    begin: int
    """Row of its first reading."""
    aligned: int
    """Row of the reading whose attitude is known."""
    q_nb: Quat
    """That attitude."""
    has_heading: bool = True
    """Whether that is known of it too: neither compass nor velocity may have shown it."""


@dataclass(frozen=True)
class Recording:
    """A whole flight."""

    scratch: Scratch
    """Of the tables."""
    readings: Table
    """A row for each inertial sample."""
    fields: Table
    """A row for each new reading of the magnetometer."""
    fixes: Fixes
    fix_origin: VelocityOrigin
    stretches: tuple[Stretch, ...]
    declination: float
    """Assumed, rad; NaN where it is not known, and headings are magnetic."""
    usual_s: float
    """The median of the times between readings, s; NaN where there is one reading alone."""
    in_place: bool
    """Whether the sensor stays in place from beginning to end, and no velocity tells otherwise."""

    def rows(self, first: int, end: int) -> Readings:
        """The readings from row ``first`` to row ``end`` - 1."""
        return readings_of(self.readings.rows(first, end))


def readings_of(rows: Rows) -> Readings:
    """The columns of a table of readings."""
    return Readings(*(np.ascontiguousarray(rows[one.name]) for one in fields(Readings)))


def usual_step_s(readings: Table) -> float:
    """The median of the times between readings, s."""

    def steps() -> list[Array]:
        return [np.diff(readings.rows(max(first - 1, 0), end)["t_s"]) for first, end in readings.runs()]

    return median(steps)
