"""The motion from each node to the next as the readings between them show it.

Between two nodes gyro and accelerometer are integrated in the body axes of the first one, with nominal sensor errors.
That does not depend on the attitude, so all intervals are integrated at once, and once for every pass of the filter:
the integral changes with the sensor errors by its Jacobian (preintegration: Lupton and Sukkarieh, IEEE Trans. Robotics
28, 2012; Forster et al., IEEE Trans. Robotics 33, 2017). Each step, its Jacobians and its noise are those of
``velocity_aided.prediction``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from attest_mav.filters.velocity_aided.nav_state import DEADBAND_RATE
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.parts import Part
from attest_mav.smoothing.rotations import Array, cross_matrices, from_vector, matrices, multiply, turned, unit


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
class Intervals:
    """From each node to the next, in the body axes of the first."""

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


def integrate(part: Part, nominal: Nominal, parameters: FlightParameters) -> Intervals:
    """The motion in all intervals of a part."""
    return _Integration(part, nominal, parameters).result()


class _Integration:
    """The intervals of a part, a step of each at a time."""

    def __init__(self, part: Part, nominal: Nominal, parameters: FlightParameters) -> None:
        count = len(part.rows) - 1
        self._part, self._nominal, self._parameters = part, nominal, parameters
        self._turn = np.zeros((count, 4))
        self._turn[:, 0] = 1.0
        self._gain = np.zeros((count, 3))
        self._jacobian = np.zeros((count, 3, 12))
        self._turn_noise = np.zeros(count)
        self._gain_noise = np.zeros((count, 3, 3))
        self._turn_at = np.zeros((len(part.readings.t_s), 4))
        self._turn_at[:, 0] = 1.0
        self._gain_at = np.zeros((len(part.readings.t_s), 3))

    def result(self) -> Intervals:
        """Integrate."""
        part, nodes = self._part, self._part.rows
        last = np.where(part.is_gap, nodes[:-1], nodes[1:])
        for number in range(int((last - nodes[:-1]).max(initial=0))):
            active = np.nonzero(nodes[:-1] + number < last)[0]
            row = nodes[active] + number + 1
            self._step(active, row)
            inner = row < last[active]
            self._turn_at[row[inner]] = self._turn[active[inner]]
            self._gain_at[row[inner]] = self._gain[active[inner]]
        return Intervals(
            np.diff(part.node_s),
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
        steps, accel, nominal = self._part.steps, self._part.readings.accel, self._nominal
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
        parameters, steps = self._parameters, self._part.steps
        white = (parameters.gyro_noise + parameters.gyro_rate_noise * speed) ** 2 * steps.dt_s[row]
        self._turn_noise[active] += white + steps.turn_noise[row]
        hidden = np.matmul(rotation_dt * steps.unseen_accel[row][:, np.newaxis, :], np.swapaxes(rotation_dt, 1, 2))
        own = parameters.accel_noise**2 * steps.dt_s[row]
        self._gain_noise[active] += hidden + own[:, np.newaxis, np.newaxis] * np.eye(3)
