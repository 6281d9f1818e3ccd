"""The readers of motion: GPS with the accuracies in GPA, ARSP, ORGN."""

from math import cos, isfinite, nan, sin
from typing import Final

from attest_mav.logs.dataflash.reader import COMPONENT, SYSTEM, RecordReader
from attest_mav.logs.dataflash.units import Column
from attest_mav.logs.gps_time import unix_us_of_week
from attest_mav.mavlink.constants import GPS_FIX_TYPE_3D_FIX, UINT8_MAX, UINT16_MAX
from attest_mav.mavlink.decode.motion_readers import receiver_sigma
from attest_mav.samples import AirDataSample, PositionSample, Sample, VelocitySample
from attest_mav.types import AirspeedSource, VelocityOrigin
from attest_mav.vehicle_reports import ClockSample

PLACE: Final = [Column("Lat", "deglatitude"), Column("Lng", "deglongitude"), Column("Alt", "m")]


class Accuracy:
    """The receiver's own word on its newest fix (GPA)."""

    def __init__(self) -> None:
        self.speed = nan
        """1-sigma of the velocity, m/s; NaN while it is not told."""
        self.has_vertical: bool | None = None
        """Whether it measures a vertical velocity; None while it is not told."""


class AccuracyReader(RecordReader):
    """GPA of one receiver; it makes no sample. It follows its GPS record, so that a fix gets the accuracy before."""

    def __init__(self, accuracy: Accuracy) -> None:
        super().__init__([Column("SAcc", "m/s"), Column("VV")])
        self._accuracy: Final = accuracy

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """Keep the accuracy for the next fix."""
        self._accuracy.speed = numbers[1]
        self._accuracy.has_vertical = numbers[2] != 0.0 if isfinite(numbers[2]) else None
        return []


class GpsReader(RecordReader):
    """GPS of one receiver with a 3-D fix."""

    def __init__(self, source: str, accuracy: Accuracy) -> None:
        motion = [Column("Spd", "m/s"), Column("GCrs", "deg"), Column("VZ", "m/s")]
        quality = [Column("Status"), Column("HDop"), Column("NSats")]
        week = [Column(name) for name in ("GWk", "Week", "GMS", "TimeMS", "Time")]
        super().__init__([*motion, *PLACE, *quality, *week])
        self._source: Final = source
        self._accuracy: Final = accuracy
        self._has_dated = False
        self._vertical_seen = False
        """A vertical velocity other than 0 has come."""

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """A VelocitySample and a PositionSample; before the first ones a ClockSample with the date."""
        if not numbers[7] >= GPS_FIX_TYPE_3D_FIX:
            return []
        samples: list[Sample] = self._date(t_ns, numbers)
        if isfinite(numbers[1]) and isfinite(numbers[2]):
            samples.append(self._velocity(t_ns, numbers))
        if isfinite(numbers[4]) and isfinite(numbers[5]):
            altitude = numbers[6] if isfinite(numbers[6]) else 0.0
            samples.append(
                PositionSample(
                    self._source,
                    SYSTEM,
                    COMPONENT,
                    t_ns,
                    t_ns,
                    numbers[4],
                    numbers[5],
                    altitude,
                    int(numbers[9]) if isfinite(numbers[9]) else None,
                    numbers[8] if numbers[8] > 0.0 else None,
                )
            )
        return samples

    def _velocity(self, t_ns: int, numbers: list[float]) -> VelocitySample:
        speed, course, down = numbers[1], numbers[2], numbers[3]
        self._vertical_seen = self._vertical_seen or (isfinite(down) and down != 0.0)
        told = self._accuracy.has_vertical
        vertical = isfinite(down) and (self._vertical_seen if told is None else told)
        v_ned = (speed * cos(course), speed * sin(course), down if vertical else 0.0)
        return VelocitySample(
            self._source,
            SYSTEM,
            COMPONENT,
            t_ns,
            t_ns,
            v_ned,
            vertical,
            VelocityOrigin.RECEIVER,
            self._sigma(numbers[8], numbers[9]),
        )

    def _sigma(self, hdop: float, satellites: float) -> float | None:
        """As that of GPS_RAW_INT, whose numbers these are."""
        speed = self._accuracy.speed
        eph = min(int(100.0 * hdop), UINT16_MAX - 1) if isfinite(hdop) and hdop >= 0.0 else UINT16_MAX
        return receiver_sigma(
            speed if isfinite(speed) else 0.0, eph, int(satellites) if isfinite(satellites) else UINT8_MAX
        )

    def _date(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        week = numbers[10] if isfinite(numbers[10]) else numbers[11]
        milliseconds = next((one for one in numbers[12:15] if isfinite(one)), nan)
        if self._has_dated or not isfinite(milliseconds) or not week > 0.0:
            return []
        self._has_dated = True
        unix_us = unix_us_of_week(int(week), int(milliseconds))
        return [ClockSample(self._source, SYSTEM, COMPONENT, t_ns, t_ns, unix_us)]


class FirstFixReader(GpsReader):
    """GPS of one receiver until it has told its date and a fix with place and velocity; behind that the time alone."""

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """The samples of ``GpsReader``."""
        samples = super().read(t_ns, numbers, texts)
        self.is_timed_alone = (
            self._has_dated
            and any(isinstance(one, VelocitySample) for one in samples)
            and any(isinstance(one, PositionSample) for one in samples)
        )
        return samples


class AirspeedReader(RecordReader):
    """ARSP, the airspeed sensor; one that is not healthy is not heard."""

    def __init__(self, source: str) -> None:
        super().__init__([Column("Airspeed", "m/s"), Column("H")])
        self._source: Final = source

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One AirDataSample."""
        if not isfinite(numbers[1]) or numbers[2] == 0.0:
            return []
        airspeed = AirspeedSource.SENSOR
        return [AirDataSample(self._source, SYSTEM, COMPONENT, t_ns, numbers[1], nan, nan, airspeed)]


class OriginReader(RecordReader):
    """ORGN, the place that the estimator or the way home begins at; it tells the place where there is no receiver."""

    def __init__(self, source: str) -> None:
        super().__init__(PLACE)
        self._source: Final = source

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One PositionSample; zeros are none."""
        latitude, longitude, altitude = numbers[1], numbers[2], numbers[3]
        if not isfinite(latitude + longitude + altitude) or (latitude == 0.0 and longitude == 0.0):
            return []
        return [PositionSample(self._source, SYSTEM, COMPONENT, t_ns, t_ns, latitude, longitude, altitude)]
