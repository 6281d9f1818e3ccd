"""The smoother over a whole flight: forward and backward passes about ever better nominal motions.

The first pass finds the class of noise and, backward, a trajectory; the second has its sensor errors as nominal ones,
its lags, and the watch on the field that needs an attitude. States are kept for a block of nodes at a time: the forward
pass leaves its state at the beginning of each block, and runs over the block again before that is smoothed.
"""

from dataclasses import dataclass
from math import isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.algebra import q_conj, q_exp, q_mul
from attest_mav.filters.velocity_aided.aids.zero_motion import VELOCITY_SIGMA
from attest_mav.filters.velocity_aided.lags import nominal_fix_lag_s, nominal_mag_lag_s
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.backward import Last, Smoothed, smooth_block
from attest_mav.smoothing.field_watch import FieldWatch
from attest_mav.smoothing.forward import ForwardPass, Problem, Restart, empty_block
from attest_mav.smoothing.intervals import Intervals, Nominal, Steps, integrate, nodes_of, steps_of
from attest_mav.smoothing.iron import first_iron
from attest_mav.smoothing.measurements import Lags, field_rows, fix_rows
from attest_mav.smoothing.model import (
    FIELD_LAG,
    SIZE,
    START_SIGMA,
    UNKNOWN_SPEED,
    VELOCITY_LAG,
    A,
    B,
    S,
    State,
    first_covariance,
)
from attest_mav.smoothing.noise import CLASSES, NoiseClass
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import Array, matrices
from attest_mav.types import Quat

BLOCK: Final = 2048
"""Nodes whose states are kept at a time."""
FIX_NEAR_S: Final = 2.0
"""A fix so near to the beginning of a stretch tells the velocity there, s."""
PASSES: Final = 2
"""Backward passes."""


@dataclass(frozen=True)
class Result:
    """The last pass over a flight."""

    smoothed: Smoothed
    intervals: Intervals
    noise: NoiseClass
    lags: Lags


