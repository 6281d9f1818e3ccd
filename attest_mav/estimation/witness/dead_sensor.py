"""Sensors that repeat themselves: a fault that needs no evidence but its own readings."""

from typing import Final

from attest_mav.algebra import norm
from attest_mav.samples import ImuSample
from attest_mav.types import Vec3

STUCK_S: Final = 0.05
STUCK_SAMPLES: Final = 3
"""An accelerometer that repeats a reading that cannot be is stuck after both, the second counts repetitions too."""
NO_FORCE: Final = 0.05
"""m/s^2: a specific force this small is no reading."""
FROZEN_S: Final = 0.3
FROZEN_RATE: Final = 0.02
"""rad/s: gyro and accelerometer that repeat a turn for longer are frozen."""


class DeadSensor:
    """Follows one lane's readings."""

    def __init__(self) -> None:
        self.reason = ""
        """The fault in words; "" for none."""
        self._gyro: Vec3 = (0.0, 0.0, 0.0)
        self._accel: Vec3 = (0.0, 0.0, 0.0)
        self._accel_s = 0.0
        self._accel_count = 0
        self._both_s = 0.0

    def take(self, sample: ImuSample, dt_s: float) -> None:
        """Take the next sample."""
        same_accel, same_gyro = sample.accel == self._accel, sample.gyro == self._gyro
        self._accel_s = self._accel_s + dt_s if same_accel else 0.0
        self._accel_count = self._accel_count + 1 if same_accel else 1
        self._both_s = self._both_s + dt_s if same_accel and same_gyro else 0.0
        self._gyro, self._accel = sample.gyro, sample.accel
        self.reason = self._reason()

    def _reason(self) -> str:
        x, y, z = self._accel
        if self._accel_s >= STUCK_S and self._accel_count >= STUCK_SAMPLES:
            if norm(self._accel) < NO_FORCE:
                return "accelerometer reads nothing"
            if x == y == z:
                return f"accelerometer stuck at {x:.2f} m/s^2 on all axes"
        if self._both_s >= FROZEN_S and norm(self._gyro) > FROZEN_RATE:
            return "gyro and accelerometer repeat one reading"
        return ""
