"""The settings of the vehicle that the autopilot can tell; units as in ``types``."""

from enum import IntEnum
from math import isfinite, nan
from typing import Final


class Setting(IntEnum):
    """A setting of the vehicle that the autopilot can tell. Switches and choices are numbers, as the autopilot's."""

    LOW_PASS_HZ = 0
    """Corner of the low-pass that gyro and accelerometer have passed, Hz; 0 for none."""
    FIX_DELAY_S = 1
    """Age of the receiver's velocity at the time that GPS_RAW_INT names, s."""
    ACCEL_LOW_PASS_HZ = 2
    """Corner of the accelerometer's low-pass where it has one of its own, Hz; 0 for none."""
    TRIM_X = 3
    """First angle of the trim between the reported attitude and the inertial sensor's, rad."""
    TRIM_Y = 4
    """Second angle, rad."""
    TRIM_Z = 5
    """Third angle, rad."""
    ESTIMATOR = 6
    """The estimator that the autopilot is set to use, a number of ``Estimator``."""
    PITCH_TRIM = 7
    """Pitch of level flight that a plane takes off the pitch it reports, rad."""
    FLIGHT_OPTIONS = 8
    """A plane's options as bits."""
    HOVER_PITCH_TRIM = 9
    """Pitch of a VTOL plane in the hover, rad."""
    HOVERS = 10
    """Other than 0 for a plane that can hover."""
    TAILSITTER = 11
    """Other than 0 for a plane that hovers nose-up."""
    HOVER_FRAME = 12
    """Class of a VTOL plane's frame."""
    DECLINATION = 13
    """Declination that the autopilot uses, rad, east positive."""
    AUTO_DECLINATION = 14
    """Other than 0 where the autopilot looks its declination up."""
    LOW_PASS_DELAY_SIGMA_S = 15
    """Uncertainty of the low-pass's delay where its corner is only assumed, s; 0 once the autopilot has told it."""
    FIELD_DELAY_S = 16
    """Age of the magnetometer's reading at the time of the inertial sample that carries it, s."""
    BOARD_ORIENTATION = 17
    """Rotation from the autopilot's board to the body, the autopilot's number of it."""
    ACCEL_1_DEVICE = 18
    ACCEL_1_OFFSET_X = 19
    ACCEL_1_OFFSET_Y = 20
    ACCEL_1_OFFSET_Z = 21
    ACCEL_2_DEVICE = 22
    ACCEL_2_OFFSET_X = 23
    ACCEL_2_OFFSET_Y = 24
    ACCEL_2_OFFSET_Z = 25
    ACCEL_3_DEVICE = 26
    ACCEL_3_OFFSET_X = 27
    ACCEL_3_OFFSET_Y = 28
    ACCEL_3_OFFSET_Z = 29
    MAG_1_DEVICE = 30
    MAG_1_OFFSET_X = 31
    MAG_1_OFFSET_Y = 32
    MAG_1_OFFSET_Z = 33
    MAG_2_DEVICE = 34
    MAG_2_OFFSET_X = 35
    MAG_2_OFFSET_Y = 36
    MAG_2_OFFSET_Z = 37
    MAG_3_DEVICE = 38
    MAG_3_OFFSET_X = 39
    MAG_3_OFFSET_Y = 40
    MAG_3_OFFSET_Z = 41
    """The autopilot's number of each accelerometer's and magnetometer's device, 0 for none; and the offset that its
    calibration subtracts from the readings, m/s^2 and gauss."""


QUANTITIES: Final = {
    Setting.LOW_PASS_HZ: ("gyro low-pass", "Hz"),
    Setting.FIX_DELAY_S: ("GPS delay", "s"),
    Setting.ACCEL_LOW_PASS_HZ: ("accelerometer low-pass", "Hz"),
    Setting.TRIM_X: ("trim", "rad"),
    Setting.TRIM_Y: ("trim", "rad"),
    Setting.TRIM_Z: ("trim", "rad"),
    Setting.PITCH_TRIM: ("pitch trim", "rad"),
    Setting.HOVER_PITCH_TRIM: ("pitch trim in the hover", "rad"),
    Setting.DECLINATION: ("declination", "rad"),
}
"""Settings with a unit: the quantity in words, and its unit."""