class Smoother:
    """The passes over one flight."""

    def __init__(self, readings: Recording, parameters: FlightParameters) -> None:
        self._readings: Final = readings
        self._parameters: Final = parameters
        self._steps: Final[Steps] = steps_of(readings, self._parameters)
        self._nodes: Final = nodes_of(readings)
        count = len(self._nodes)
        zero = np.zeros((count - 1, 3))
        self._nominal = Nominal(zero, zero, zero)
        self._lags = Lags(nominal_mag_lag_s(self._parameters), nominal_fix_lag_s(readings.fix_origin, self._parameters))
        self._starts: Final = {int(np.searchsorted(self._nodes, one.begin)): one for one in readings.stretches}
        self._smoothed: Smoothed | None = None
        self._iron: Final = first_iron(readings, parameters)
        self._watch: Final = FieldWatch(readings.in_place, parameters)
        self._noises: tuple[NoiseClass, ...] = CLASSES

    def result(self) -> Result:
        """Smooth."""
        for _ in range(PASSES):
            intervals, problem = self._problem()
            smoothed = self._pass(problem)
            self._smoothed = smoothed
            x = smoothed.x[:-1]
            self._nominal = Nominal(x[:, B], x[:, S], x[:, A])
            lags = self._lags
            self._lags = Lags(float(np.median(smoothed.x[:, FIELD_LAG])), float(np.median(smoothed.x[:, VELOCITY_LAG])))
        return Result(smoothed, intervals, self._noises[0], lags)

    def _problem(self) -> tuple[Intervals, Problem]:
        """The problem about the trajectory known so far."""
        readings, parameters = self._readings, self._parameters
        intervals = integrate(readings, self._steps, self._nodes, self._nominal, parameters)
        fixes, fields = (
            fix_rows(readings, intervals, self._lags),
            field_rows(readings, intervals, self._lags, self._iron),
        )
        known = self._smoothed
        seen = self._watch.strength_deviation(fields) if known is None else self._watch.deviation(fields, known)
        seen = np.hypot(seen, fields.iron_sigma / np.sqrt((fields.field**2).sum(axis=1)))
        declination = readings.declination if isfinite(readings.declination) else 0.0
        problem = Problem(
            intervals,
            fixes,
            fields,
            seen,
            {node: self._restart(node) for node in self._starts},
            self._zero_velocity(intervals),
            self._lags,
            declination,
            parameters,
        )
        return intervals, problem

    def _without_fixes(self) -> NDArray[np.bool_]:
        """For each node whether no fix lies near."""
        node_s, fix_s = self._readings.t_s[self._nodes], self._readings.fixes.t_s
        if not len(fix_s):
            return np.ones(len(node_s), dtype=np.bool_)
        place = np.searchsorted(fix_s, node_s)
        before = node_s - fix_s[np.maximum(place - 1, 0)]
        behind = fix_s[np.minimum(place, len(fix_s) - 1)] - node_s
        out: NDArray[np.bool_] = np.minimum(np.abs(before), np.abs(behind)) > FIX_NEAR_S
        return out

    def _zero_velocity(self, intervals: Intervals) -> Array:
        """Sigma of a zero velocity for each node, m/s: of a vehicle that stands, or moves about a place."""
        readings, nodes = self._readings, self._nodes
        without = self._without_fixes()
        place = self._parameters.place_noise / np.sqrt(np.append(intervals.dt_s[:1], intervals.dt_s))
        moving = np.where(readings.stays[nodes] & without, place, np.inf)
        out: Array = np.where(readings.at_rest[nodes] & without, VELOCITY_SIGMA, moving)
        return out

    def _restart(self, node: int) -> Restart:
        """Attitude and velocity at the beginning of a stretch."""
        readings, known = self._readings, self._smoothed
        row = int(self._nodes[node])
        attitude = matrices(np.array(self._turned_back(node))) if known is None else known.attitude[node]
        sigma = np.array(START_SIGMA)
        velocity = np.zeros(3)
        near = int(np.searchsorted(readings.fixes.t_s, readings.t_s[row]))
        if near < len(readings.fixes.t_s) and readings.fixes.t_s[near] - readings.t_s[row] < FIX_NEAR_S:
            velocity = readings.fixes.velocity[near]
        elif not readings.at_rest[row] and not readings.stays[row]:
            sigma[3:] = UNKNOWN_SPEED
        return Restart(attitude, velocity, np.diag(sigma**2))

    def _turned_back(self, node: int) -> Quat:
        """The attitude at the beginning of a stretch by that at the reading where it was aligned."""
        stretch = self._starts[node]
        turn: Quat = (1.0, 0.0, 0.0, 0.0)
        for row in range(stretch.begin + 1, stretch.aligned + 1):
            x, y, z = (0.5 * self._steps.dt_s[row] * self._steps.rate[row]).tolist()
            turn = q_mul(turn, q_exp((x, y, z)))
        return q_mul(stretch.q_nb, q_conj(turn))

    def _first(self, problem: Problem) -> State:
        """The state at the first node, for each class of noise that is left."""
        classes, restart = len(self._noises), problem.restarts[0]
        x = np.zeros((classes, SIZE))
        x[:, 3:6] = restart.velocity
        x[:, FIELD_LAG], x[:, VELOCITY_LAG] = self._own_lags()
        p = first_covariance(isfinite(self._readings.declination), self._parameters)
        p[:6, :6] = restart.covariance
        none = np.zeros(classes)
        attitude = np.tile(restart.attitude, (classes, 1, 1))
        return State(attitude, x, np.tile(p, (classes, 1, 1)), none.copy(), none.copy())

    def _own_lags(self) -> tuple[float, float]:
        """The lags before they are estimated, s."""
        return nominal_mag_lag_s(self._parameters), nominal_fix_lag_s(self._readings.fix_origin, self._parameters)

    def _pass(self, problem: Problem) -> Smoothed:
        """Forward, the choice of the class, and backward."""
        count = len(self._nodes)
        forward = self._forward(problem)
        state = self._first(problem)
        begins = list(range(0, max(count - 1, 1), BLOCK))
        kept: list[State] = []
        block = empty_block(min(BLOCK, count - 1 - begins[-1]) + 1, len(self._noises))
        for begin in begins:
            kept.append(state.rows(slice(None)))
            end = min(begin + BLOCK, count - 1)
            forward.run(state, begin, end + 1, block if begin == begins[-1] else None)
        chosen = int(np.argmax(state.likelihood))
        self._noises = (self._noises[chosen],)
        out = Smoothed(
            np.empty((count, 3, 3)), np.empty((count, SIZE)), np.empty((count, 3, 3)), np.empty((count, SIZE))
        )
        last: Last | None = smooth_block(block, chosen, None, out, begins[-1])
        forward = self._forward(problem)
        block = empty_block(BLOCK + 1, 1)
        for begin, at in zip(reversed(begins[:-1]), reversed(kept[:-1]), strict=True):
            state = at.rows(slice(chosen, chosen + 1))
            forward.run(state, begin, begin + BLOCK + 1, block)
            last = smooth_block(block, 0, last, out, begin)
        return out

    def _forward(self, problem: Problem) -> ForwardPass:
        """The forward pass with the classes that are left."""
        return ForwardPass(problem, self._noises)
