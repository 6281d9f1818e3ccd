"""The bias of the gyro from its mean while the sensor rests.

Rest is detected as in VQF (Laidig and Seel, Information Fusion 91, 2023): gyro and accelerometer stay close to their
own low-passed values for some time, and the low-passed rate is small enough to be bias. A turn that is as slow and as
steady as that is taken for rest: the detection is for what a hand holds or what stands, not for a ship under way.
"""

from math import radians
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, dot, is_finite, scale, sub
from attest_mav.low_pass import Smoothed, smoothed, steady
from attest_mav.types import Vec3

SMOOTHING_S: Final = 0.5
"""Time constant of the low-passed readings."""
STILL_GYRO: Final = radians(2.0)
"""rad/s: at rest the gyro stays this close to its low-passed value."""
STILL_ACCEL: Final = 0.5
"""m/s^2: the same for the accelerometer."""
REST_AFTER_S: Final = 1.5
"""Quiet for this long, it rests."""
MAX_BIAS: Final = radians(2.0)
"""rad/s: a steady rate above this in any axis is motion."""
MEMORY_S: Final = 10.0
"""The mean reaches over so much of the latest rest, of several rests if need be."""


@mypyc_attr(acyclic=True)
class StationaryBias:
    """What is known after a sample.

    bias: rad/s. gyro, accel: low-passed readings, rad/s and m/s^2. quiet_s: for how long they have been quiet.
    rested_s: length of the rest that the bias is the mean of; 0 before the first.
    """

    def __init__(self, bias: Vec3, gyro: Smoothed, accel: Smoothed, quiet_s: float, averaged_s: float) -> None:
        self.bias: Final = bias
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.quiet_s: Final = quiet_s
        self.averaged_s: Final = averaged_s


def initial_bias(bias: Vec3, accel: Vec3) -> StationaryBias:
    """Before the first sample, with the bias known from elsewhere (rad/s) and the mean specific force (m/s^2)."""
    return StationaryBias(bias, steady(bias), steady(accel), 0.0, 0.0)


def detect_bias(before: StationaryBias, gyro: Vec3, accel: Vec3, dt_s: float) -> StationaryBias:
    """After one more sample; one that is not finite ends a rest and is otherwise as if it had not been."""
    if not (is_finite(gyro) and is_finite(accel)):
        return StationaryBias(before.bias, before.gyro, before.accel, 0.0, before.averaged_s)
    slow_gyro = smoothed(before.gyro, gyro, dt_s, SMOOTHING_S)
    slow_accel = smoothed(before.accel, accel, dt_s, SMOOTHING_S)
    quiet_s = before.quiet_s + dt_s if _quiet(gyro, slow_gyro.value, accel, slow_accel.value) else 0.0
    if quiet_s < REST_AFTER_S:
        return StationaryBias(before.bias, slow_gyro, slow_accel, quiet_s, before.averaged_s)
    averaged_s = before.averaged_s + dt_s
    if averaged_s > MEMORY_S:
        averaged_s = MEMORY_S
    share = dt_s / averaged_s
    bias = add(before.bias, scale(sub(slow_gyro.value, before.bias), share))
    return StationaryBias(bias, slow_gyro, slow_accel, quiet_s, averaged_s)


def _quiet(gyro: Vec3, slow_gyro: Vec3, accel: Vec3, slow_accel: Vec3) -> bool:
    """True when both sensors are close to their low-passed values, and the rate is small enough for a bias."""
    off_gyro, off_accel = sub(gyro, slow_gyro), sub(accel, slow_accel)
    return (
        dot(off_gyro, off_gyro) < STILL_GYRO * STILL_GYRO
        and dot(off_accel, off_accel) < STILL_ACCEL * STILL_ACCEL
        and abs(slow_gyro[0]) < MAX_BIAS
        and abs(slow_gyro[1]) < MAX_BIAS
        and abs(slow_gyro[2]) < MAX_BIAS
    )
