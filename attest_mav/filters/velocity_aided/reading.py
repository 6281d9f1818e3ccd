"""The readings of one inertial sample as the flight filter uses them.

An integer message is truncated toward zero, which is a bias of half a unit against the sign; a constant rate of some
units would be missed by half a unit for ever. Half a unit is given back, so that the error has zero mean.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.plausible import is_field, is_force
from attest_mav.record import Record
from attest_mav.samples import ImuSample
from attest_mav.types import Vec3


@mypyc_attr(acyclic=True, free_list_len=1)
class Reading(Record):
    """Gyro and accelerometer of one sample."""

    def __init__(self, gyro: Vec3, accel: Vec3, saturated: bool) -> None:
        self.gyro: Final = gyro
        """Body, rad/s."""
        self.accel: Final = accel
        """Specific force, body, m/s^2; the one before where the sample has no usable one."""
        self.saturated: Final = saturated
        """A sensor is at the end of its range, or the accelerometer has no usable value."""


def read(sample: ImuSample, before: Vec3) -> Reading:
    """The sample's readings; ``before`` stands in for an accelerometer without a usable value, m/s^2."""
    usable = is_force(sample.accel)
    quantum = sample.quantum
    accel = dequantised(sample.accel, quantum.accel) if usable else before
    return Reading(dequantised(sample.gyro, quantum.gyro), accel, sample.saturated or not usable)


def field_of(sample: ImuSample) -> Vec3 | None:
    """The sample's magnetic field, gauss; None when it has no usable one."""
    if not (sample.has_field and is_field(sample.field)):
        return None
    return dequantised(sample.field, sample.quantum.mag)


def dequantised(v: Vec3, unit: float) -> Vec3:
    """The middle of the interval that truncation toward zero has mapped to v; zero, and exact readings, stay."""
    if unit <= 0.0:
        return v
    return (_middle(v[0], unit), _middle(v[1], unit), _middle(v[2], unit))


def _middle(x: float, unit: float) -> float:
    return x + 0.5 * unit if x > 0.0 else x - 0.5 * unit if x < 0.0 else 0.0
