"""Nodes of the smoother, and the motion from each to the next as the readings between them show it.

Between two nodes gyro and accelerometer are integrated in the body axes of the first one, with nominal sensor errors.
That does not depend on the attitude, so all intervals are integrated at once, and once for every pass of the filter:
the integral changes with the sensor errors by its Jacobian (preintegration: Lupton and Sukkarieh, IEEE Trans. Robotics
28, 2012; Forster et al., IEEE Trans. Robotics 33, 2017). Each step, its Jacobians and its noise are those of
``velocity_aided.prediction``.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.filters.velocity_aided.imu_memory import MAX_STEP_RATIO
from attest_mav.filters.velocity_aided.nav_state import DEADBAND_RATE
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import (
    FAST_TURN,
    HELD_SAMPLES,
    OTHER_AXES,
    SATURATED_ACCEL,
    SATURATED_RATE,
)
from attest_mav.filters.velocity_aided.reset import UNSEEN_RATE
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import Array, cross_matrices, from_vector, matrices, multiply, turned, unit

NODE_S: Final = 0.2
"""Time between two nodes, s; the next reading where they come more slowly."""


@dataclass(frozen=True)
class Nominal:
    """Sensor errors about which the motion is linear, a row for each interval."""

    gyro_bias: Array
    """rad/s."""
    gyro_scale: Array
    """1."""
    accel_bias: Array
    """m/s^2."""


@dataclass(frozen=True)
class Steps:
    """Each reading with the step that ends at it."""

    dt_s: Array
    rate: Array
    """Mean rate of the step as the gyro shows it, rad/s."""
    turn_noise: Array
    """Variance of the attitude that the step adds about each axis, beside the part that grows with the rate, rad^2."""
    unseen_accel: Array
    """Variance of the velocity that hides between two samples, over dt squared, per axis of the body, (m/s^2)^2."""


@dataclass(frozen=True)
class Intervals:
    """From each node to the next, in the body axes of the first."""

    nodes: NDArray[np.int64]
    """Rows of the readings at which the nodes are; one more than intervals."""
    is_gap: NDArray[np.bool_]
    """Nothing is known of the motion in this interval."""
    dt_s: Array
    turn: Array
    """The rotation, a matrix."""
    gain: Array
    """Integral of the specific force, m/s."""
    jacobian: Array
    """3 by 12: of the turn by gyro bias and scale, of the gain by gyro bias and scale."""
    turn_noise: Array
    """Variance of the turn about each axis, rad^2."""
    gain_noise: Array
    """Covariance of the gain, (m/s)^2."""
    nominal: Nominal
    turn_at: Array
    """For each reading the rotation since the node before it; the identity at a node."""
    gain_at: Array
    """For each reading the integral of the specific force since the node before it, m/s."""


def nodes_of(readings: Recording) -> NDArray[np.int64]:
    """The rows of the readings that are nodes: every so many of a stretch, and its last one."""
    usual_s = float(np.median(np.diff(readings.t_s))) if len(readings.t_s) > 1 else NODE_S
    every = max(1, round(NODE_S / max(usual_s, 1e-4)))
    begins = [stretch.begin for stretch in readings.stretches]
    ends = [*begins[1:], len(readings.t_s)]
    parts = [
        np.unique(np.append(np.arange(begin, end, every), end - 1)) for begin, end in zip(begins, ends, strict=True)
    ]
    return np.concatenate(parts).astype(np.int64)


def steps_of(readings: Recording, parameters: FlightParameters) -> Steps:
    """The steps of all readings; that of the first reading has no length."""
    dt_s = np.diff(readings.t_s, prepend=readings.t_s[:1])
    gyro_change = np.diff(readings.gyro, axis=0, prepend=readings.gyro[:1])
    accel_change = np.diff(readings.accel, axis=0, prepend=readings.accel[:1])
    for stretch in readings.stretches:
        gyro_change[stretch.begin] = accel_change[stretch.begin] = 0.0
        dt_s[stretch.begin] = 0.0
    gyro_bend = gyro_change - _before(gyro_change)
    accel_bend = accel_change - _before(accel_change)
    before_s = _before(dt_s)
    even = (MAX_STEP_RATIO * dt_s > before_s) & (before_s > dt_s / MAX_STEP_RATIO)
    rate = readings.gyro - 0.5 * gyro_change - np.where(even[:, np.newaxis], gyro_bend / 12.0, 0.0)
    turn_aliasing, accel_aliasing = _aliasing(readings, dt_s, gyro_bend, accel_bend, parameters)
    unseen_turn = UNSEEN_RATE * readings.gap_s
    turn_noise = (parameters.gyro_aliasing * turn_aliasing * dt_s) ** 2 + unseen_turn**2
    least = OTHER_AXES**2 * (accel_aliasing**2).sum(axis=1, keepdims=True)
    unseen_accel = parameters.accel_aliasing**2 * np.maximum(accel_aliasing**2, least)
    return Steps(dt_s, rate, turn_noise, unseen_accel)


def _before(values: Array) -> Array:
    """Each row's predecessor; zero before the first."""
    out = np.zeros_like(values)
    out[1:] = values[:-1]
    return out


