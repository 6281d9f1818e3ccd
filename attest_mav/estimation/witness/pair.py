"""Two inertial sensors beside each other: the difference of their readings, and whether that is a dispute."""

from math import degrees, radians, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, heading_between, hypotenuse, norm, scale, sub, tilt_between
from attest_mav.estimation.witness.flight_state import accel_bias
from attest_mav.filters.base import FilterState
from attest_mav.ring_buffer import RingBuffer
from attest_mav.types import Vec3

MEAN_S: Final = 0.5
"""Readings are compared over this time."""
GYRO_LIMIT: Final = radians(0.8)
"""rad/s: sensors in good order differ by less."""
ACCEL_LIMIT: Final = 0.5
"""m/s^2: the same, beside the scatter of the difference."""
ACCEL_SCATTERS: Final = 6.0
TILT_LIMIT: Final = radians(1.0)
HEADING_LIMIT: Final = radians(2.0)
"""rad: attitudes in good order differ by less, or by less than ``SIGMAS`` of their sigmas."""
SIGMAS: Final = 1.5


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Difference:
    """Readings of one sensor minus another's, mean over a time; accel_scatter: of the accelerometers, an axis."""

    def __init__(self, gyro: Vec3, accel: Vec3, accel_scatter: Vec3, count: int) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.accel_scatter: Final = accel_scatter
        self.count: Final = count


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class PairedReading:
    """Readings of one sensor minus another's at one instant, rad/s and m/s^2."""

    def __init__(self, t_ns: int, gyro: Vec3, accel: Vec3) -> None:
        self.t_ns: Final = t_ns
        self.gyro: Final = gyro
        self.accel: Final = accel


class RunningDifference:
    """Mean and scatter of the differences over the last seconds."""

    def __init__(self, span_s: float) -> None:
        self._span_ns: Final = int(1e9 * span_s)
        self._points: Final[RingBuffer[PairedReading]] = RingBuffer()
        self._newest_ns = -1
        self._gyro: Vec3 = (0.0, 0.0, 0.0)
        self._accel: Vec3 = (0.0, 0.0, 0.0)
        self._accel_squares: Vec3 = (0.0, 0.0, 0.0)

    def take(self, reading: PairedReading) -> None:
        """Take the next difference."""
        points, t_ns = self._points, reading.t_ns
        if points.count > 0 and t_ns <= self._newest_ns:
            self.clear()
        self._newest_ns = t_ns
        points.append(reading)
        self._add(reading, 1.0)
        while t_ns - points.oldest.t_ns > self._span_ns:
            self._add(points.pop_oldest(), -1.0)

    def clear(self) -> None:
        """Forget everything."""
        zero: Vec3 = (0.0, 0.0, 0.0)
        self._points.clear()
        self._gyro = self._accel = self._accel_squares = zero

    @property
    def spans(self) -> bool:
        """True once the differences reach over most of the time."""
        points = self._points
        return points.count > 1 and self._newest_ns - points.oldest.t_ns > 0.8 * self._span_ns

    def difference(self) -> Difference:
        """The mean difference over the points kept."""
        points: int = self._points.count
        count = max(1, points)
        gyro, accel = scale(self._gyro, 1.0 / count), scale(self._accel, 1.0 / count)
        return Difference(gyro, accel, _scatter(self._accel_squares, accel, count), count)

    def _add(self, reading: PairedReading, sign: float) -> None:
        self._gyro = add(self._gyro, scale(reading.gyro, sign))
        self._accel = add(self._accel, scale(reading.accel, sign))
        self._accel_squares = add(self._accel_squares, scale(_squares(reading.accel), sign))


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Contrast:
    """Two lanes beside each other: their readings without biases, and their attitudes.

    gyro: rad/s, accel: m/s^2, the first less the second. tilt, heading: rad, between the attitudes. sensors_differ,
    attitudes_differ: by more than sensors in good order explain.
    """

    def __init__(
        self,
        gyro: Vec3,
        accel: Vec3,
        tilt: float,
        heading: float,
        gyros_differ: bool,
        accels_differ: bool,
        attitudes_differ: bool,
    ) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.tilt: Final = tilt
        self.heading: Final = heading
        self.gyros_differ: Final = gyros_differ
        self.accels_differ: Final = accels_differ
        self.attitudes_differ: Final = attitudes_differ

    @property
    def sensors_differ(self) -> bool:
        """True while readings differ beyond their limits."""
        return self.gyros_differ or self.accels_differ

    @property
    def differs(self) -> bool:
        """True while anything does."""
        return self.gyros_differ or self.accels_differ or self.attitudes_differ

    @property
    def text(self) -> str:
        """The numbers, for people."""
        return (
            f"gyros {degrees(norm(self.gyro)):.1f} deg/s, accelerometers {norm(self.accel):.2f} m/s^2, "
            f"attitudes {degrees(self.tilt):.1f} and heading {degrees(self.heading):.1f} degrees apart"
        )


def contrast(difference: Difference, gyro_offset: Vec3, accel_offset: Vec3) -> Contrast:
    """The readings of two lanes; the offsets are the biases of the first less those of the second."""
    gyro, accel = sub(difference.gyro, gyro_offset), sub(difference.accel, accel_offset)
    scatter = norm(difference.accel_scatter)
    limit = ACCEL_LIMIT + ACCEL_SCATTERS * scatter / sqrt(difference.count)
    return Contrast(gyro, accel, 0.0, 0.0, norm(gyro) > GYRO_LIMIT, norm(accel) > limit, False)


def contrast_of_states(difference: Difference, first: FilterState, second: FilterState) -> Contrast:
    """Readings and attitudes of two lanes that both have one."""
    readings = contrast(difference, sub(first.gyro_bias, second.gyro_bias), sub(accel_bias(first), accel_bias(second)))
    tilt = tilt_between(first.q_nb, second.q_nb)
    heading = abs(heading_between(first.q_nb, second.q_nb))
    apart = tilt > max(TILT_LIMIT, SIGMAS * hypotenuse(first.tilt_sigma, second.tilt_sigma)) or heading > max(
        HEADING_LIMIT, SIGMAS * hypotenuse(first.heading_sigma, second.heading_sigma)
    )
    return Contrast(readings.gyro, readings.accel, tilt, heading, readings.gyros_differ, readings.accels_differ, apart)


def _squares(v: Vec3) -> Vec3:
    return (v[0] * v[0], v[1] * v[1], v[2] * v[2])


def _scatter(squares: Vec3, mean: Vec3, count: int) -> Vec3:
    """Standard deviation per axis."""
    return (
        sqrt(max(0.0, squares[0] / count - mean[0] * mean[0])),
        sqrt(max(0.0, squares[1] / count - mean[1] * mean[1])),
        sqrt(max(0.0, squares[2] / count - mean[2] * mean[2])),
    )
