"""Whether the vehicle stands still: quiet sensors, and nothing that says it moves."""

from math import isfinite, nan
from typing import Final

from attest_mav.algebra import norm
from attest_mav.types import G_MPS2, HeartbeatSample, ImuSample, Sample, VelocitySample

STILL_GYRO: Final = 0.05
"""rad/s."""
STILL_ACCEL: Final = 0.3
"""m/s^2: distance of the specific force's length from g."""
STILL_AFTER_S: Final = 1.0
"""Rest is believed after this long; it is over at the first reading beyond twice the limits."""
STANDING_SPEED: Final = 0.5
"""m/s: what moves faster does not stand, however quiet its sensors: a plane in smooth cruise is as quiet as a desk."""


class Stillness:
    """Follows one lane's sensors and the vehicle's own word, with hysteresis in between."""

    def __init__(self) -> None:
        self._quiet_s = 0.0
        self._quiet = False
        self._armed: bool | None = None
        self._speed = nan

    def take(self, sample: Sample) -> None:
        """Remember what a sample that is not inertial says of motion."""
        if isinstance(sample, HeartbeatSample):
            self._armed = sample.armed
        elif isinstance(sample, VelocitySample):
            self._speed = norm(sample.v_ned)

    @property
    def armed(self) -> bool | None:
        """What the vehicle says: armed, it may be under way, whatever else is known. None while it says nothing."""
        return self._armed

    @property
    def stands(self) -> bool | None:
        """What the vehicle itself says: True when it stands, False when it moves or may, None when it says nothing."""
        if isfinite(self._speed):
            return self._speed <= STANDING_SPEED
        return None if self._armed is None else not self._armed

    def still(self, sample: ImuSample, dt_s: float) -> bool:
        """True while the vehicle stands, as of this sample, ``dt_s`` after the one before.

        Disarmed, quiet sensors suffice. Armed or of unknown state, a speed is needed as well: hovering is quiet too.
        """
        gyro = norm(sample.gyro)
        accel = abs(norm(sample.accel) - G_MPS2)
        if gyro < STILL_GYRO and accel < STILL_ACCEL:
            self._quiet_s += dt_s
            self._quiet = self._quiet or self._quiet_s >= STILL_AFTER_S
        elif not (gyro < 2.0 * STILL_GYRO and accel < 2.0 * STILL_ACCEL):
            self._quiet_s = 0.0
            self._quiet = False
        return self._quiet and self.stands is True
