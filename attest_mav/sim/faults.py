"""Faults: what can go wrong on board, each under a name, and the faults of one flight.

``KINDS`` is the one table of all faults. ``attest_mav.sim.fault_text`` reads what users write; a part of the vehicle
asks ``FaultSchedule`` which faults it has at a time, and does what their ``Effect`` says.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, auto
from math import inf, radians
from typing import Final

from attest_mav.algebra import add
from attest_mav.types import Vec3

SENSORS: Final = (0, 1)
"""Indices of the inertial sensors: RAW_IMU and SCALED_IMU tell of the first, SCALED_IMU2 of the second."""

BODY: Final = ("x", "y", "z")
HORIZONTAL: Final = ("north", "east")
NED: Final = ("north", "east", "down")

NOWHERE: Final[Vec3] = (0.0, 0.0, 0.0)


class Part(Enum):
    """The part that has the fault."""

    GYRO = auto()
    ACCEL = auto()
    IMU = auto()
    COMPASS = auto()
    RECEIVER = auto()
    ATTITUDE = auto()
    VEHICLE = auto()


class Effect(Enum):
    """The effect of the fault on the part."""

    OFFSET = auto()
    SCALE = auto()
    STUCK = auto()
    STOP = auto()
    FREEZE = auto()
    SILENT = auto()
    NOT_FINITE = auto()
    SATURATED = auto()
    OFF = auto()
    NOISE = auto()
    LATE = auto()
    RAMP = auto()
    WANDER = auto()
    TRIM = auto()
    VIBRATION = auto()
    REBOOT = auto()


@dataclass(frozen=True)
class SizeRange:
    """Which sizes a fault can have."""

    unit: str
    """The unit of the size as users write it."""
    low: float
    """The smallest size, in ``unit``."""
    high: float
    """The largest size, in ``unit``."""
    si: float = 1.0
    """The unit in SI units, that of a field in gauss."""


@dataclass(frozen=True)
class FaultKind:
    """One fault that there is."""

    name: str
    part: Part
    effect: Effect
    does: str
    """Effect while the fault is on, in words for --help."""
    size: SizeRange | None = None
    """None for a fault without a size."""
    axes: tuple[str, ...] = ()
    """Names of the axes that can be chosen."""
    numbered: bool = False
    """Each of the two inertial sensors can have the fault alone."""
    lasts: bool = True
    """The fault has a duration."""


_GYRO, _ACCEL, _IMU, _COMPASS = Part.GYRO, Part.ACCEL, Part.IMU, Part.COMPASS
_RECEIVER, _ATTITUDE, _VEHICLE = Part.RECEIVER, Part.ATTITUDE, Part.VEHICLE

_RATE: Final = SizeRange("deg/s", -500.0, 500.0, radians(1.0))
_FORCE: Final = SizeRange("m/s2", -150.0, 150.0)
_SHARE: Final = SizeRange("%", -100.0, 100.0, 0.01)
_FIELD: Final = SizeRange("mG", -5000.0, 5000.0, 1e-3)
_DEVIATION: Final = SizeRange("m/s", 0.01, 100.0)
_VELOCITY: Final = SizeRange("m/s", -100.0, 100.0)
_GROWTH: Final = SizeRange("m/s2", -20.0, 20.0)
_DELAY: Final = SizeRange("s", 0.01, 5.0)
_ANGLE: Final = SizeRange("deg", -180.0, 180.0, radians(1.0))
_AMPLITUDE: Final = SizeRange("m/s2", 0.01, 150.0)

_ADDED: Final = "a constant is added to the"

KINDS: Final = (
    FaultKind("gyro-bias", _GYRO, Effect.OFFSET, f"{_ADDED} angular rate", _RATE, BODY, numbered=True),
    FaultKind("gyro-scale", _GYRO, Effect.SCALE, "the rate reads so much too large", _SHARE, BODY, numbered=True),
    FaultKind("gyro-stuck", _GYRO, Effect.STUCK, "the reading is this constant", _RATE, BODY, numbered=True),
    FaultKind("gyro-stop", _GYRO, Effect.STOP, "the reading is zero, and the driver notices", numbered=True),
    FaultKind("gyro-freeze", _GYRO, Effect.FREEZE, "the last reading is repeated", numbered=True),
    FaultKind("accel-bias", _ACCEL, Effect.OFFSET, f"{_ADDED} specific force", _FORCE, BODY, numbered=True),
    FaultKind("accel-scale", _ACCEL, Effect.SCALE, "the force reads so much too large", _SHARE, BODY, numbered=True),
    FaultKind("accel-stuck", _ACCEL, Effect.STUCK, "the reading is this constant", _FORCE, BODY, numbered=True),
    FaultKind("accel-stop", _ACCEL, Effect.STOP, "the reading is zero, and the driver notices", numbered=True),
    FaultKind("accel-freeze", _ACCEL, Effect.FREEZE, "the last reading is repeated", numbered=True),
    FaultKind("imu-freeze", _IMU, Effect.FREEZE, "gyro, accelerometer and compass repeat", numbered=True),
    FaultKind("imu-silent", _IMU, Effect.SILENT, "the sensor's messages are not sent", numbered=True),
    FaultKind("imu-nan", _IMU, Effect.NOT_FINITE, "readings are NaN, in integer messages zero", numbered=True),
    FaultKind("imu-saturated", _IMU, Effect.SATURATED, "gyro x, accelerometer z are out of range", numbered=True),
    FaultKind("compass", _COMPASS, Effect.OFFSET, f"{_ADDED} field", _FIELD, BODY, numbered=True),
    FaultKind("receiver-off", _RECEIVER, Effect.OFF, "the receiver has no fix"),
    FaultKind("receiver-noise", _RECEIVER, Effect.NOISE, "the velocity is noisy, and vel_acc says so", _DEVIATION),
    FaultKind("receiver-offset", _RECEIVER, Effect.OFFSET, f"{_ADDED} velocity", _VELOCITY, HORIZONTAL),
    FaultKind("receiver-ramp", _RECEIVER, Effect.RAMP, "the velocity's error grows by this", _GROWTH, HORIZONTAL),
    FaultKind("receiver-wander", _RECEIVER, Effect.WANDER, "the velocity wanders, as indoors", _DEVIATION),
    FaultKind("receiver-late", _RECEIVER, Effect.LATE, "fixes are late by so much more", _DELAY),
    FaultKind("receiver-frozen", _RECEIVER, Effect.FREEZE, "the last fix is repeated with new times"),
    FaultKind("trim", _ATTITUDE, Effect.TRIM, "the attitude is reported turned, in the body", _ANGLE, BODY),
    FaultKind("attitude-offset", _ATTITUDE, Effect.OFFSET, "the attitude is reported turned, in NED", _ANGLE, NED),
    FaultKind("attitude-frozen", _ATTITUDE, Effect.FREEZE, "the reported attitude is repeated"),
    FaultKind("vibration", _VEHICLE, Effect.VIBRATION, "the frame vibrates at 147 Hz", _AMPLITUDE),
    FaultKind("reboot", _VEHICLE, Effect.REBOOT, "the autopilot restarts: 2 s of silence", lasts=False),
)
"""Every fault there is, in the order of --help."""


@dataclass(frozen=True)
class Fault:
    """One fault of one flight."""

    kind: FaultKind
    start_s: float
    """Seconds from the start of the simulation."""
    end_s: float = inf
    """The first moment without the fault."""
    size: float = 0.0
    """SI units (a compass: gauss)."""
    sensors: tuple[int, ...] = SENSORS
    """Indices of the inertial sensors that have it."""
    axes: tuple[int, ...] = (0, 1, 2)
    """Indices of the axes that have it."""

    @property
    def effect(self) -> Effect:
        """See ``FaultKind``."""
        return self.kind.effect

    @property
    def vector(self) -> Vec3:
        """The size on the axes that have it, zero on the others."""
        x, y, z = (self.size if axis in self.axes else 0.0 for axis in range(3))
        return (x, y, z)


Faults = Iterable[Fault]
"""Those that a part has at one instant."""


def has(faults: Faults, effect: Effect) -> bool:
    """Whether one of the faults has that effect."""
    return any(fault.kind.effect is effect for fault in faults)


def total(faults: Faults, effect: Effect) -> Vec3:
    """Sum of the vectors of the faults with that effect."""
    found = NOWHERE
    for fault in faults:
        if fault.kind.effect is effect:
            found = add(found, fault.vector)
    return found


class FaultSchedule:
    """The faults of one flight: which part has which of them, and when."""

    def __init__(self, faults: Faults) -> None:
        self._of: dict[Part, list[Fault]] = {part: [] for part in Part}
        for fault in faults:
            self._of[fault.kind.part].append(fault)

    def active(self, part: Part, t_s: float, sensor: int = 0) -> list[Fault]:
        """The faults of a part at time ``t_s``. sensor: which one of an inertial part."""
        listed = self._of[part]
        if not listed:
            return listed
        return [fault for fault in listed if fault.start_s <= t_s < fault.end_s and sensor in fault.sensors]

    def starts_ns(self, part: Part, effect: Effect) -> list[int]:
        """When the faults of that effect begin, in order."""
        return sorted(round(fault.start_s * 1e9) for fault in self._of[part] if fault.effect is effect)
