"""True motions of the scenarios, sampled: attitude, body rate and specific force without sensor errors.

Arrays have one row a sample; vectors have shape (n, 3) and quaternions (n, 4), as in ``attest_mav.types``. A motion
begins at time 0 with the attitude ``start``; row k is the instant (k + 1) dt.

The papers define their motions by sampled angles, some of them random, and their gyros by the mean rate of an interval;
``attest_mav.sim`` has motions that are functions of time with exact derivatives, for messages at any rate. Neither can
be made of the other without changing the papers' figures, and each is a check of the other's filters.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from math import exp, radians, sqrt

import numpy as np
import numpy.typing as npt

from attest_mav.types import G_MPS2, Quat

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Wave:
    """One sinusoid of an angle: amplitude in degrees, period in seconds."""

    amplitude_deg: float
    period_s: float


@dataclass(frozen=True, eq=False)
class Motion:
    """A sampled true motion.

    dt_s: sampling interval. start: attitude at time 0. q_nb: attitude at each sample, sign-continuous. rate: mean body
    rate over the interval that ends at the sample, rad/s. force: specific force at the sample, body, m/s^2.
    """

    dt_s: float
    start: Quat
    q_nb: Array
    rate: Array
    force: Array

    @property
    def time_s(self) -> Array:
        """Time of each sample since the start, s."""
        return np.arange(1, len(self.q_nb) + 1) * np.float64(self.dt_s)


def motion(angles: tuple[Array, Array, Array], acceleration: Array, dt_s: float) -> Motion:
    """The motion through the given Euler angles.

    angles: roll, pitch and yaw, rad, each shape (n + 1,), from time 0. acceleration: NED, m/s^2, shape (n + 1, 3).
    """
    q = euler_to_quaternion(*angles)
    gravity = np.array([0.0, 0.0, G_MPS2])
    return Motion(
        dt_s=dt_s,
        start=(float(q[0, 0]), float(q[0, 1]), float(q[0, 2]), float(q[0, 3])),
        q_nb=q[1:],
        rate=mean_rate(q, dt_s),
        force=to_body(q[1:], acceleration[1:] - gravity),
    )


def times(duration_s: float, rate_hz: float) -> Array:
    """0, dt, ... up to and with the duration, s: what an angle is computed at."""
    return np.arange(round(duration_s * rate_hz) + 1) / rate_hz


def waves(t: Array, parts: Sequence[Wave], rng: np.random.Generator) -> Array:
    """Sum of the sinusoids at times t, each with a phase drawn uniformly; rad."""
    phases = rng.uniform(0.0, 2.0 * np.pi, len(parts))
    total = np.zeros(len(t))
    for part, phase in zip(parts, phases, strict=True):
        total += radians(part.amplitude_deg) * np.sin(2.0 * np.pi * t / part.period_s + phase)
    return total


def gauss_markov(shape: tuple[int, int], rms: float, tau_s: float, dt_s: float, rng: np.random.Generator) -> Array:
    """First-order Gauss-Markov columns of that stationary rms and correlation time, each with its mean removed."""
    keep = exp(-dt_s / tau_s)
    white = rms * rng.standard_normal(shape)
    white[1:] *= sqrt(1.0 - keep * keep)
    columns = [list(accumulate(column, lambda x, w: keep * x + w)) for column in white.T.tolist()]
    values: Array = np.array(columns).T
    values -= values.mean(axis=0)
    return values


def euler_to_quaternion(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Quaternions of the yaw-pitch-roll sequence, sign-continuous, shape (n, 4)."""
    cr, sr = np.cos(0.5 * roll), np.sin(0.5 * roll)
    cp, sp = np.cos(0.5 * pitch), np.sin(0.5 * pitch)
    cy, sy = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    # Angles that are continuous make half angles that are: no sign can jump.
    return np.column_stack(
        (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )
    )


def multiply(a: Array, b: Array) -> Array:
    """Hamilton products a * b, row by row."""
    aw, ax, ay, az = a.T
    bw, bx, by, bz = b.T
    return np.column_stack(
        (
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        )
    )


def conjugate(q: Array) -> Array:
    """Conjugates, row by row."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def mean_rate(q: Array, dt_s: float) -> Array:
    """The constant body rate that turns each attitude into the next within dt_s, rad/s; q (n + 1, 4) gives (n, 3)."""
    turn = multiply(conjugate(q[:-1]), q[1:])
    vector, length = turn[:, 1:], np.linalg.norm(turn[:, 1:], axis=1)
    # angle = 2 atan2(|v|, w); for no turn at all the limit of angle / |v| is 2.
    ratio = np.where(length > 0.0, 2.0 * np.arctan2(length, turn[:, 0]) / np.where(length > 0.0, length, 1.0), 2.0)
    rate: Array = vector * ratio[:, np.newaxis] / dt_s
    return rate


def to_body(q: Array, v_ned: Array) -> Array:
    """conj(q) * v * q row by row: NED vectors, shape (n, 3) or (3,), in body axes."""
    v = np.broadcast_to(v_ned, (len(q), 3))
    pure = np.column_stack((np.zeros(len(q)), v))
    return multiply(multiply(conjugate(q), pure), q)[:, 1:]
