"""Which readings can be readings at all: limits beyond every sensor, once for all filters.

They keep NaN, infinity and wild numbers out of squares and low-passes; every comparison is written so that NaN fails
it. How well a reading fits the state is another question, and each filter's own.
"""

from math import isfinite
from typing import Final

from attest_mav.algebra import dot
from attest_mav.types import Mat3, Vec3

MAX_RATE: Final = 1e3
"""rad/s: no gyro measures as much."""
MAX_ACCEL: Final = 1e4
"""m/s^2: no accelerometer of a vehicle measures as much."""
MAX_FIELD: Final = 1e3
"""gauss: no magnetometer of a vehicle measures as much."""
MAX_SPEED: Final = 1e4
"""m/s: no vehicle moves as fast."""
MAX_HEADING: Final = 1e4
"""rad: a heading beyond is not an angle that somebody measured."""
MIN_HORIZONTAL_FIELD: Final = 0.1
"""Sine of the angle between field and vertical: nearer to a magnetic pole the field shows no heading."""


def is_rate(v: Vec3) -> bool:
    """True when v can be an angular rate, rad/s."""
    return dot(v, v) < MAX_RATE * MAX_RATE


def is_force(v: Vec3) -> bool:
    """True when v can be a specific force, m/s^2; a zero vector can (free fall)."""
    return dot(v, v) < MAX_ACCEL * MAX_ACCEL


def is_field(v: Vec3) -> bool:
    """True when v can be a magnetic field, gauss; a zero vector cannot."""
    return 0.0 < dot(v, v) < MAX_FIELD * MAX_FIELD


def is_velocity(v: Vec3) -> bool:
    """True when v can be a velocity, m/s."""
    return dot(v, v) < MAX_SPEED * MAX_SPEED


def is_covariance(m: Mat3) -> bool:
    """True when m can be the covariance of a vector: symmetric, no negative variance, no correlation above 1."""
    for i in range(3):
        if not (isfinite(m[i][i]) and m[i][i] >= 0.0):
            return False
        for j in range(i):
            if not (m[i][j] == m[j][i] and m[i][j] * m[i][j] <= m[i][i] * m[j][j]):
                return False
    return True


def is_heading(angle: float) -> bool:
    """True when the angle can be a heading, rad."""
    return isfinite(angle) and abs(angle) < MAX_HEADING
