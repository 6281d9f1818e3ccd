"""The readers of inertial sensors and compasses: IMU and MAG.

IMU holds what RAW_IMU and SCALED_IMU hold before these are rounded to integers: get_gyro() and get_accel() of the
sensor's frontend, behind calibration, rotation, notches and the low-pass INS_GYRO_FILTER, at the time of writing
(AP_InertialSensor_Logging.cpp, Write_IMU_instance). MAG is written as soon as a mean of some 0.1 s is complete.
"""

from math import isfinite
from typing import Final

from attest_mav.logs.dataflash.reader import RecordReader
from attest_mav.logs.dataflash.units import Column
from attest_mav.mavlink.decode.sensor_reader import SensorReader
from attest_mav.mavlink.decode.units import MILLI
from attest_mav.samples import Sample
from attest_mav.types import Vec3

GYRO: Final = [Column(f"Gyr{axis}", "rad/s") for axis in "XYZ"]
ACCEL: Final = [Column(f"Acc{axis}", "m/s/s") for axis in "XYZ"]
FIELD: Final = [Column(f"Mag{axis}", "mGauss", MILLI) for axis in "XYZ"]


class Compass:
    """The newest reading of one compass."""

    def __init__(self) -> None:
        self.field: Vec3 = (0.0, 0.0, 0.0)
        """Body, mgauss; zeros before the first reading."""


class ImuReader(RecordReader):
    """IMU of one sensor. compass: that which goes with the sensor; its reading stays until the next one."""

    def __init__(self, sensor: SensorReader, compass: Compass) -> None:
        super().__init__([*GYRO, *ACCEL])
        self._sensor: Final = sensor
        self._compass: Final = compass

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One ImuSample, with those that the checks of the start have held back."""
        gyro = (numbers[1], numbers[2], numbers[3])
        accel = (numbers[4], numbers[5], numbers[6])
        return self._sensor.accept(t_ns, t_ns, accel, gyro, self._compass.field, field_sent=True)


class MagReader(RecordReader):
    """MAG of one compass; it makes no sample. A compass that is not healthy is not heard."""

    def __init__(self, compass: Compass) -> None:
        super().__init__([*FIELD, Column("Health")])
        self._compass: Final = compass

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """Keep the reading for the inertial sensor."""
        if numbers[4] != 0.0 and isfinite(numbers[1] + numbers[2] + numbers[3]):
            self._compass.field = (numbers[1], numbers[2], numbers[3])
        return []
