"""Hard iron in place before the first pass: what the strength of the field over all directions of the body shows.

A velocity tells the iron apart from the field. Without one the field's differences from place to place, which indoors
are some per cent, look like iron to a filter that compares headings. The regression of the live filter therefore comes
first: over the whole recording, and, for iron that comes and goes, over the turns about each reading.
"""

from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from attest_mav.filters.velocity_aided.aids.iron_fit import (
    LARGEST_UNEXPLAINED,
    LONGEST_S,
    MEMORY_TURN,
    SIGNIFICANT,
    TURNING_RATE,
)
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import Array, vec3
from attest_mav.smoothing.strength_fit import FIELD_NOISE, FittedIron, StrengthFit, fitted
from attest_mav.smoothing.tables import RUN, Rows, Table

LARGEST_MISFIT: Final = 0.05
"""1. Share of the readings without it in a recording whose iron is always there."""
WINDOW_STEP: Final = 1.0
"""rad. Turn from one window to the next."""
IRON: Final = np.dtype([("iron", "<f8", 3), ("sigma", "<f8")])
"""A row for each magnetometer reading: gauss, and 1-sigma of an axis of it."""
SUMS: Final = np.dtype([("turn", "<f8"), ("moments", "<f8", 18)])
"""A row for each of them: the turn until then, rad, and the moments of the strengths weighed by it."""


class Iron:
    """Hard iron before the first pass; none without a table."""

    def __init__(self, table: Table | None = None) -> None:
        self._table: Final = table

    def at(self, begin: int, end: int) -> tuple[Array, Array]:
        """What some magnetometer readings are corrected by, gauss, and 1-sigma beyond what calibration leaves."""
        rows = np.zeros(end - begin, IRON) if self._table is None else self._table.rows(begin, end)
        return rows["iron"], rows["sigma"]


def first_iron(recording: Recording, parameters: FlightParameters) -> Iron:
    """The iron of a recording; none where a velocity shows it."""
    if not recording.in_place or parameters.hard_iron <= 0.0 or not len(recording.fields):
        return Iron()
    return Iron(_Strengths(recording, parameters).iron())


