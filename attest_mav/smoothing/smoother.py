"""The smoother over a whole flight: forward and backward passes about ever better nominal motions.

The first pass finds the class of noise and, backward, a trajectory; the second has its sensor errors as nominal ones,
its lags, and the watch on the field that needs an attitude. States are kept for a part at a time: the forward pass
leaves its state at the beginning of each part, and runs over the part again before that is smoothed.
"""

from dataclasses import dataclass
from math import isfinite
from typing import Final

import numpy as np

from attest_mav.filters.calibration import SensorErrors, UncertainVector
from attest_mav.filters.velocity_aided.calibration import has_left
from attest_mav.filters.velocity_aided.lags import nominal_fix_lag_s, nominal_mag_lag_s
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.backward import NODE, Last, smooth_block, smoothed_of
from attest_mav.smoothing.forward import ForwardPass, empty_block
from attest_mav.smoothing.iron import first_iron
from attest_mav.smoothing.measurements import Lags
from attest_mav.smoothing.model import FIELD_LAG, SIZE, VELOCITY_LAG, A, M, State, first_covariance
from attest_mav.smoothing.noise import CLASSES, NoiseClass
from attest_mav.smoothing.parts import Parts
from attest_mav.smoothing.problems import Problems
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import Array, vec3
from attest_mav.smoothing.selection import median
from attest_mav.smoothing.starts import Starts
from attest_mav.smoothing.tables import Table
from attest_mav.types import Mat3

PASSES: Final = 2
"""Backward passes."""
Begun = tuple[tuple[slice, UncertainVector], ...]
"""Errors that earlier flights have shown, each with its place in the state."""


@dataclass(frozen=True)
class Result:
    """A pass over a flight."""

    smoothed: Table
    """The states at the nodes."""
    problems: Problems
    noise: NoiseClass
    has_refuted: bool
    """Whether the flight contradicts what was known of the sensor, which then was not used."""


class Smoother:
    """The passes over one flight."""

    def __init__(self, parts: Parts, parameters: FlightParameters, known: SensorErrors | None = None) -> None:
        """known: errors of the sensor by earlier flights, at the start of this one; None for those of any sensor."""
        self._parts: Final = parts
        self._recording: Final = parts.recording
        self._parameters: Final = parameters
        self._starts: Final = Starts(parts, parameters)
        self._iron: Final = first_iron(parts.recording, parameters)
        self._begun = () if known is None else _begun_with(known, parts.recording)
        self._has_refuted = False
        self._noises: tuple[NoiseClass, ...] = CLASSES

    def result(self) -> Result:
        """Smooth."""
        result = self._pass(self._own_lags(), None)
        if _is_refuted(result.smoothed, self._begun):
            self._begun, self._has_refuted, self._noises = (), True, CLASSES
            result = self._pass(self._own_lags(), None)
        for _ in range(1, PASSES):
            result = self._pass(_lags_of(result.smoothed), result.smoothed)
        return result

    def _own_lags(self) -> Lags:
        """The lags before they are estimated."""
        parameters = self._parameters
        return Lags(nominal_mag_lag_s(parameters), nominal_fix_lag_s(self._recording.fix_origin, parameters))

    def _first(self, problems: Problems) -> State:
        """The state at the first node, for each class of noise that is left."""
        classes, restart = len(self._noises), problems.problem(0).restarts[0]
        x = np.zeros((classes, SIZE))
        x[:, 3:6] = restart.velocity
        lags = self._own_lags()
        x[:, FIELD_LAG], x[:, VELOCITY_LAG] = lags.field_s, lags.fix_s
        p = first_covariance(isfinite(self._recording.declination), self._parameters)
        for place, error in self._begun:
            x[:, place], p[place, place] = error.mean, error.covariance
        p[:6, :6] = restart.covariance
        none = np.zeros(classes)
        attitude = np.tile(restart.attitude, (classes, 1, 1))
        return State(attitude, x, np.tile(p, (classes, 1, 1)), none.copy(), none.copy())

    def _pass(self, lags: Lags, known: Table | None) -> Result:
        """Forward, and backward with the class of noise that is the likeliest in the end.

        known: the smoothed states of the pass before, None in the first one.
        """
        problems = Problems(self._parts, self._parameters, self._starts, self._iron, lags, known)
        begins = [self._first(problems)]
        for number in range(len(self._parts) - 1):
            state = begins[-1].rows(slice(None))
            ForwardPass(problems.problem(number), self._noises).run(state)
            begins.append(state)
        smoothed = self._recording.scratch.table(NODE)
        last: Last | None = None
        for number in reversed(range(len(begins))):
            state, problem = begins[number], problems.problem(number)
            block = empty_block(len(problem.intervals.dt_s) + 1, len(self._noises))
            ForwardPass(problem, self._noises).run(state, block)
            chosen = int(np.argmax(state.likelihood))
            if last is None:
                self._noises = (self._noises[chosen],)
                begins = [one.rows(slice(chosen, chosen + 1)) for one in begins]
            rows, last = smooth_block(block, chosen, last)
            del block
            smoothed.write(self._parts.first(number), rows)
        return Result(smoothed, problems, self._noises[0], self._has_refuted)


def _begun_with(known: SensorErrors, recording: Recording) -> Begun:
    """The errors to begin with. In place the regression has taken the iron off the readings."""
    accel, iron = (A, known.accel_bias), (M, known.hard_iron)
    return (accel,) if recording.in_place else (accel, iron)


def _is_refuted(smoothed: Table, begun: Begun) -> bool:
    """Whether the first of the smoothed states contradicts the errors that it began with."""
    first = smoothed_of(smoothed.rows(0, 1))
    return any(has_left(vec3(first.x[0, place]), _diagonal(first.spread[0, place]), error) for place, error in begun)


def _diagonal(v: Array) -> Mat3:
    x, y, z = v.tolist()
    return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))


def _lags_of(smoothed: Table) -> Lags:
    """The lags that a pass has found."""
    field_s, fix_s = (_median_of(smoothed, place) for place in (FIELD_LAG, VELOCITY_LAG))
    return Lags(field_s, fix_s)


def _median_of(smoothed: Table, place: int) -> float:
    """The median of a component of the states."""
    return median(lambda: (x[:, place] for x in smoothed.column("x")))
