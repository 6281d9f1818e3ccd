"""A faulty inertial sensor in words: which one, which axis, by how much."""

from math import degrees, radians
from typing import Final

from attest_mav.algebra import norm
from attest_mav.types import Vec3

AXES: Final = ("x", "y", "z")
ONE_AXIS: Final = 0.8
"""An axis with at least this share of the whole is named alone."""
GYRO_LEAST: Final = radians(0.5)
ACCEL_LEAST: Final = 0.25
"""rad/s and m/s^2: less is not named."""


def sensor_text(gyro: Vec3, accel: Vec3) -> str:
    """The sensor's error in words, from its offsets: gyro in rad/s, accel in m/s^2."""
    if norm(gyro) > GYRO_LEAST:
        return "gyro " + _amount(gyro, degrees(1.0), "degrees per second")
    if norm(accel) > ACCEL_LEAST:
        return "accelerometer " + _amount(accel, 1.0, "m/s^2")
    return "attitude refuted by receiver and magnetic field"


def _amount(v: Vec3, factor: float, unit: str) -> str:
    length = norm(v)
    for axis, name in enumerate(AXES):
        if abs(v[axis]) >= ONE_AXIS * length:
            return f"{name} {factor * v[axis]:+.1f} {unit} off"
    return f"{factor * length:.1f} {unit} off ({factor * v[0]:+.1f}, {factor * v[1]:+.1f}, {factor * v[2]:+.1f})"