class _Strengths:
    """The strengths of all magnetometer readings, and the iron by them."""

    def __init__(self, recording: Recording, parameters: FlightParameters) -> None:
        self._fields: Final = recording.fields
        self._parameters: Final = parameters
        self._first: Final[Array] = recording.fields.rows(0, 1)["field"][0]
        self._iron: Final = recording.scratch.table(IRON)
        self._sums: Final = recording.scratch.table(SUMS)
        last = np.zeros(1, SUMS)
        for begin, end in self._fields.runs():
            sums = self._added(last, begin, end)
            self._sums.write(begin, sums)
            self._iron.write(begin, np.zeros(len(sums), IRON))
            last = sums[-1:]

    def _added(self, last: Rows, begin: int, end: int) -> Rows:
        """The sums at some readings by those at the reading before them."""
        u, turn = self._directions(begin, end), self._turns(begin, end)
        y = 0.5 * ((u**2).sum(axis=1) - 1.0)
        squares = (u[:, :, np.newaxis] * u[:, np.newaxis, :]).reshape(-1, 9)
        each = np.column_stack((np.ones_like(y), u, y, squares, y[:, np.newaxis] * u, y * y))
        out = np.empty(end - begin, SUMS)
        out["turn"] = np.cumsum(np.append(last["turn"], turn))[1:]
        out["moments"] = np.cumsum(np.vstack((last["moments"], turn[:, np.newaxis] * each)), axis=0)[1:]
        return out

    def _directions(self, begin: int, end: int) -> Array:
        """Some readings as a share of the strength of the first one."""
        out: Array = self._fields.rows(begin, end)["field"] / np.sqrt((self._first**2).sum())
        return out

    def _turns(self, begin: int, end: int) -> Array:
        """The turn of the sensor since the reading before each, rad; 0 where it is nearly at rest."""
        rows = self._fields.rows(max(begin - 1, 0), end)
        since_s = np.diff(rows["t_s"], prepend=rows["t_s"][:1])[-(end - begin) :]
        rate = np.sqrt((rows["gyro"][-(end - begin) :] ** 2).sum(axis=1))
        return np.where(rate > TURNING_RATE, rate * np.minimum(since_s, LONGEST_S), 0.0)

    def iron(self) -> Table:
        """That of the whole recording, or else that of each part of it."""
        fit = self._fit(0, len(self._fields))
        whole = self._shown(fit)
        if whole is not None and self._misfit(whole) < LARGEST_MISFIT:
            for begin, end in self._fields.runs():
                self._place(fit, whole, begin, np.ones(end - begin, np.bool_))
        else:
            self._place_parts()
        return self._iron

    def _place_parts(self) -> None:
        """Find the iron of the turns about each reading."""
        begins = np.arange(0.0, float(self._sums.rows(len(self._sums) - 1, len(self._sums))["turn"][0]), WINDOW_STEP)
        middle = begins + 0.5 * WINDOW_STEP
        lows, highs = self._places(middle - 0.5 * MEMORY_TURN, "left"), self._places(middle + 0.5 * MEMORY_TURN, "left")
        firsts, ends = self._places(begins, "left"), self._places(begins + WINDOW_STEP, "right")
        for low, high, first, end in zip(*(one.tolist() for one in (lows, highs, firsts, ends)), strict=True):
            fit = self._fit(low, high)
            found = self._shown(fit)
            if found is not None:
                for begin in range(first, end, RUN):
                    self._place_where_it_is(fit, found, begin, min(begin + RUN, end))

    def _places(self, turn: Array, side: Literal["left", "right"]) -> NDArray[np.int64]:
        """The number of readings until each of these turns, rad."""
        out = np.zeros(len(turn), np.int64)
        for run in self._sums.column("turn"):
            out += np.searchsorted(run, turn, side)
        return out

    def _place_where_it_is(self, fit: StrengthFit, found: FittedIron, begin: int, end: int) -> None:
        """Correct those of some readings that turn or whose strength has the iron in it."""
        u = self._directions(begin, end)
        rate = np.sqrt((self._fields.rows(begin, end)["gyro"] ** 2).sum(axis=1))
        self._place(fit, found, begin, (rate > TURNING_RATE) | _has(u, found))

    def _place(self, fit: StrengthFit, found: FittedIron, begin: int, here: NDArray[np.bool_]) -> None:
        """Correct the chosen ones of the readings from ``begin`` on."""
        rows = self._iron.rows(begin, begin + len(here)).copy()
        rows["iron"][here] = fit.strength * np.array(found.iron)
        rows["sigma"][here] = fit.strength * float(np.sqrt(np.trace(np.array(found.covariance)) / 3.0))
        self._iron.write(begin, rows)

    def _fit(self, first: int, end: int) -> StrengthFit:
        """The moments of a part of the readings."""
        sums = self._moments(end) - self._moments(first)
        matrix = (vec3(sums[5:8]), vec3(sums[8:11]), vec3(sums[11:14]))
        return StrengthFit(
            vec3(self._first),
            float(sums[0]),
            vec3(sums[1:4]),
            float(sums[4]),
            matrix,
            vec3(sums[14:17]),
            float(sums[17]),
        )

    def _shown(self, fit: StrengthFit) -> FittedIron | None:
        """The iron by a fit; None where it is within what calibration leaves, or does not explain the strength."""
        found = fitted(fit)
        known = fit.strength**2 * np.array(found.covariance) + self._parameters.hard_iron**2 * np.eye(3)
        iron = fit.strength * np.array(found.iron)
        is_far = iron @ np.linalg.solve(known, iron) > SIGNIFICANT
        return found if is_far and found.unexplained < LARGEST_UNEXPLAINED else None

    def _moments(self, count: int) -> Array:
        """The sums over so many readings."""
        out: Array = self._sums.rows(count - 1, count)["moments"][0] if count else np.zeros(18)
        return out

    def _misfit(self, found: FittedIron) -> float:
        """Share of all readings, at rest too, whose strength is not that of the field with the iron in it."""
        off = sum(
            np.count_nonzero(np.abs(_strength(self._directions(*run), found)) > 2.0 * FIELD_NOISE)
            for run in self._fields.runs()
        )
        return off / len(self._fields)


def _strength(u: Array, found: FittedIron) -> Array:
    """The strengths without the iron, less that of the field."""
    out: Array = np.sqrt(((u - found.iron) ** 2).sum(axis=1)) - found.strength
    return out


def _has(u: Array, found: FittedIron) -> NDArray[np.bool_]:
    """For each reading whether its strength is that of the field with the iron in it."""
    without = np.sqrt((u**2).sum(axis=1)) - found.strength
    out: NDArray[np.bool_] = np.abs(_strength(u, found)) < np.abs(without)
    return out
