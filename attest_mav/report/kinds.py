"""The charts of a report: what each shows, in which unit, on which scale."""

from dataclasses import dataclass
from enum import Enum


@dataclass(frozen=True)
class Kind:
    """One kind of chart."""

    section: str
    title: str
    unit: str
    is_log: bool = False
    """The axis of the values is logarithmic."""
    wraps: bool = False
    """The values are angles that jump from 180 to -180 degrees."""


ATTITUDE = "Attitude"
DIFFERENCES = "Differences"
INNOVATIONS = "Innovations of the filter"
SENSORS = "Inertial sensors"
FIELD = "Magnetic field"
AUTOPILOT = "Receiver and autopilot"


class Chart(Enum):
    """The charts, in the order of the page."""

    ROLL = Kind(ATTITUDE, "Roll", "°", wraps=True)
    PITCH = Kind(ATTITUDE, "Pitch", "°")
    YAW = Kind(ATTITUDE, "Yaw", "°", wraps=True)
    TILT = Kind(DIFFERENCES, "Tilt difference", "°", is_log=True)
    HEADING = Kind(DIFFERENCES, "Heading difference, absolute", "°", is_log=True)
    NIS = Kind(INNOVATIONS, "Normalised innovation squared, mean of 5 s", "", is_log=True)
    INNOVATION = Kind(INNOVATIONS, "Innovation over its sigma", "")
    GYRO_BIAS = Kind(SENSORS, "Estimated gyro bias", "°/s")
    ACCEL_BIAS = Kind(SENSORS, "Estimated accelerometer bias", "m/s²")
    INTERVAL = Kind(SENSORS, "Interval of inertial samples", "ms", is_log=True)
    VIBRATION = Kind(SENSORS, "Vibration: rms of the accelerometer about its mean of 1 s", "m/s²")
    CLIPPING = Kind(SENSORS, "Saturated inertial samples in 1 s", "")
    FIELD_STRENGTH = Kind(FIELD, "Strength of the magnetic field", "gauss")
    INCLINATION = Kind(FIELD, "Inclination of the field by our attitude", "°")
    SPEED = Kind(AUTOPILOT, "Horizontal speed over ground", "m/s")
    SPEED_SIGMA = Kind(AUTOPILOT, "Velocity uncertainty by the receiver", "m/s")
    SATELLITES = Kind(AUTOPILOT, "Satellites in use", "")
    DILUTION = Kind(AUTOPILOT, "Horizontal dilution of precision", "")
    TEST_RATIO = Kind(AUTOPILOT, "The autopilot's innovation test ratios over its own limit", "")
