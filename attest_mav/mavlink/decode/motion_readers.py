"""The readers of motion: GPS_RAW_INT, the velocities of the autopilot's estimator, VFR_HUD."""

from math import cos, nan, radians, sin
from typing import Any, Final

from attest_mav.algebra import is_finite, is_finite_number
from attest_mav.mavlink.constants import (
    GPS_FIX_TYPE_3D_FIX,
    UINT8_MAX,
    UINT16_MAX,
)
from attest_mav.mavlink.decode.boot_clock import BootClock, time_refusal
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import AirDataSample, PositionSample, Sample, VelocitySample
from attest_mav.types import (
    AirspeedSource,
    Vec3,
    VelocityOrigin,
)

CENTI: Final = 1e-2

MILLI: Final = 1e-3

POOR_HDOP: Final = 2.5

FEW_SATELLITES: Final = 6
"""A receiver with a larger dilution of precision or fewer satellites has a poor velocity even if it does not say so."""

SIGMA_PER_HDOP: Final = 0.4
"""m/s: uncertainty of such a velocity for each unit of the dilution."""


class GpsReader(Reader):
    """GPS_RAW_INT with a 3-D fix: velocity over ground from speed and course, where both are known, and position."""

    def __init__(self, dialect: Dialect, boot_clock: BootClock) -> None:
        super().__init__("GPS_RAW_INT")
        self._boot_clock: Final = boot_clock
        self._fields: Final = dialect.layout(self.name).pick(
            "time_usec", "lat", "lon", "alt", "eph", "vel", "cog", "fix_type", "satellites_visible", "vel_acc"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """A PositionSample and, where speed and course are known, a VelocitySample before it."""
        values = self._fields.unpack(frame.payload)
        fix: int = values[7]
        if fix < GPS_FIX_TYPE_3D_FIX:
            return self.refuse(frame, f"no 3-D fix (fix type {fix})")
        time: int = values[0]
        t_ns = self._boot_clock.since_boot_ns(frame.system, time)
        if t_ns < 0:
            return self.refuse(frame, time_refusal(t_ns, time))
        eph: int = values[4]
        vel: int = values[5]
        cog: int = values[6]
        satellites: int = values[8]
        vel_acc: int = values[9]
        samples: list[Sample] = []
        if vel != UINT16_MAX and (cog != UINT16_MAX or vel == 0):
            sigma = receiver_sigma(vel_acc * MILLI, eph, satellites)
            samples.append(self._velocity(frame, t_ns, vel, cog, sigma))
        samples.append(self._position(frame, t_ns, values, eph, satellites))
        return samples

    def _position(self, frame: Frame, t_ns: int, values: tuple[Any, ...], eph: int, satellites: int) -> PositionSample:
        """The position among the values of a message."""
        lat: int = values[1]
        lon: int = values[2]
        alt: int = values[3]
        return PositionSample(
            self.name,
            frame.system,
            frame.component,
            t_ns,
            frame.rx_ns,
            lat * 1e-7,
            lon * 1e-7,
            alt * 1e-3,
            satellites if satellites != UINT8_MAX else None,
            eph * CENTI if eph != UINT16_MAX else None,
        )

    def _velocity(self, frame: Frame, t_ns: int, vel: int, cog: int, sigma: float | None) -> VelocitySample:
        """The velocity of a speed in cm/s and a course in hundredths of a degree."""
        speed: float = vel * CENTI
        course = radians(cog * CENTI)
        v_ned = (speed * cos(course), speed * sin(course), 0.0)
        origin = VelocityOrigin.RECEIVER
        return VelocitySample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, v_ned, False, origin, sigma)


def receiver_sigma(reported: float, eph: int, satellites: int) -> float | None:
    """Uncertainty of a receiver's velocity, m/s an axis; None where nothing speaks against a good one.

    reported: vel_acc, m/s, 0 where it is not known. eph: dilution of precision times 100.
    """
    hdop = eph * CENTI if eph != UINT16_MAX else 0.0
    few = satellites != UINT8_MAX and 0 < satellites < FEW_SATELLITES
    poor = SIGMA_PER_HDOP * max(hdop, POOR_HDOP) if hdop > POOR_HDOP or few else 0.0
    sigma = max(reported, poor)
    return sigma if sigma > 0.0 else None


class VelocityReader(Reader):
    """GLOBAL_POSITION_INT (cm/s) and LOCAL_POSITION_NED (m/s): the autopilot's own velocity estimate."""

    def __init__(self, dialect: Dialect, name: str, unit: float) -> None:
        super().__init__(name)
        self._unit: Final = unit
        self._fields: Final = dialect.layout(name).pick("time_boot_ms", "vx", "vy", "vz")

    def read(self, frame: Frame) -> list[Sample]:
        """One VelocitySample."""
        time, vx, vy, vz = self._fields.unpack(frame.payload)
        unit = self._unit
        v_ned: Vec3 = (vx * unit, vy * unit, vz * unit)
        if not is_finite(v_ned):
            return self.refuse(frame, "a velocity is not finite")
        t_ns: int = time * 1_000_000
        origin = VelocityOrigin.ESTIMATOR
        return [VelocitySample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, v_ned, True, origin)]


class HudReader(Reader):
    """VFR_HUD: airspeed, groundspeed, climb; NaN for one that the autopilot does not know."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("VFR_HUD")
        self._fields: Final = dialect.layout(self.name).pick("airspeed", "groundspeed", "climb")

    def read(self, frame: Frame) -> list[Sample]:
        """One AirDataSample."""
        values = self._fields.unpack(frame.payload)
        airspeed, groundspeed, climb = finite_or_nan(values[0]), finite_or_nan(values[1]), finite_or_nan(values[2])
        if not (is_finite_number(airspeed) or is_finite_number(groundspeed) or is_finite_number(climb)):
            return self.refuse(frame, "none of its speeds is finite")
        return [
            AirDataSample(
                self.name,
                frame.system,
                frame.component,
                frame.rx_ns,
                airspeed,
                groundspeed,
                climb,
                AirspeedSource.REPORTED,
            )
        ]


def finite_or_nan(value: float) -> float:
    """The value, NaN for an infinite one too."""
    return value if is_finite_number(value) else nan
