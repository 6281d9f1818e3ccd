"""Whether an inertial sensor is still: the two tests that all stationary detectors are made of, limits as parameters.

``is_near`` compares with running means and finds a vehicle that stands in any attitude, whatever its biases are; it
takes a constant motion for rest. ``is_unaccelerated`` compares with no rotation and one g and needs no history, but
readings without much bias. The detectors differ in what they remember, because they serve different ends: the
gradient-descent option averages with VQF's low-pass and learns a bias, the flight filter's has a short memory and a
speed, the lane's has hysteresis, and each kind of alignment collects its own means. (Groves, Principles of GNSS,
Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 15.3.1, compares such tests.)
"""

from math import radians
from typing import Final

from attest_mav.algebra import dot, norm, sub
from attest_mav.types import Vec3

MAX_GYRO_BIAS: Final = radians(2.0)
"""rad/s: a steady rate above this is motion, not a gyro's bias."""


class StillnessLimits:
    """How much the readings of a sensor at rest may differ from what they are compared with."""

    def __init__(self, rate: float, accel: float) -> None:
        self.rate: Final = rate
        """rad/s."""
        self.accel: Final = accel
        """m/s^2."""


def is_near(gyro: Vec3, accel: Vec3, mean_gyro: Vec3, mean_accel: Vec3, limits: StillnessLimits) -> bool:
    """True when gyro (rad/s) and accelerometer (m/s^2) are close to their means."""
    off_gyro, off_accel = sub(gyro, mean_gyro), sub(accel, mean_accel)
    return (
        dot(off_gyro, off_gyro) < limits.rate * limits.rate and dot(off_accel, off_accel) < limits.accel * limits.accel
    )


def is_unaccelerated(gyro: Vec3, accel: Vec3, gravity: float, limits: StillnessLimits, factor: float = 1.0) -> bool:
    """True when the sensor neither turns nor accelerates; gyro without its bias, rad/s; accel, gravity: m/s^2.

    factor: on both limits.
    """
    return norm(gyro) < factor * limits.rate and abs(norm(accel) - gravity) < factor * limits.accel
