"""The readers of inertial sensors and magnetometer: sensor_combined, vehicle_imu, vehicle_magnetometer.

Both inertial topics hold means over the time since the last message (vehicle_imu: integrals), calibrated and turned
into the body, without a low-pass and without the estimator's biases. A mean is that of the middle of its interval, to
which the sample's time is moved back. (PX4's VehicleIMU.cpp, voted_sensors_update.cpp.)
"""

from math import isfinite
from typing import Final

from attest_mav.logs.ulog.reader import MICRO_NS, SAMPLE_TIME, TIME, TopicReader
from attest_mav.mavlink.decode.sensor_reader import SensorReader
from attest_mav.samples import Sample
from attest_mav.types import Vec3

AXES: Final = range(3)
LONGEST_MEAN_US: Final = 1e5
"""Longer intervals are none; 2017's firmware gave them in seconds."""


class Field:
    """The newest reading of the magnetometer."""

    def __init__(self) -> None:
        self.value: Vec3 = (0.0, 0.0, 0.0)
        """Body, gauss; zeros before the first reading."""


class CombinedReader(TopicReader):
    """sensor_combined. Before 2018 it holds the magnetometer too."""

    def __init__(self, sensor: SensorReader, field: Field) -> None:
        gyro = [f"gyro_rad[{axis}]" for axis in AXES]
        accel = [f"accelerometer_m_s2[{axis}]" for axis in AXES]
        mag = [f"magnetometer_ga[{axis}]" for axis in AXES]
        super().__init__([TIME, *gyro, *accel, *mag, "gyro_integral_dt", "accelerometer_clipping", "gyro_clipping"])
        self._sensor: Final = sensor
        self._field: Final = field

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """One ImuSample, with those that the checks of the start have held back."""
        field = self._field
        if isfinite(numbers[7] + numbers[8] + numbers[9]):
            field.value = (numbers[7], numbers[8], numbers[9])
        mean_us = numbers[10] if numbers[10] >= 1.0 else 1e6 * numbers[10]
        clipped = numbers[11] > 0.0 or numbers[12] > 0.0
        gyro, accel = (numbers[1], numbers[2], numbers[3]), (numbers[4], numbers[5], numbers[6])
        middle_ns = middle_of(t_ns, mean_us)
        return self._sensor.accept(middle_ns, t_ns, accel, gyro, field.value, field_sent=True, clipped=clipped)


class ImuReader(TopicReader):
    """vehicle_imu of one sensor: turn and change of velocity over an interval."""

    def __init__(self, sensor: SensorReader, field: Field) -> None:
        turn = [f"delta_angle[{axis}]" for axis in AXES]
        change = [f"delta_velocity[{axis}]" for axis in AXES]
        clipping = ["delta_velocity_clipping", "delta_angle_clipping"]
        super().__init__([SAMPLE_TIME, *turn, *change, "delta_angle_dt", "delta_velocity_dt", *clipping])
        self._sensor: Final = sensor
        self._field: Final = field

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """One ImuSample, as above; none for an interval of no length."""
        turn_us, change_us = numbers[7], numbers[8]
        if not (0.0 < turn_us <= LONGEST_MEAN_US and 0.0 < change_us <= LONGEST_MEAN_US):
            return []
        rate, force = 1e6 / turn_us, 1e6 / change_us
        gyro = (numbers[1] * rate, numbers[2] * rate, numbers[3] * rate)
        accel = (numbers[4] * force, numbers[5] * force, numbers[6] * force)
        clipped = numbers[9] > 0.0 or numbers[10] > 0.0
        middle_ns = middle_of(t_ns, turn_us)
        return self._sensor.accept(middle_ns, t_ns, accel, gyro, self._field.value, field_sent=True, clipped=clipped)


class MagReader(TopicReader):
    """vehicle_magnetometer; it makes no sample."""

    def __init__(self, field: Field) -> None:
        super().__init__([TIME, *[f"magnetometer_ga[{axis}]" for axis in AXES]])
        self._field: Final = field

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        """Keep the reading for the inertial sensor."""
        if isfinite(numbers[1] + numbers[2] + numbers[3]):
            self._field.value = (numbers[1], numbers[2], numbers[3])
        return []


def middle_of(t_ns: int, mean_us: float) -> int:
    """The middle of an interval that ends then, ns."""
    return t_ns - int(0.5 * MICRO_NS * mean_us) if 0.0 < mean_us <= LONGEST_MEAN_US else t_ns