class SensorSettings:
    """The settings that tell one accelerometer or magnetometer from another, or from itself calibrated anew."""

    def __init__(self, device: Setting, offset: tuple[Setting, Setting, Setting], unit: str) -> None:
        self.device: Final = device
        self.offset: Final = offset
        """Its three axes, in ``unit``."""
        self.unit: Final = unit


def _sensors(first: Setting, unit: str) -> tuple[SensorSettings, ...]:
    """Those of three sensors, whose settings follow each other from this one on."""
    devices = [first + 4 * number for number in range(3)]
    return tuple(
        [SensorSettings(Setting(at), (Setting(at + 1), Setting(at + 2), Setting(at + 3)), unit) for at in devices]
    )


ACCELEROMETERS: Final = _sensors(Setting.ACCEL_1_DEVICE, "m/s^2")
MAGNETOMETERS: Final = _sensors(Setting.MAG_1_DEVICE, "gauss")
IDENTIFYING: Final = frozenset(
    [Setting.BOARD_ORIENTATION]
    + [setting for one in (*ACCELEROMETERS, *MAGNETOMETERS) for setting in (one.device, *one.offset)]
)
"""All settings that tell a sensor from others."""
SENSOR_NUMBERS: Final = {
    "RAW_IMU": 0,
    "SCALED_IMU": 0,
    "HIGHRES_IMU": 0,
    "IMU": 0,
    "sensor_combined": 0,
    "vehicle_imu": 0,
    "SCALED_IMU2": 1,
    "IMU2": 1,
    "vehicle_imu_1": 1,
    "SCALED_IMU3": 2,
    "IMU3": 2,
    "vehicle_imu_2": 2,
}
"""The place in those of the sensors in an inertial message, record or topic. HIGHRES_IMU and sensor_combined do not
tell which sensor they read: on most vehicles the first."""


_OTHERS_UNKNOWN: Final = (nan,) * (len(Setting) - 2)
"""The values of all settings behind the first two."""


class VehicleSettings:
    """The settings of the vehicle (``Setting``) as far as they are known; NaN where one is not.

    others: the values of all settings behind the first two, in order.
    """

    def __init__(
        self, low_pass_hz: float = nan, fix_delay_s: float = nan, others: tuple[float, ...] = _OTHERS_UNKNOWN
    ) -> None:
        self.low_pass_hz: Final = low_pass_hz
        self.fix_delay_s: Final = fix_delay_s
        self._values: Final = (low_pass_hz, fix_delay_s, *others)

    def get(self, setting: Setting) -> float:
        """The value of one setting."""
        return self._values[setting]

    def get_or(self, setting: Setting, default: float) -> float:
        """The value of one setting, the default where it is not known."""
        value = self._values[setting]
        return value if isfinite(value) else default

    def updated(self, setting: Setting, value: float) -> "VehicleSettings":
        """The settings with one of them replaced; NaN takes back an earlier value."""
        values = list(self._values)
        values[setting] = value
        if setting == Setting.LOW_PASS_HZ:
            values[Setting.LOW_PASS_DELAY_SIGMA_S] = nan
        return VehicleSettings(values[0], values[1], tuple(values[2:]))

    def __eq__(self, other: object) -> bool:
        """Equal where the same settings are known with the same values."""
        return isinstance(other, VehicleSettings) and repr(self) == repr(other)

    def __hash__(self) -> int:
        return hash(repr(self))

    def __repr__(self) -> str:
        """The known settings, every digit of them."""
        known = [f"{one.name}={self._values[one]!r}" for one in Setting if isfinite(self._values[one])]
        return f"VehicleSettings({', '.join(known)})"


class Estimator(IntEnum):
    """The autopilot's attitude estimators, by ArduPilot's numbers (AHRS_EKF_TYPE)."""

    DCM = 0
    """The direction cosine matrix, the fallback."""
    EKF2 = 2
    EKF3 = 3
    SIMULATOR = 10
    """The simulator's truth."""
    EXTERNAL = 11
    """A sensor that brings its own estimator."""


def quantity(setting: Setting) -> str:
    """Name of the setting for people."""
    known = QUANTITIES.get(setting)
    return setting.name.lower().replace("_", " ") if known is None else known[0]


def with_unit(setting: Setting, value: float) -> str:
    """A value of the setting with its unit, for people."""
    known = QUANTITIES.get(setting)
    return f"{value:g}" if known is None else f"{value:g} {known[1]}"
