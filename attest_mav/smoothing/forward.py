"""The forward pass: the Kalman filter over the nodes, for several classes of noise at once.

It differs from the live filter in the instants of its measurements, in priors and in that its noise is that of a class.
It is as robust: a fix outside the gate has its variance inflated until it lies on it, and that of a magnetometer
reading grows with its residual and with a disturbance of the field. All measurements of a node are linear about its
prediction.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.nav_state import DEADBAND_ACCEL, DEADBAND_RATE
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.intervals import Intervals
from attest_mav.smoothing.measurements import FieldRows, FixRows, Lags
from attest_mav.smoothing.model import FIELD_LAG, NORTH, SIZE, VELOCITY_LAG, A, M, Prediction, State, T, V
from attest_mav.smoothing.noise import LARGEST_SQUARE, LASTING_FIELD, LASTING_VELOCITY, SHARE, NoiseClass
from attest_mav.smoothing.rotations import Array, cross_matrices, turned

PLACE_GATE: Final = 2.0
"""sigmas: a velocity assumed to be zero is inflated from here on."""


@dataclass(frozen=True)
class Restart:
    """The beginning of a stretch: attitude and velocity are new, the sensor errors go on."""

    attitude: Array
    """Body to NED, a matrix."""
    velocity: Array
    """NED, m/s."""
    covariance: Array
    """Of attitude and velocity, 6 by 6."""


@dataclass(frozen=True)
class Problem:
    """Everything that a forward pass reads over a part. Nodes are counted from the first one of it."""

    intervals: Intervals
    fixes: FixRows
    fields: FieldRows
    deviation: Array
    """For each magnetometer reading the deviation of the field that is known beforehand, as a share of it."""
    since_s: Array
    """For each of them the time from the one before, s."""
    restarts: dict[int, Restart]
    """By node."""
    zero_velocity: Array
    """For each node sigma of a velocity assumed to be zero, m/s; infinite where nothing is assumed."""
    lags: Lags
    declination: float
    """Assumed, rad."""
    parameters: FlightParameters


@dataclass
class Block:
    """The states of the nodes of a part, for one pass over them. Predicted: before the node's measurements."""

    attitude: Array
    x: Array
    p: Array
    predicted_attitude: Array
    x_predicted: Array
    p_predicted: Array
    phi: Array
    """Transition from the node before; zero rows for attitude and velocity at the beginning of a stretch."""


def empty_block(nodes: int, classes: int) -> Block:
    """Room for the states of so many nodes."""
    shape = (nodes, classes)
    matrix, square = (*shape, 3, 3), (*shape, SIZE, SIZE)
    vector = (*shape, SIZE)
    return Block(
        np.empty(matrix),
        np.empty(vector),
        np.empty(square),
        np.empty(matrix),
        np.empty(vector),
        np.empty(square),
        np.empty(square),
    )


