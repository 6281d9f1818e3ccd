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
