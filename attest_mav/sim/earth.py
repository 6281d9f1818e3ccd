"""The Earth around the vehicle: a magnetic field that is the same everywhere, and flat ground with coordinates.

Both hold for a few kilometres around the start, which is all a trajectory covers. The Earth does not turn: a
turning one would add 7e-5 rad/s, a fourteenth of what an int16 gyro message resolves.
"""

from dataclasses import dataclass
from math import cos, radians, sin

from attest_mav.types import Vec3

DEG_PER_M = 1e-7 / 0.011131884502145034
"""Degrees of latitude a metre; the figure of ArduPilot's Location.h (LOCATION_SCALING_FACTOR_INV)."""


@dataclass(frozen=True)
class Earth:
    """Where the vehicle starts, and the field there.

    The defaults are ArduPilot's simulator home near Canberra and the World Magnetic Model 2025 there in mid-2025.
    declination_deg: east positive. inclination_deg: dip, positive downward. strength_gauss: total field.
    """

    latitude_deg: float = -35.363262
    longitude_deg: float = 149.165237
    altitude_m: float = 584.0
    declination_deg: float = 12.66
    inclination_deg: float = -66.05
    strength_gauss: float = 0.581

    def field_ned(self) -> Vec3:
        """The field, gauss, true NED."""
        declination, inclination = radians(self.declination_deg), radians(self.inclination_deg)
        horizontal = self.strength_gauss * cos(inclination)
        return (
            horizontal * cos(declination),
            horizontal * sin(declination),
            self.strength_gauss * sin(inclination),
        )

    def geodetic(self, p_ned: Vec3) -> Vec3:
        """Latitude (deg), longitude (deg) and altitude (m) of a position in metres from the start."""
        return (
            self.latitude_deg + p_ned[0] * DEG_PER_M,
            self.longitude_deg + p_ned[1] * DEG_PER_M / cos(radians(self.latitude_deg)),
            self.altitude_m - p_ned[2],
        )
