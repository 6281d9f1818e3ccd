"""The charter: units, frames, time, and the value types every layer shares.

Units
    SI and radians everywhere inside the package; degrees only where a person reads or writes.
    Magnetic fields are in gauss (the Earth's is 0.25 to 0.65 gauss). Standard gravity is ``G_MPS2``.

Frames
    Body ``b`` is FRD (forward, right, down). World ``n`` is NED (north, east, down).
    ``q_nb`` is a unit Hamilton quaternion (w, x, y, z) that turns body vectors into NED:
    ``v_n = q_nb * v_b * conj(q_nb)``. MAVLink's ATTITUDE_QUATERNION carries this quaternion.
    The accelerometer measures specific force: (0, 0, -g) when level and at rest.

Time
    Instants are integer nanoseconds, intervals are float seconds. ``t_ns`` is the sensor's clock, the
    time that the message itself carries; ``rx_ns`` is the host's clock at reception. Filters use
    ``t_ns`` only. ``NO_TIME`` marks messages that carry none.

North
    ``North`` names the reference of a heading. Magnetic and true north differ by the declination
    (positive east): true = magnetic + declination.

Meaning
    A filter compares no message name. Who measured a value, with which resolution, and what it may be used for stand
    in fields: ``Quantum``, ``VelocityOrigin``, ``AttitudeRole``, ``AttitudeForm``, ``VehicleKind``,
    ``AirspeedSource``. ``source`` is for people, and for choosing one stream among several.

Records made once a sample are plain classes, set once and never changed afterwards: compiled, they are
made in some 30 ns, where a frozen dataclass takes 550.
"""

from enum import IntEnum
from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.record import Record

Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]
Mat3 = tuple[Vec3, Vec3, Vec3]
"""Three rows."""

G_MPS2: Final = 9.80665
"""Standard gravity; MAVLink's milli-g are thousandths of it."""

NO_TIME: Final = -1
"""``t_ns`` of a message that carries no timestamp (SIM_STATE, SIMSTATE, AHRS2)."""


class North(IntEnum):
    """Reference of a heading."""

    RELATIVE = 0
    """Nothing: the heading at the start was taken as zero, or has drifted since the field was lost."""
    MAGNETIC = 1
    TRUE = 2


Version = tuple[int, int, int]
"""Major, minor and patch number of a firmware."""


class VehicleKind(IntEnum):
    """How a vehicle can move; it decides which speeds tell something of its attitude."""

    UNKNOWN = 0
    """Nothing is known, or the kind allows any motion (submarines, balloons)."""
    ROTARY = 1
    """Copters and helicopters: they move in any direction."""
    WING = 2
    """Aeroplanes, and VTOL vehicles, which fly as aeroplanes when they are fast: through the air they go where they
    point."""
    SURFACE = 3
    """Ground vehicles and boats: over ground they go where they point."""


@mypyc_attr(acyclic=True)  # as the samples that carry it
class Quantum(Record):
    """The resolution of an inertial sample's readings: one count of gyro (rad/s), accel (m/s^2) and mag (gauss).

    Readings are truncated toward zero to whole counts; 0 means that they are exact.
    """

    def __init__(self, gyro: float, accel: float, mag: float) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.mag: Final = mag


EXACT: Final = Quantum(0.0, 0.0, 0.0)
"""The quantum of readings that are floating-point numbers."""


class EarthField(Record):
    """The direction of the Earth's magnetic field where the vehicle is; rad, NaN where it is not known.

    declination: east of true north. inclination: below the horizontal.
    """

    def __init__(self, declination: float = nan, inclination: float = nan) -> None:
        self.declination: Final = declination
        self.inclination: Final = inclination


class AttitudeRole(IntEnum):
    """Source of an attitude sample, which decides its permitted uses."""

    AUTOPILOT = 0
    """The attitude that the autopilot flies by: the one to be judged (ATTITUDE, ATTITUDE_QUATERNION)."""
    SECONDARY = 1
    """Another estimator of the autopilot: context, never judged (AHRS2)."""
    TRUTH = 2
    """A simulator's own state (SIM_STATE, SIMSTATE)."""


class AttitudeForm(IntEnum):
    """How the message writes the attitude. Where one sender sends both, the quaternion is used."""

    EULER = 0
    QUATERNION = 1


class VelocityOrigin(IntEnum):
    """Source of a velocity, which decides its delay and whether the autopilot's estimator had a part in it."""

    RECEIVER = 0
    """A satellite receiver, unfiltered: late by the receiver's delay (GPS_RAW_INT; GPS records of logs)."""
    ESTIMATOR = 1
    """The autopilot's own estimator: not independent, nearly without delay (GLOBAL_POSITION_INT)."""


class AirspeedSource(IntEnum):
    """Where an airspeed comes from."""

    SENSOR = 0
    """A pitot tube, by its own message or record."""
    REPORTED = 1
    """The autopilot's display value (VFR_HUD): a sensor's where there is one, else made of groundspeed and wind."""
