"""Hard iron in place before the first pass: what the strength of the field over all directions of the body shows.

A velocity tells the iron apart from the field. Without one the field's differences from place to place, which indoors
are some per cent, look like iron to a filter that compares headings. The regression of the live filter therefore comes
first: over the whole recording, and, for iron that comes and goes, over the turns about each reading.
"""

from dataclasses import dataclass
from typing import Final

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
from attest_mav.smoothing.rotations import Array
from attest_mav.smoothing.strength_fit import FIELD_NOISE, FittedIron, StrengthFit, fitted
from attest_mav.types import Vec3

LARGEST_MISFIT: Final = 0.05
"""1. Share of the readings without it in a recording whose iron is always there."""
WINDOW_STEP: Final = 1.0
"""rad. Turn from one window to the next."""


@dataclass(frozen=True)
class Iron:
    """Hard iron before the first pass, gauss."""

    at_readings: Array
    """For each inertial sample what its magnetometer reading is corrected by."""
    uncertainty: Array
    """1-sigma of an axis of that, beyond what calibration leaves."""


def no_iron(readings: Recording) -> Iron:
    """Nothing to correct."""
    return Iron(np.zeros((len(readings.t_s), 3)), np.zeros(len(readings.t_s)))


def first_iron(readings: Recording, parameters: FlightParameters) -> Iron:
    """The iron of a recording; none where a velocity shows it."""
    rows = np.nonzero(np.isfinite(readings.field[:, 0]))[0]
    if not readings.in_place or parameters.hard_iron <= 0.0 or not len(rows):
        return no_iron(readings)
    return _Strengths(readings, rows, parameters).iron()


class _Strengths:
    """The strengths of all magnetometer readings, and the iron by them."""

    def __init__(self, readings: Recording, rows: NDArray[np.int64], parameters: FlightParameters) -> None:
        field = readings.field[rows]
        rate = np.sqrt((readings.gyro[rows] ** 2).sum(axis=1))
        since_s = np.diff(readings.t_s[rows], prepend=readings.t_s[rows[:1]])
        self._readings, self._rows, self._parameters = readings, rows, parameters
        self._first = field[0]
        self._u = field / np.sqrt((field[0] ** 2).sum())
        self._turns: NDArray[np.bool_] = rate > TURNING_RATE
        self._turn = np.where(self._turns, rate * np.minimum(since_s, LONGEST_S), 0.0)
        y = 0.5 * ((self._u**2).sum(axis=1) - 1.0)
        squares = (self._u[:, :, np.newaxis] * self._u[:, np.newaxis, :]).reshape(-1, 9)
        each = np.column_stack((np.ones_like(y), self._u, y, squares, y[:, np.newaxis] * self._u, y * y))
        self._moments = np.vstack((np.zeros(18), np.cumsum(self._turn[:, np.newaxis] * each, axis=0)))

    def iron(self) -> Iron:
        """That of the whole recording, or else that of each part of it."""
        fit = self._fit(0, len(self._rows))
        whole = self._shown(fit)
        if whole is not None and self._misfit(whole) < LARGEST_MISFIT:
            iron = np.tile(fit.strength * np.array(whole.iron), (len(self._rows), 1))
            return self._placed(iron, np.full(len(self._rows), self._sigma(fit, whole)))
        return self._in_parts()

    def _in_parts(self) -> Iron:
        """The iron of the turns about each reading."""
        iron, sigma = np.zeros_like(self._u), np.zeros(len(self._u))
        turned = np.cumsum(self._turn)
        for begin in np.arange(0.0, turned[-1], WINDOW_STEP):
            middle = begin + 0.5 * WINDOW_STEP
            low, high = np.searchsorted(turned, (middle - 0.5 * MEMORY_TURN, middle + 0.5 * MEMORY_TURN))
            fit = self._fit(int(low), int(high))
            found = self._shown(fit)
            if found is None:
                continue
            here = np.zeros_like(self._turns)
            here[np.searchsorted(turned, begin) : np.searchsorted(turned, begin + WINDOW_STEP, side="right")] = True
            here &= self._turns | self._has(found)
            iron[here] = fit.strength * np.array(found.iron)
            sigma[here] = self._sigma(fit, found)
        return self._placed(iron, sigma)

    def _fit(self, first: int, end: int) -> StrengthFit:
        """The moments of a part of the readings."""
        sums = self._moments[end] - self._moments[first]
        matrix = (_vector(sums[5:8]), _vector(sums[8:11]), _vector(sums[11:14]))
        return StrengthFit(
            _vector(self._first),
            float(sums[0]),
            _vector(sums[1:4]),
            float(sums[4]),
            matrix,
            _vector(sums[14:17]),
            float(sums[17]),
        )

    def _shown(self, fit: StrengthFit) -> FittedIron | None:
        """The iron by a fit; None where it is within what calibration leaves, or does not explain the strength."""
        found = fitted(fit)
        known = fit.strength**2 * np.array(found.covariance) + self._parameters.hard_iron**2 * np.eye(3)
        iron = fit.strength * np.array(found.iron)
        is_far = iron @ np.linalg.solve(known, iron) > SIGNIFICANT
        return found if is_far and found.unexplained < LARGEST_UNEXPLAINED else None

    def _misfit(self, found: FittedIron) -> float:
        """Share of all readings, at rest too, whose strength is not that of the field with the iron in it."""
        off = np.sqrt(((self._u - found.iron) ** 2).sum(axis=1)) - found.strength
        return float(np.mean(np.abs(off) > 2.0 * FIELD_NOISE))

    def _has(self, found: FittedIron) -> NDArray[np.bool_]:
        """For each reading whether its strength is that of the field with the iron in it."""
        with_iron = np.sqrt(((self._u - found.iron) ** 2).sum(axis=1))
        without = np.sqrt((self._u**2).sum(axis=1))
        out: NDArray[np.bool_] = np.abs(with_iron - found.strength) < np.abs(without - found.strength)
        return out

    def _sigma(self, fit: StrengthFit, found: FittedIron) -> float:
        """1-sigma of an axis, gauss."""
        return fit.strength * float(np.sqrt(np.trace(np.array(found.covariance)) / 3.0))

    def _placed(self, iron: Array, sigma: Array) -> Iron:
        """Values of the magnetometer's readings at the inertial samples."""
        out = no_iron(self._readings)
        out.at_readings[self._rows], out.uncertainty[self._rows] = iron, sigma
        return out


def _vector(v: Array) -> Vec3:
    x, y, z = v.tolist()
    return (x, y, z)
