"""Alignment: the first attitude from gravity and the magnetic field, and the gyro's bias of a vehicle that stands.

Half a second of steady readings is averaged. A vehicle whose readings do not become steady is aligned with what there
is after ``PATIENCE_S``: a start that the filters must then mend.

Steady readings are no proof of rest: a slow, level turn is as steady. Whether the mean rate counts as gyro bias
therefore depends on the vehicle's own report that it stands.
"""

from typing import Final

from attest_mav.algebra import add, cross, is_finite, largest, norm, q_from_matrix, scale, sub, unit
from attest_mav.filters.base import Start
from attest_mav.plausible import MIN_HORIZONTAL_FIELD
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North, Quat, Vec3

WINDOW_S: Final = 0.5
"""Length of the average."""
PATIENCE_S: Final = 2.0
"""Alignment ends after this time, s, even if the vehicle has not been still or no magnetometer reading has come."""
MIN_ACCEL_G: Final = 0.5
MAX_ACCEL_G: Final = 1.5
STILL_GYRO: Final = 0.05
"""rad/s: each axis stays this close to its mean at rest. Not ``filters.stationary``: judged by length, alignments would
end at other times, and every published figure of three filters would change."""
STILL_ACCEL: Final = 0.5
"""m/s^2: the same for the specific force."""
STANDING_BIAS: Final = 0.1
"""rad/s (6 deg/s): the largest bias that a vehicle known to stand may show; more is a sensor to be replaced."""
SILENT_BIAS: Final = 0.01
"""rad/s (0.6 deg/s): the same where nothing tells whether it stands. Autopilots calibrate their gyros to less."""


def ecompass(accel: Vec3, mag: Vec3 | None) -> tuple[Quat, North]:
    """Attitude from one specific force (m/s^2) and one field (any linear unit), TRIAD with gravity first.

    Without a usable field the heading is 0 and RELATIVE, else it is MAGNETIC. ``accel`` must not be zero.
    """
    down = scale(accel, -1.0 / norm(accel))
    if mag is not None and is_finite(mag) and norm(mag) > 0.0:
        east = cross(down, unit(mag))
        if norm(east) > MIN_HORIZONTAL_FIELD:
            east = unit(east)
            return (q_from_matrix((cross(east, down), east, down)), North.MAGNETIC)
    # Any horizontal direction will do: the body's forward axis, or its right axis if that points up or down.
    forward: Vec3 = (1.0, 0.0, 0.0) if abs(down[0]) < 0.99 else (0.0, 0.0, -1.0 if down[0] > 0.0 else 1.0)
    east = unit(cross(down, forward))
    return (q_from_matrix((cross(east, down), east, down)), North.RELATIVE)


class Aligner:
    """Collects samples until a filter can start."""

    def __init__(self, window_s: float = WINDOW_S, patience_s: float = PATIENCE_S) -> None:
        self._window_s = window_s
        self._patience_s = patience_s
        self._waited_s = 0.0
        self._began = False
        self._clear()

    def _clear(self) -> None:
        """Forget the readings, not the time waited."""
        zero: Vec3 = (0.0, 0.0, 0.0)
        self._length_s = 0.0
        self._count = 0
        self._mag_count = 0
        self._gyro_sum: Vec3 = zero
        self._accel_sum: Vec3 = zero
        self._mag_sum: Vec3 = zero

    def add(self, sample: ImuSample, dt_s: float, stands: bool | None) -> Start | None:
        """Take the sample that came ``dt_s`` after the last one; the start, once there is one.

        ``stands``: whether the vehicle reports that it stands, None without a report.
        """
        if self._began:
            self._waited_s += dt_s
            self._length_s += dt_s
        self._began = True
        if not _usable(sample):
            self._clear()
            return None
        if self._moved(sample):
            self._clear()
        self._accumulate(sample)
        patience_over = self._waited_s >= self._patience_s
        if self._length_s >= self._window_s and (self._mag_count > 0 or patience_over):
            return self._start(steady=True, stands=stands)
        if patience_over:
            return self._start(steady=False, stands=stands)
        return None

    def _moved(self, sample: ImuSample) -> bool:
        """True when the sample departs from the mean of those before it."""
        if self._count == 0:
            return False
        share = 1.0 / self._count
        return (
            _largest(sub(sample.gyro, scale(self._gyro_sum, share))) > STILL_GYRO
            or _largest(sub(sample.accel, scale(self._accel_sum, share))) > STILL_ACCEL
        )

    def _accumulate(self, sample: ImuSample) -> None:
        self._count += 1
        self._gyro_sum = add(self._gyro_sum, sample.gyro)
        self._accel_sum = add(self._accel_sum, sample.accel)
        mag = sample.mag
        if mag is not None and is_finite(mag):
            self._mag_count += 1
            self._mag_sum = add(self._mag_sum, mag)

    def _start(self, steady: bool, stands: bool | None) -> Start:
        gyro = scale(self._gyro_sum, 1.0 / self._count)
        accel = scale(self._accel_sum, 1.0 / self._count)
        mag = scale(self._mag_sum, 1.0 / self._mag_count) if self._mag_count > 0 else None
        q_nb, north = ecompass(accel, mag)
        largest = STANDING_BIAS if stands else SILENT_BIAS
        at_rest = steady and stands is not False and norm(gyro) < largest
        return Start(q_nb, gyro if at_rest else (0.0, 0.0, 0.0), north, accel, mag, at_rest)


def _usable(sample: ImuSample) -> bool:
    """True for finite readings whose specific force is near one g (NaN fails the comparison)."""
    length_g = norm(sample.accel) / G_MPS2
    return not sample.saturated and is_finite(sample.gyro) and MIN_ACCEL_G <= length_g <= MAX_ACCEL_G


def _largest(v: Vec3) -> float:
    """Largest component by size."""
    return largest(abs(v[0]), abs(v[1]), abs(v[2]))
