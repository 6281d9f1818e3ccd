"""The bias of the gyro from its mean while the sensor is stationary.

Detected as in VQF (Laidig and Seel, Information Fusion 91, 2023): gyro and accelerometer stay close to their own
low-passed values for some time, and the low-passed rate is small enough to be bias. A turn that is as slow and as
steady as that is taken for rest: the detection is for what a hand holds or what stands, not for a ship under way.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, is_finite, scale, sub
from attest_mav.filters.stationary import MAX_GYRO_BIAS, StillnessLimits, is_near
from attest_mav.low_pass import Smoothed, smoothed, steady
from attest_mav.record import Record
from attest_mav.types import Vec3

SMOOTHING_S: Final = 0.5
"""Time constant of the low-passed readings, s."""
LIMITS: Final = StillnessLimits(rate=MAX_GYRO_BIAS, accel=0.5)
"""At rest the readings stay this close to their low-passed values."""
STILL_S: Final = 1.5
"""Quiet for this long, the sensor is stationary, s."""
MEMORY_S: Final = 10.0
"""Length of the latest stationary time that the mean is made of, s; of several times if need be."""


@mypyc_attr(acyclic=True)
class StationaryBias(Record):
    """Detector and bias after a sample."""

    def __init__(self, bias: Vec3, gyro: Smoothed, accel: Smoothed, quiet_s: float, averaged_s: float) -> None:
        self.bias: Final = bias
        """rad/s."""
        self.gyro: Final = gyro
        """Low-passed gyro, rad/s."""
        self.accel: Final = accel
        """Low-passed accelerometer, m/s^2."""
        self.quiet_s: Final = quiet_s
        """For how long both have been quiet, s."""
        self.averaged_s: Final = averaged_s
        """Length of the stationary time that the bias is the mean of, s; 0 before the first."""


def initial_bias(bias: Vec3, accel: Vec3) -> StationaryBias:
    """Before the first sample, with the bias known from elsewhere (rad/s) and the mean specific force (m/s^2)."""
    return StationaryBias(bias, steady(bias), steady(accel), 0.0, 0.0)


def detect_bias(before: StationaryBias, gyro: Vec3, accel: Vec3, dt_s: float) -> StationaryBias:
    """After one more sample; one that is not finite ends the stationary time and has no other effect."""
    if not (is_finite(gyro) and is_finite(accel)):
        return StationaryBias(before.bias, before.gyro, before.accel, 0.0, before.averaged_s)
    slow_gyro = smoothed(before.gyro, gyro, dt_s, SMOOTHING_S)
    slow_accel = smoothed(before.accel, accel, dt_s, SMOOTHING_S)
    quiet = is_near(gyro, accel, slow_gyro.value, slow_accel.value, LIMITS) and _can_be_bias(slow_gyro.value)
    quiet_s = before.quiet_s + dt_s if quiet else 0.0
    if quiet_s < STILL_S:
        return StationaryBias(before.bias, slow_gyro, slow_accel, quiet_s, before.averaged_s)
    averaged_s = before.averaged_s + dt_s
    if averaged_s > MEMORY_S:
        averaged_s = MEMORY_S
    share = dt_s / averaged_s
    bias = add(before.bias, scale(sub(slow_gyro.value, before.bias), share))
    return StationaryBias(bias, slow_gyro, slow_accel, quiet_s, averaged_s)


def _can_be_bias(rate: Vec3) -> bool:
    """True when a steady rate (rad/s) is small enough in each axis; VQF judges the axes one by one."""
    return abs(rate[0]) < MAX_GYRO_BIAS and abs(rate[1]) < MAX_GYRO_BIAS and abs(rate[2]) < MAX_GYRO_BIAS
