"""The watch on the magnetic field from both directions of time: a disturbance is known before it begins to mislead.

Strength and dip below the horizontal are compared with the usual ones; a deviation is taken, as by the live filter, as
the size of the disturbance of the heading that does not show. The dip needs the attitude, so it is watched from the
second pass on. Usual is the field of most of a flight. In place it is that of the beginning: indoors the field turns
and changes by some per cent within a metre, and north is the one of the place where the readings begin.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.aids.magnetometer import LAG_ERROR_S
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.backward import Smoothed
from attest_mav.smoothing.held_largest import HeldLargest
from attest_mav.smoothing.measurements import FieldRows
from attest_mav.smoothing.model import M
from attest_mav.smoothing.rotations import Array, turned
from attest_mav.smoothing.selection import median
from attest_mav.smoothing.tables import Rows, Table

MEMORY_S: Final = 10.0
"""A disturbance is as large as it was seen within about this time before or behind, s."""
BEGINNING_S: Final = 10.0
"""In place the field of so long is the usual one, s."""
SEEN: Final = np.dtype(
    [("t_s", "<f8"), ("length", "<f8"), ("sine", "<f8"), ("free", "<f8"), ("own", "<f8"), ("deviation", "<f8")]
)
"""A row for each reading: its instant, strength, sine of the dip, what that may deviate by, and both deviations."""


class FieldWatch:
    """The watch over the readings of a recording, for one pass."""

    def __init__(self, seen: Table, in_place: bool, parameters: FlightParameters) -> None:
        """in_place: usual is the field of the beginning, not that of most of the flight."""
        self._seen: Final = seen
        self._in_place: Final = in_place
        self._parameters: Final = parameters
        self._ends: Final = [0]

    def take(self, rows: FieldRows, smoothed: Smoothed | None) -> None:
        """See the readings of the next part. smoothed: of its nodes, None in the first pass."""
        seen = np.zeros(len(rows.t_s), SEEN)
        seen["t_s"] = rows.t_s
        free = rows.field if smoothed is None else rows.field - smoothed.x[rows.node][:, M]
        seen["length"] = np.sqrt((free**2).sum(axis=1))
        if smoothed is not None:
            then = np.matmul(smoothed.attitude[rows.node], rows.back)
            seen["sine"] = turned(then, free)[:, 2] / seen["length"]
            tilt_sigma = np.sqrt(smoothed.spread[rows.node][:, :2].sum(axis=1))
            rate = np.sqrt((rows.rate**2).sum(axis=1))
            seen["free"] = self._parameters.disturbance_free + 3.0 * tilt_sigma + LAG_ERROR_S * rate
        self._seen.write(self._ends[-1], seen)
        self._ends.append(self._ends[-1] + len(seen))

    def finish(self, knows_iron: bool) -> None:
        """All have been seen. knows_iron: their strengths are those without the iron."""
        length, sine = self._usual("length"), self._usual("sine")
        by_iron = 0.0 if knows_iron else 3.0 * self._parameters.hard_iron / length
        held = HeldLargest(MEMORY_S)
        for first, end in self._seen.runs():
            rows = self._seen.rows(first, end).copy()
            off = np.maximum(0.0, np.abs(rows["length"] / length - 1.0) - self._parameters.disturbance_free)
            dip = np.maximum(0.0, np.abs(rows["sine"] - sine) - rows["free"])
            rows["own"] = np.hypot(np.maximum(0.0, off - by_iron), dip)
            rows["deviation"] = held.take(rows["own"], rows["t_s"])
            self._seen.write(first, rows)
        held = HeldLargest(MEMORY_S)
        for first, end in reversed(list(self._seen.runs())):
            rows = self._seen.rows(first, end).copy()
            behind = held.take(rows["own"][::-1], -rows["t_s"][::-1])[::-1]
            rows["deviation"] = np.maximum(rows["deviation"], behind)
            self._seen.write(first, rows)

    def deviation(self, number: int) -> Array:
        """The deviation at the readings of a part, as a share of the field."""
        return self._part(number)["deviation"]

    def since_s(self, number: int) -> Array:
        """The time from the reading before to each one of a part, s; 0 at the first of all."""
        first = self._ends[number]
        before = self._seen.rows(max(first - 1, 0), first)["t_s"]
        t_s = np.append(before, self._part(number)["t_s"])
        return np.diff(t_s, prepend=t_s[: 1 - len(before)])

    def _part(self, number: int) -> Rows:
        return self._seen.rows(self._ends[number], self._ends[number + 1])

    def _usual(self, name: str) -> float:
        """The value of most of the readings that are the measure."""
        values = median(lambda: self._measure(name))
        return values if len(self._seen) else 1.0

    def _measure(self, name: str) -> Iterator[Array]:
        end_s = np.inf
        for first, end in self._seen.runs():
            rows = self._seen.rows(first, end)
            if self._in_place and not first:
                end_s = float(rows["t_s"][0]) + BEGINNING_S
            yield rows[name][rows["t_s"] < end_s]
