"""The error state of the smoother as one vector, its transition over an interval and its noise.

The state is that of ``velocity_aided.covariance``, in the same order: eight vectors of three.
"""

from dataclasses import dataclass
from math import radians
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.alignment.initialize import UNKNOWN_DECLINATION
from attest_mav.filters.velocity_aided.covariance_blocks import COUNT, DECLINATION, FIX_LAG, MAG_LAG, ErrorBlock
from attest_mav.filters.velocity_aided.lags import first_lag_covariance
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.intervals import Intervals
from attest_mav.smoothing.rotations import Array, cross_matrices, matrices_of_vectors, turned

SIZE: Final = 3 * COUNT
"""Number of errors."""


def block(error: ErrorBlock) -> slice:
    """The place of an error vector in the state."""
    return slice(3 * error, 3 * error + 3)


T: Final = block(ErrorBlock.ATTITUDE)
V: Final = block(ErrorBlock.VELOCITY)
B: Final = block(ErrorBlock.GYRO_BIAS)
S: Final = block(ErrorBlock.GYRO_SCALE)
A: Final = block(ErrorBlock.ACCEL_BIAS)
M: Final = block(ErrorBlock.HARD_IRON)
R: Final = block(ErrorBlock.GYRO_DRIFT)
BIAS_AXES: Final = range(B.start, B.stop)
DRIFT_AXES: Final = range(R.start, R.stop)
FIELD_LAG: Final = 3 * ErrorBlock.DELAYS + MAG_LAG
VELOCITY_LAG: Final = 3 * ErrorBlock.DELAYS + FIX_LAG
NORTH: Final = 3 * ErrorBlock.DELAYS + DECLINATION

START_SIGMA: Final = (radians(20.0), radians(20.0), radians(40.0), 3.0, 3.0, 3.0)
"""Attitude (rad) and velocity (m/s) at the beginning of a stretch. Their mean is an alignment made of the readings that
are to come, and is only the point about which the model is linear: so it counts for little."""
UNKNOWN_SPEED: Final = 30.0
"""m/s: 1-sigma of the velocity at the beginning of a stretch without a fix near it."""


@dataclass
class State:
    """Estimates for several classes of noise at one node, a row each."""

    attitude: Array
    """Body to NED, a matrix."""
    x: Array
    """The 24 components of the state; those of the attitude, which has its matrix, are zero."""
    p: Array
    """Covariance of the errors, 24 by 24."""
    disturbance: Array
    """Of the magnetic field, as a share of it, decaying."""
    likelihood: Array
    """Logarithm, of all innovations so far."""

    def rows(self, chosen: slice) -> "State":
        """Some of the classes, in arrays of their own."""
        return State(
            self.attitude[chosen].copy(),
            self.x[chosen].copy(),
            self.p[chosen].copy(),
            self.disturbance[chosen].copy(),
            self.likelihood[chosen].copy(),
        )

    def correct(self, delta: Array) -> None:
        """Take an estimated error into the state."""
        self.attitude = np.matmul(matrices_of_vectors(delta[:, T]), self.attitude)
        self.x[:, 3:] += delta[:, 3:]


def first_covariance(declination_known: bool, parameters: FlightParameters) -> Array:
    """P at the first node; attitude and velocity come with the stretch."""
    p = np.zeros((SIZE, SIZE))
    sigmas = ((B, parameters.gyro_bias_sigma), (S, parameters.gyro_scale_sigma))
    for place, sigma in (*sigmas, (A, parameters.accel_bias_sigma), (M, parameters.hard_iron)):
        p[place, place] = sigma**2 * np.eye(3)
    declination = parameters.declination_sigma if declination_known else UNKNOWN_DECLINATION
    p[R, R] = parameters.gyro_drift_sigma**2 * np.eye(3)
    p[block(ErrorBlock.DELAYS), block(ErrorBlock.DELAYS)] = first_lag_covariance(declination, parameters)
    return p


def walks(dt_s: Array, parameters: FlightParameters) -> Array:
    """Variances that the walks of the sensor errors add over each time, for all 24 errors."""
    per_second = np.zeros(SIZE)
    per_second[B] = parameters.gyro_bias_walk**2
    per_second[A] = parameters.accel_bias_walk**2 if parameters.accel_bias_sigma > 0.0 else 0.0
    per_second[M] = parameters.hard_iron_walk**2 if parameters.hard_iron > 0.0 else 0.0
    added: Array = np.multiply.outer(dt_s, per_second)
    kept = drift_kept(dt_s, parameters)
    added[:, R] = (parameters.gyro_drift_sigma**2 * (1.0 - kept**2))[:, np.newaxis]
    return added


def drift_kept(dt_s: Array, parameters: FlightParameters) -> Array:
    """Share of the gyro's drift rate that outlasts each time."""
    kept: Array = np.exp(-dt_s / parameters.gyro_drift_s)
    return kept


