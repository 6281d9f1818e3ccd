"""The unit table: what the numbers of an inertial message mean, by who sent it.

One row per message and autopilot. Most of it follows the messages' definitions; the rest are habits of autopilots that
the definitions do not tell, and that were seen (docs/mavlink.md).
"""

from dataclasses import dataclass
from math import nan
from typing import Final

from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4
from attest_mav.record import Record
from attest_mav.types import G_MPS2

MILLI_G: Final = 1e-3 * G_MPS2
MILLI: Final = 1e-3

MIN_ACCEL_MPS2: Final = 0.5 * G_MPS2
MAX_ACCEL_MPS2: Final = 2.0 * G_MPS2
MIN_FIELD_GAUSS: Final = 0.1
MAX_FIELD_GAUSS: Final = 2.5
"""Magnitudes of accelerometer and magnetometer at start-up, whatever the vehicle does, if the units are right. The
Earth's field is 0.22 to 0.67 gauss; iron around the vehicle (a steel pool, a ship) makes a steady field that is
weaker or stronger, and as good as any other. Units that are wrong are wrong by a factor of a hundred or more."""

SATURATED_RAW: Final = 32440
"""99 % of what an int16 holds."""


class UnitRow(Record):
    """One row. accel: m/s^2 of one unit, gyro: rad/s, mag: gauss.

    integer: the fields are int16, which have a range to saturate. integer_field: those of the magnetometer alone are.
    field_powers: factors by which the magnetometer is known to come out wrong; the start-up check chooses among them,
    and none but 1 is taken without saying so. independent: the numbers owe nothing to the autopilot's estimator.
    has_field: the magnetometer is in the axes of the body, and calibrated. note: what a user should know.
    field_delay_s: age of the magnetometer's reading at the time of the sample, s; NaN for that of ArduPilot's mean,
    which filters expect.
    """

    def __init__(
        self,
        accel: float,
        gyro: float,
        mag: float,
        integer: bool,
        integer_field: bool = False,
        field_powers: tuple[float, ...] = (1.0,),
        independent: bool = True,
        has_field: bool = True,
        note: str = "",
        field_delay_s: float = nan,
    ) -> None:
        self.accel: Final = accel
        self.gyro: Final = gyro
        self.mag: Final = mag
        self.integer: Final = integer
        self.integer_field: Final = integer_field
        self.field_powers: Final = field_powers
        self.independent: Final = independent
        self.has_field: Final = has_field
        self.note: Final = note
        self.field_delay_s: Final = field_delay_s


@dataclass(frozen=True)
class RawScales:
    """What one count of RAW_IMU means on an autopilot that sends true raw values: m/s^2, rad/s, gauss."""

    accel: float
    gyro: float
    mag: float


_SCALED: Final = UnitRow(MILLI_G, MILLI, MILLI, integer=True)
_SCALED_PX4: Final = UnitRow(
    MILLI_G,
    MILLI,
    MILLI,
    integer=True,
    has_field=False,
    note="its magnetometer is uncalibrated and in its own frame, and not used",
)
_RAW_ARDUPILOT: Final = UnitRow(
    MILLI_G, MILLI, MILLI, integer=True, note="calibrated and low-passed by the autopilot, in spite of its name"
)
_HIGHRES: Final = UnitRow(1.0, 1.0, 1.0, integer=False)
_HIGHRES_ARDUPILOT: Final = UnitRow(1.0, 1.0, 1.0, integer=False, field_powers=(1.0, 1e-6))
_HIGHRES_PX4: Final = UnitRow(
    1.0,
    1.0,
    1.0,
    integer=False,
    independent=False,
    note="the autopilot's own bias estimates are subtracted: not independent of its estimator",
)

DATAFLASH_IMU: Final = UnitRow(
    1.0, 1.0, MILLI, integer=False, integer_field=True, note="calibrated and low-passed by the autopilot"
)
"""IMU of ArduPilot's DataFlash logs with the field of MAG: as RAW_IMU, but gyro and accelerometer are not rounded. The
compass's mean is written when it is complete, as RAW_IMU shows it first."""

ULOG_IMU: Final = UnitRow(
    1.0,
    1.0,
    1.0,
    integer=False,
    note="calibrated by the autopilot, means without a low-pass",
    field_delay_s=0.02,
)
"""sensor_combined and vehicle_imu of PX4's ULogs with the field of vehicle_magnetometer, a mean over 10 to 70 ms."""


def unit_row(message: str, autopilot: int, raw_scales: RawScales | None) -> UnitRow | None:
    """The row for an inertial message from an autopilot (MAV_AUTOPILOT); None when the numbers have no known meaning.

    raw_scales: what the configuration says about RAW_IMU; ArduPilot's needs none and takes none.
    """
    if message == "RAW_IMU":
        if autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA:
            return _RAW_ARDUPILOT
        if raw_scales is None:
            return None
        return UnitRow(raw_scales.accel, raw_scales.gyro, raw_scales.mag, integer=True, note="scaled as configured")
    if message == "HIGHRES_IMU":
        return (
            _HIGHRES_ARDUPILOT
            if autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA
            else _HIGHRES_PX4
            if autopilot == MAV_AUTOPILOT_PX4
            else _HIGHRES
        )
    return _SCALED_PX4 if autopilot == MAV_AUTOPILOT_PX4 else _SCALED


class MagnitudeCheck:
    """Decides from the first readings of a sensor whether its units can be right.

    It passes when the median of the last ``WINDOW`` magnitudes, times one of ``powers``, lies in [low, high]: one shock
    neither refuses nor passes a sensor, and a sensor that was refused passes as soon as it reads plausibly.
    """

    WINDOW: Final = 5

    def __init__(self, low: float, high: float, powers: tuple[float, ...]) -> None:
        self.low: Final = low
        self.high: Final = high
        self.factor = 1.0
        self.passed = False
        self.median = 0.0
        self.failed = False
        self._powers: Final = powers
        self._window: Final[list[float]] = []

    def offer(self, magnitude: float) -> None:
        """One more reading; sets ``passed`` with ``factor``, or ``failed``, once there are enough."""
        window = self._window
        window.append(magnitude)
        if len(window) > self.WINDOW:
            window.pop(0)
        if len(window) < self.WINDOW:
            return
        self.median = sorted(window)[self.WINDOW // 2]
        for power in self._powers:
            if self.low <= self.median * power <= self.high:
                self.passed = True
                self.failed = False
                self.factor = power
                return
        self.failed = True