class ForwardPass:
    """The filter over the problem of a part, with the noises of some classes."""

    def __init__(self, problem: Problem, noises: tuple[NoiseClass, ...]) -> None:
        self._problem: Final = problem
        self._velocity: Final = np.array([LASTING_VELOCITY * one.velocity**2 for one in noises])
        self._field: Final = np.array([LASTING_FIELD * one.field**2 for one in noises])
        self._is_choice: Final = len(noises) > 1
        self._prediction: Final = Prediction(problem.intervals, len(noises), problem.parameters)
        self._nodes: Final = len(problem.intervals.dt_s) + 1
        nodes = np.arange(self._nodes)
        self._fix_ends: Final[list[int]] = np.searchsorted(problem.fixes.node, nodes, side="right").tolist()
        self._field_ends: Final[list[int]] = np.searchsorted(problem.fields.node, nodes, side="right").tolist()
        gone_s = np.maximum(problem.since_s, 0.0)
        self._fading: Final[list[float]] = np.exp(-gone_s / problem.parameters.disturbance_hold_s).tolist()
        self._turns: Final[list[bool]] = ((problem.fields.rate**2).sum(axis=1) > DEADBAND_RATE**2).tolist()
        self._zero_sigma: Final[list[float]] = problem.zero_velocity.tolist()
        self._delta = np.zeros((len(noises), SIZE))

    def run(self, state: State, block: Block | None = None) -> None:
        """Take the state at the first node to the last; block: keeps the states of all.

        The prediction of the first node stays empty.
        """
        if block is not None:
            block.attitude[0], block.x[0], block.p[0] = state.attitude, state.x, state.p
        for node in range(1, self._nodes):
            phi = self._predict(state, node)
            if block is not None:
                block.phi[node] = phi
                block.predicted_attitude[node], block.x_predicted[node] = state.attitude, state.x
                block.p_predicted[node] = state.p
            self._measure(state, node)
            if block is not None:
                block.attitude[node], block.x[node], block.p[node] = state.attitude, state.x, state.p

    def _predict(self, state: State, node: int) -> Array:
        restart = self._problem.restarts.get(node)
        if restart is None:
            return self._prediction.predict(state, node - 1)
        return self._prediction.restart(state, restart.attitude, restart.velocity, restart.covariance, node - 1)

    def _measure(self, state: State, node: int) -> None:
        """Take the measurements of a node."""
        fixes = range(self._fix_ends[node - 1], self._fix_ends[node])
        first, end = self._field_ends[node - 1], self._field_ends[node]
        sigma = self._zero_sigma[node]
        if not fixes and first == end and sigma == np.inf:
            return
        self._delta = np.zeros_like(state.x)
        for row in fixes:
            self._take_fix(state, row)
        if first < end:
            self._take_fields(state, first, end)
        if sigma < np.inf:
            self._take_zero_velocity(state, sigma)
        state.correct(self._delta)

    def _take_zero_velocity(self, state: State, sigma: float) -> None:
        h = np.zeros((len(state.x), 3, SIZE))
        h[:, range(3), range(3, 6)] = 1.0
        self._fuse_vector(state, -state.x[:, V], h, np.full((len(state.x), 1), sigma**2), PLACE_GATE)

    def _take_fix(self, state: State, row: int) -> None:
        """The residual of a fix and its Jacobian, as ``velocity_measurement`` of the live filter has them."""
        fixes, problem = self._problem.fixes, self._problem
        gravity, age_s = problem.parameters.gravity, float(fixes.age_s[row])
        off = state.x[:, A] - fixes.nominal_bias[row]
        accel = turned(state.attitude, fixes.force[row] - off)
        accel[:, 2] += gravity
        square = (accel * accel).sum(axis=1)
        jitter = problem.parameters.fix_jitter_s**2 * square
        accel *= (square > DEADBAND_ACCEL**2)[:, np.newaxis]
        gain = turned(state.attitude, fixes.gain[row] - off * age_s)
        axes = int(fixes.axes[row])
        h = np.zeros((len(state.x), axes, SIZE))
        h[:, :, T] = cross_matrices(gain)[:, :axes]
        h[:, range(axes), range(3, 3 + axes)] = 1.0
        h[:, :, VELOCITY_LAG] = -accel[:, :axes]
        late_s = state.x[:, VELOCITY_LAG : VELOCITY_LAG + 1] - problem.lags.fix_s
        residual = fixes.velocity[row] - state.x[:, V] + gain + accel * late_s
        residual[:, 2] += gravity * age_s
        variance = (np.maximum(self._velocity, fixes.reported[row]) + jitter)[:, np.newaxis]
        self._fuse_vector(state, residual[:, :axes], h, variance, problem.parameters.velocity_gate)

    def _fuse_vector(self, state: State, residual: Array, h: Array, variance: Array, gate: float) -> None:
        """The Kalman update by a vector whose components are inflated to the gate, each on its own."""
        residual = residual - turned(h, self._delta)
        ph = np.matmul(state.p, np.swapaxes(h, 1, 2))
        own = np.matmul(h, ph)
        size = own.shape[1]
        diagonal = own.reshape(len(own), size * size)[:, :: size + 1]
        if self._is_choice:
            shown = own + (variance / LASTING_VELOCITY)[:, :, np.newaxis] * np.eye(size)
            inverse = np.linalg.inv(shown)
            square = np.minimum((residual * turned(inverse, residual)).sum(axis=1), LARGEST_SQUARE * size)
            state.likelihood -= 0.5 * SHARE * (square - np.log(np.linalg.det(inverse)))
        diagonal += np.maximum(variance, (residual / gate) ** 2 - diagonal)
        gain = np.matmul(ph, np.linalg.inv(own))
        state.p = state.p - np.matmul(gain, np.swapaxes(ph, 1, 2))
        self._delta += turned(gain, residual)

    def _take_fields(self, state: State, first: int, end: int) -> None:
        """Residuals of a node's magnetometer readings and their Jacobians, as ``levelled_field`` has them.

        The residual is the field along magnetic east, which is zero in truth.
        """
        problem, fields = self._problem, self._problem.fields
        then = np.matmul(state.attitude[:, np.newaxis], fields.back[first:end])
        free = fields.field[first:end] - state.x[:, np.newaxis, M]
        scale = 1.0 / np.sqrt((free * free).sum(axis=2))[:, :, np.newaxis]
        moved = scale * turned(np.matmul(then, fields.turning[first:end]), free)
        late_s = (state.x[:, FIELD_LAG] - problem.lags.field_s)[:, np.newaxis, np.newaxis]
        direction = scale * turned(then, free) - late_s * moved
        north = problem.declination + state.x[:, NORTH]
        east = np.zeros((len(north), 1, 3))
        east[:, 0, 0], east[:, 0, 1] = -np.sin(north), np.cos(north)
        h = np.zeros((len(north), end - first, SIZE))
        h[:, :, T] = turned(cross_matrices(direction), np.broadcast_to(east, direction.shape))
        h[:, :, M] = -scale * np.matmul(east[:, :, np.newaxis], then)[:, :, 0]
        h[:, :, NORTH] = direction[:, :, 0] * -east[:, :, 1] + direction[:, :, 1] * east[:, :, 0]
        h[:, :, FIELD_LAG] = -(east * moved).sum(axis=2)
        residual = -(east * direction).sum(axis=2)
        for row in range(first, end):
            one = h[:, row - first]
            if not self._turns[row]:
                one[:, FIELD_LAG] = 0.0
            state.disturbance = state.disturbance * self._fading[row]
            self._fuse_field(state, residual[:, row - first], one, float(problem.deviation[row]))

    def _fuse_field(self, state: State, residual: Array, h: Array, deviation: float) -> None:
        parameters = self._problem.parameters
        residual = residual - (h * self._delta).sum(axis=1)
        ph = turned(state.p, h)
        own = (h * ph).sum(axis=1)
        nominal = self._field + (parameters.mag_jitter_s * h[:, FIELD_LAG]) ** 2
        normalised = np.abs(residual) / np.sqrt(own + nominal)
        seen = np.where(normalised < parameters.mag_gate, 0.0, np.abs(residual))
        state.disturbance = np.maximum(state.disturbance, seen)
        disturbed = (parameters.disturbance_weight * np.maximum(state.disturbance, deviation)) ** 2
        if self._is_choice:
            shown = own + nominal / LASTING_FIELD + disturbed
            square = np.minimum(residual**2 / shown, LARGEST_SQUARE)
            state.likelihood -= 0.5 * SHARE * (square + np.log(shown))
        variance = nominal * np.maximum(1.0, normalised / parameters.mag_knee) + disturbed
        gain = ph / (own + variance)[:, np.newaxis]
        state.p = state.p - gain[:, :, np.newaxis] * ph[:, np.newaxis, :]
        self._delta += gain * residual[:, np.newaxis]
