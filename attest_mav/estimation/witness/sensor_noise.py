"""The noise of one inertial sensor as its filter is to take it."""

from dataclasses import replace
from typing import Final

from attest_mav.filters.velocity_aided.filter import VelocityAided

SAME: Final = 0.02
"""A change by a smaller share is none."""


class SensorNoise:
    """accel: noise of the accelerometer, m/s per root s."""

    def __init__(self, accel: float) -> None:
        self.accel: Final = accel

    def is_like(self, other: "SensorNoise | None") -> bool:
        """True where the difference does not matter."""
        return other is not None and abs(self.accel - other.accel) <= SAME * other.accel

    def of(self, one: VelocityAided) -> VelocityAided:
        """The filter with this noise."""
        return replace(one, parameters=replace(one.parameters, accel_noise=self.accel))