def motion_noise(intervals: Intervals) -> Array:
    """Covariance that the steps of each interval add to attitude and velocity, in the body axes of its first node.

    Rotations that come evenly over the interval turn half of the velocity that it gains.
    """
    turn = intervals.turn_noise[:, np.newaxis, np.newaxis]
    lever = cross_matrices(intervals.gain)
    q = np.zeros((len(lever), 6, 6))
    q[:, T, T] = turn * np.eye(3)
    q[:, V, T] = -0.5 * turn * lever
    q[:, T, V] = 0.5 * turn * lever
    q[:, V, V] = intervals.gain_noise - (turn / 3.0) * np.matmul(lever, lever)
    return q


class Prediction:
    """Takes states from node to node."""

    def __init__(self, intervals: Intervals, classes: int, parameters: FlightParameters) -> None:
        self._intervals: Final = intervals
        self._gravity_gain: Final = (parameters.gravity * intervals.dt_s).tolist()
        self._walks: Final = walks(intervals.dt_s, parameters)
        self._noise: Final = motion_noise(intervals)
        jacobian = intervals.jacobian
        dt_s = intervals.dt_s[:, np.newaxis, np.newaxis]
        by_drift = (-dt_s / 2.0 * jacobian[:, :, :3], dt_s / 3.0 * jacobian[:, :, 6:9])
        self._jacobian: Final = np.concatenate(
            (-jacobian[:, :, :6], by_drift[0], jacobian[:, :, 6:], -jacobian[:, :, :3], by_drift[1]), axis=2
        )
        """Of the turn by gyro bias, scale, drift rate; of the gain by the first two, accelerometer bias, drift rate."""
        nominal = intervals.nominal
        self._nominal: Final = np.concatenate((nominal.gyro_bias, nominal.gyro_scale, nominal.accel_bias), axis=1)
        kept = drift_kept(intervals.dt_s, parameters)
        self._drift_kept: Final[list[float]] = kept.tolist()
        self._drift_s: Final[list[float]] = (parameters.gyro_drift_s * (1.0 - kept)).tolist()
        self._phi: Final = np.zeros((classes, SIZE, SIZE))
        self._phi[:] = np.eye(SIZE)
        self._axes: Final = np.zeros((classes, 6, 6))

    def predict(self, state: State, number: int) -> Array:
        """Take the state over an interval, and give the transition of its error, which holds until the next call."""
        phi, intervals, attitude = self._phi, self._intervals, state.attitude
        off = state.x[:, 6:15] - self._nominal[number]
        jacobian = self._jacobian[number]
        drift = state.x[:, R]
        turn = turned(jacobian[:, :9], np.concatenate((off[:, :6], drift), axis=1))
        gain = turned(attitude, intervals.gain[number] + turned(jacobian[:, 9:], np.concatenate((off, drift), axis=1)))
        in_ned = np.matmul(attitude, jacobian)
        phi[:, T, 6:12], phi[:, T, R] = in_ned[:, :, :6], in_ned[:, :, 6:9]
        phi[:, V, 6:15], phi[:, V, R] = in_ned[:, :, 9:18], in_ned[:, :, 18:]
        phi[:, V, T] = -cross_matrices(gain)
        self._drift(state, phi, number)
        state.attitude = np.matmul(np.matmul(attitude, matrices_of_vectors(turn)), intervals.turn[number])
        state.x[:, V] += gain
        state.x[:, 5] += self._gravity_gain[number]
        self._propagate(state, phi, attitude, number)
        return phi

    def _drift(self, state: State, phi: Array, number: int) -> None:
        """The gyro bias drifts over an interval, and its drift rate fades."""
        phi[:, BIAS_AXES, DRIFT_AXES] = self._drift_s[number]
        phi[:, DRIFT_AXES, DRIFT_AXES] = self._drift_kept[number]
        drift = state.x[:, DRIFT_AXES]
        state.x[:, BIAS_AXES] += self._drift_s[number] * drift
        state.x[:, DRIFT_AXES] = self._drift_kept[number] * drift

    def _propagate(self, state: State, phi: Array, attitude: Array, number: int) -> None:
        """P = Phi P Phi^T + Q; attitude: at the beginning of the interval."""
        axes = self._axes
        axes[:, T, T] = axes[:, V, V] = attitude
        p = np.matmul(np.matmul(phi, state.p), np.swapaxes(phi, 1, 2))
        p[:, :6, :6] += np.matmul(np.matmul(axes, self._noise[number]), np.swapaxes(axes, 1, 2))
        p = 0.5 * (p + np.swapaxes(p, 1, 2))
        p.reshape(len(p), SIZE * SIZE)[:, :: SIZE + 1] += self._walks[number]
        state.p = p

    def restart(self, state: State, attitude: Array, velocity: Array, covariance: Array, number: int) -> Array:
        """Begin a stretch behind a gap: attitude and velocity are new, the sensor errors go on."""
        state.attitude = np.broadcast_to(attitude, state.attitude.shape).copy()
        state.x[:, V] = velocity
        phi = np.zeros_like(state.p)
        phi[:, range(6, SIZE), range(6, SIZE)] = 1.0
        self._drift(state, phi, number)
        state.p = np.matmul(np.matmul(phi, state.p), np.swapaxes(phi, 1, 2))
        state.p[:, :6, :6] = covariance
        state.p.reshape(len(state.p), SIZE * SIZE)[:, :: SIZE + 1] += self._walks[number]
        return phi