def _aliasing(
    readings: Recording, dt_s: Array, gyro_bend: Array, accel_bend: Array, parameters: FlightParameters
) -> tuple[Array, Array]:
    """The largest second differences of late, of the gyro that its low-pass lets hide, and of the accelerometer."""
    fourth = (parameters.low_pass_hz * dt_s) ** 4  # as attest_mav.low_pass.aliased_share
    share = fourth / (1.0 + fourth) if parameters.low_pass_hz > 0.0 else np.ones_like(dt_s)
    bend = share * np.sqrt((gyro_bend**2).sum(axis=1))
    rate = np.sqrt((readings.gyro**2).sum(axis=1))
    hidden = np.where(rate > FAST_TURN, rate, SATURATED_RATE)
    bend = np.where(readings.saturated, hidden, bend)
    accel = np.where(readings.saturated[:, np.newaxis], SATURATED_ACCEL, np.abs(accel_bend))
    hold_s = max(parameters.aliasing_hold_s, HELD_SAMPLES * float(np.median(dt_s)))
    held = [held_largest(accel[:, axis], readings.t_s, hold_s) for axis in range(3)]
    return held_largest(bend, readings.t_s, hold_s), np.stack(held, axis=1)


def held_largest(values: Array, t_s: Array, hold_s: float) -> Array:
    """The largest value of late, each decaying with the time constant from its own time on."""
    with np.errstate(divide="ignore"):
        logarithms = np.log(values) + t_s / hold_s
    out: Array = np.exp(np.maximum.accumulate(logarithms) - t_s / hold_s)
    return out


def integrate(
    readings: Recording, steps: Steps, nodes: NDArray[np.int64], nominal: Nominal, parameters: FlightParameters
) -> Intervals:
    """The motion of all intervals."""
    return _Integration(readings, steps, nodes, nominal, parameters).result()


class _Integration:
    """All intervals, a step of each at a time."""

    def __init__(
        self,
        readings: Recording,
        steps: Steps,
        nodes: NDArray[np.int64],
        nominal: Nominal,
        parameters: FlightParameters,
    ) -> None:
        count = len(nodes) - 1
        begins = np.array([stretch.begin for stretch in readings.stretches])
        self._readings, self._steps, self._nodes, self._nominal = readings, steps, nodes, nominal
        self._parameters = parameters
        self._is_gap = np.isin(nodes[1:], begins)
        self._turn = np.zeros((count, 4))
        self._turn[:, 0] = 1.0
        self._gain = np.zeros((count, 3))
        self._jacobian = np.zeros((count, 3, 12))
        self._turn_noise = np.zeros(count)
        self._gain_noise = np.zeros((count, 3, 3))
        self._turn_at = np.zeros((len(readings.t_s), 4))
        self._turn_at[:, 0] = 1.0
        self._gain_at = np.zeros((len(readings.t_s), 3))

    def result(self) -> Intervals:
        """Integrate."""
        nodes, last = self._nodes, np.where(self._is_gap, self._nodes[:-1], self._nodes[1:])
        for number in range(int((last - nodes[:-1]).max(initial=0))):
            active = np.nonzero(nodes[:-1] + number < last)[0]
            row = nodes[active] + number + 1
            self._step(active, row)
            inner = row < last[active]
            self._turn_at[row[inner]] = self._turn[active[inner]]
            self._gain_at[row[inner]] = self._gain[active[inner]]
        dt_s = self._readings.t_s[nodes[1:]] - self._readings.t_s[nodes[:-1]]
        return Intervals(
            nodes,
            self._is_gap,
            dt_s,
            matrices(unit(self._turn)),
            self._gain,
            self._jacobian,
            self._turn_noise,
            self._gain_noise,
            self._nominal,
            self._turn_at,
            self._gain_at,
        )

    def _step(self, active: NDArray[np.int64], row: NDArray[np.int64]) -> None:
        """One step of the active intervals, which ends at these rows."""
        steps, accel, nominal = self._steps, self._readings.accel, self._nominal
        dt_s = steps.dt_s[row][:, np.newaxis]
        shown = steps.rate[row]
        rate = shown - nominal.gyro_bias[active] - nominal.gyro_scale[active] * shown
        before = matrices(self._turn[active])
        turn = multiply(self._turn[active], from_vector(rate * dt_s))
        after = matrices(turn)
        bias = nominal.accel_bias[active]
        force = turned(before, accel[row - 1] - bias) + turned(after, accel[row] - bias)
        gain = 0.5 * dt_s * force
        rotation_dt = 0.5 * dt_s[:, :, np.newaxis] * (before + after)
        speed = np.sqrt((rate**2).sum(axis=1))
        lever = np.where((speed > DEADBAND_RATE)[:, np.newaxis], rate, 0.0)
        jacobian = self._jacobian[active]
        jacobian[:, :, 0:3] += rotation_dt
        jacobian[:, :, 3:6] += rotation_dt * lever[:, np.newaxis, :]
        jacobian[:, :, 6:12] += np.matmul(cross_matrices(gain), jacobian[:, :, 0:6])
        self._jacobian[active] = jacobian
        self._turn[active] = turn
        self._gain[active] += gain
        self._add_noise(active, row, speed, rotation_dt)

    def _add_noise(self, active: NDArray[np.int64], row: NDArray[np.int64], speed: Array, rotation_dt: Array) -> None:
        """The process noise of one step at this rate, rad/s."""
        parameters, steps = self._parameters, self._steps
        white = (parameters.gyro_noise + parameters.gyro_rate_noise * speed) ** 2 * steps.dt_s[row]
        self._turn_noise[active] += white + steps.turn_noise[row]
        hidden = np.matmul(rotation_dt * steps.unseen_accel[row][:, np.newaxis, :], np.swapaxes(rotation_dt, 1, 2))
        own = parameters.accel_noise**2 * steps.dt_s[row]
        self._gain_noise[active] += hidden + own[:, np.newaxis, np.newaxis] * np.eye(3)
