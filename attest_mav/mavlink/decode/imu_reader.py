"""Reads the inertial messages: fields, time, and which sensor of which sender they belong to."""

from typing import Any, Final

from attest_mav.mavlink.constants import (
    HIGHRES_IMU_UPDATED_ACCEL,
    HIGHRES_IMU_UPDATED_GYRO,
    HIGHRES_IMU_UPDATED_MAG,
)
from attest_mav.mavlink.decode.boot_clock import BootClock, time_refusal
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.decode.sensor_reader import SensorReader
from attest_mav.mavlink.decode.units import RawScales, unit_row
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample
from attest_mav.types import Vec3


class ImuReader(Reader):
    """RAW_IMU, SCALED_IMU, SCALED_IMU2, SCALED_IMU3 and HIGHRES_IMU: one SensorReader for each sensor of each sender.

    RAW_IMU and HIGHRES_IMU carry the sensor's number; above 0 it becomes part of the source: ``RAW_IMU#1``.
    """

    def __init__(
        self,
        dialect: Dialect,
        name: str,
        autopilots: dict[int, int],
        boot_clock: BootClock,
        raw_scales: RawScales | None,
    ) -> None:
        super().__init__(name)
        self._boot_clock: Final = boot_clock
        self.sensors: Final[dict[int, SensorReader]] = {}
        self._autopilots: Final = autopilots
        self._raw_scales: Final = raw_scales
        layout = dialect.layout(name)
        time = "time_usec" if "time_usec" in layout.fields else "time_boot_ms"
        vectors = [f"{axis}{sensor}" for sensor in ("acc", "gyro", "mag") for axis in "xyz"]
        tail = [field for field in ("fields_updated", "id") if field in layout.fields]
        self._fields: Final = layout.pick(time, *vectors, *tail)
        self._in_us: Final = time == "time_usec"
        self._has_id: Final = "id" in tail
        self._has_updates: Final = "fields_updated" in tail

    def read(self, frame: Frame) -> list[Sample]:
        """The samples of one reading, and of earlier ones that the start-up checks had held back."""
        values = self._fields.unpack(frame.payload)
        number: int = values[-1] if self._has_id else 0
        field_sent = True
        if self._has_updates:
            updated: int = values[10]
            motion = HIGHRES_IMU_UPDATED_ACCEL | HIGHRES_IMU_UPDATED_GYRO
            if updated & motion != motion:
                return self.refuse(frame, "fields_updated says that accelerometer or gyro are not new")
            field_sent = updated & HIGHRES_IMU_UPDATED_MAG == HIGHRES_IMU_UPDATED_MAG
        time: int = values[0]
        t_ns = self._boot_clock.since_boot_ns(frame.system, time) if self._in_us else 1_000_000 * time
        if t_ns < 0:
            return self.refuse(frame, time_refusal(t_ns, time))
        sensor = self.sensors.get((frame.system << 16) | (frame.component << 8) | number)
        if sensor is None:
            sensor = self._open_sensor(frame, number)
            if sensor is None:
                return []
        accel: Vec3 = (_real(values[1]), _real(values[2]), _real(values[3]))
        gyro: Vec3 = (_real(values[4]), _real(values[5]), _real(values[6]))
        field: Vec3 = (_real(values[7]), _real(values[8]), _real(values[9]))
        return sensor.accept(t_ns, frame.rx_ns, accel, gyro, field, field_sent)

    def _open_sensor(self, frame: Frame, number: int) -> SensorReader | None:
        """The sensor of a sensor seen for the first time; None, and a refusal, while its units are not known."""
        autopilot = self._autopilots.get(frame.system)
        if autopilot is None:
            self.refuse(frame, "its autopilot is not known yet (no HEARTBEAT so far), so its units are not either")
            return None
        row = unit_row(self.name, autopilot, self._raw_scales)
        if row is None:
            self.refuse(
                frame,
                f"autopilot {autopilot} sends true raw values, whose units nobody knows: configure the scales of "
                "RAW_IMU, or use SCALED_IMU or HIGHRES_IMU",
            )
            return None
        self.refusal = ""
        source = f"{self.name}#{number}" if number > 0 else self.name
        sensor = SensorReader(source, frame.system, frame.component, row)
        self.sensors[(frame.system << 16) | (frame.component << 8) | number] = sensor
        return sensor


def _real(value: Any) -> float:
    """A value as a float: compiled, an integer becomes one without an object in between."""
    if isinstance(value, int):
        whole: int = value
        return float(whole)
    real: float = value
    return real
