"""Which readings of a lane can be believed: sensors that freeze, and magnetometers that have stopped."""

from typing import Final

from attest_mav.algebra import norm
from attest_mav.samples import ImuSample
from attest_mav.types import Vec3

FROZEN_S: Final = 1.0
"""Bit-identical readings for this long while they claim a turn mean a frozen sensor."""
FROZEN_MIN_SAMPLES: Final = 5
FROZEN_RATE: Final = 0.02
"""rad/s: a vehicle at rest may well repeat one quantised reading, so slower ones prove nothing."""
FIELD_TURN: Final = 0.6
"""rad: a magnetometer that has not changed while the vehicle turned this far has stopped measuring. The slowest
telemetry in use holds a field for 0.1 s, in which a fast copter turns 0.25 rad."""


class FreezeDetector:
    """Finds an inertial sensor that repeats itself.

    The magnetometer must repeat too: one that changes with the turn vouches for the gyro (a simulator without noise
    can turn at an exactly steady rate, its field turning with it).
    """

    def __init__(self) -> None:
        self._gyro: Vec3 = (0.0, 0.0, 0.0)
        self._accel: Vec3 = (0.0, 0.0, 0.0)
        self._has_field = False
        self._field: Vec3 = (0.0, 0.0, 0.0)
        self._same_s = 0.0
        self._same_count = 0

    def frozen(self, sample: ImuSample, dt_s: float) -> bool:
        """True while the readings, this one included, are frozen."""
        same_field = sample.has_field == self._has_field and sample.field == self._field
        if same_field and sample.gyro == self._gyro and sample.accel == self._accel:
            self._same_s += dt_s
            self._same_count += 1
        else:
            self._gyro = sample.gyro
            self._accel = sample.accel
            self._has_field = sample.has_field
            self._field = sample.field
            self._same_s = 0.0
            self._same_count = 0
        return self._same_s >= FROZEN_S and self._same_count >= FROZEN_MIN_SAMPLES and norm(self._gyro) > FROZEN_RATE


class StuckMagnetometer:
    """Withholds a magnetometer reading that no longer follows the vehicle, and knows how long there was none.

    A repeated reading is judged by the rotation since it was new, not by the field: that is the filters' business.
    """

    def __init__(self) -> None:
        self._last: Vec3 = (0.0, 0.0, 0.0)
        self._turned = 0.0
        self.absent_s = 0.0
        """Time since a field could last be used, s."""
        self.was_used = False
        """Whether one could ever be used."""

    def usable(self, sample: ImuSample, turn: float, dt_s: float) -> bool:
        """True when the sample's field can be used. ``turn``: angle turned since the sample before, rad."""
        self._turned += turn
        if sample.has_field and sample.field != self._last:
            self._last = sample.field
            self._turned = 0.0
        if not sample.has_field or self._turned > FIELD_TURN:
            self.absent_s += dt_s
            return False
        self.absent_s = 0.0
        self.was_used = True
        return True
