"""The parts of a flight as problems of the forward pass, linear about the trajectory that the pass before has found."""

from math import isfinite
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.backward import Smoothed, smoothed_of
from attest_mav.smoothing.field_watch import SEEN, FieldWatch
from attest_mav.smoothing.forward import Problem
from attest_mav.smoothing.intervals import Intervals, Nominal, integrate
from attest_mav.smoothing.iron import Iron
from attest_mav.smoothing.measurements import FieldRows, Lags, field_rows, fix_rows
from attest_mav.smoothing.model import A, B, S
from attest_mav.smoothing.parts import Part, Parts
from attest_mav.smoothing.starts import Starts
from attest_mav.smoothing.tables import Table


class Motion:
    """A part, its intervals and the magnetometer readings in them."""

    def __init__(self, number: int, part: Part, intervals: Intervals, fields: FieldRows) -> None:
        self.number: Final = number
        self.part: Final = part
        self.intervals: Final = intervals
        self.fields: Final = fields


class Problems:
    """The problems of one pass, in order of time. Each is made when it is asked for."""

    def __init__(
        self, parts: Parts, parameters: FlightParameters, starts: Starts, iron: Iron, lags: Lags, known: Table | None
    ) -> None:
        """known: the smoothed states of the pass before; None in the first one."""
        self.parts: Final = parts
        self.lags: Final = lags
        self._parameters: Final = parameters
        self._starts: Final = starts
        self._iron: Final = iron
        self._known: Final = known
        self._last: Motion | None = None
        recording = parts.recording
        self._watch: Final = FieldWatch(recording.scratch.table(SEEN), recording.in_place, parameters)
        for number in range(len(parts)):
            self._watch.take(self.motion(number).fields, self._smoothed(self.motion(number).part))
        self._watch.finish(knows_iron=known is not None)

    def motion(self, number: int) -> Motion:
        """The motion in a part; the last one that was asked for is kept."""
        if self._last is None or self._last.number != number:
            self._last = None
            recording, part = self.parts.recording, self.parts[number]
            intervals = integrate(part, self._nominal(part), self._parameters)
            fields = field_rows(part, intervals, recording.fields, self.lags, self._iron)
            self._last = Motion(number, part, intervals, fields)
        return self._last

    def problem(self, number: int) -> Problem:
        """The problem of a part."""
        motion, recording = self.motion(number), self.parts.recording
        part, intervals, fields = motion.part, motion.intervals, motion.fields
        iron_share = fields.iron_sigma / np.sqrt((fields.field**2).sum(axis=1))
        return Problem(
            intervals,
            fix_rows(part, intervals, recording.fixes, self.lags),
            fields,
            np.hypot(self._watch.deviation(number), iron_share),
            self._watch.since_s(number),
            self._starts.restarts(part, self._known),
            self._starts.zero_velocity(part, intervals.dt_s),
            self.lags,
            recording.declination if isfinite(recording.declination) else 0.0,
            self._parameters,
        )

    def _smoothed(self, part: Part) -> Smoothed | None:
        """The states of the pass before at the nodes of a part."""
        if self._known is None:
            return None
        return smoothed_of(self._known.rows(part.first, part.first + len(part.rows)))

    def _nominal(self, part: Part) -> Nominal:
        """The sensor errors of the pass before in the intervals of a part."""
        known = self._smoothed(part)
        if known is None:
            zero = np.zeros((len(part.rows) - 1, 3))
            return Nominal(zero, zero, zero)
        x = known.x[:-1]
        return Nominal(x[:, B], x[:, S], x[:, A])
