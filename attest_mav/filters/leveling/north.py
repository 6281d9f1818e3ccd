"""The heading beside a down vector: the north direction in the body, level with it.

The gyro turns this north vector, and the magnetic field corrects it. North and down vector together are the attitude,
and give the Earth's rate in the body.
"""

from math import atan2, cos, isnan, nan, sin
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, dot, norm, scale, sub
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.plausible import MIN_HORIZONTAL_FIELD, is_field
from attest_mav.record import Record
from attest_mav.types import Mat3, Vec3

EARTH_RATE: Final = 7.292115e-5
"""rad/s, against the stars."""
MIN_LENGTH: Final = 1e-6
"""A vector shorter than this has no direction."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class NorthVector(Record):
    """A heading, as a direction in the body, with the record of its correction."""

    def __init__(
        self,
        direction: Vec3,
        variance: float,
        known: bool,
        fusion: Fusion | None = None,
        residual: float = nan,
        innovation_variance: float = nan,
    ) -> None:
        self.direction: Final = direction
        """North in the body, unit and level."""
        self.variance: Final = variance
        """Of the heading, rad^2."""
        self.known: Final = known
        """False until a heading was measured, after a start without field or in motion."""
        self.fusion: Final = fusion
        """Use of this step's heading measurement, None without one."""
        self.residual: Final = residual
        """Measured minus predicted heading by the field, rad; NaN without one."""
        self.innovation_variance: Final = innovation_variance
        """Of the residual, rad^2."""

    @property
    def from_field(self) -> bool:
        """Whether this step used the magnetometer."""
        return not isnan(self.residual)

    def turned(self, direction: Vec3, variance: float, fusion: Fusion | None = None) -> "NorthVector":
        """The heading after a step without a correction."""
        return NorthVector(direction, variance, self.known, fusion)

    def innovation(self, t_ns: int) -> Innovation | None:
        """The record of this step's correction. A supplied heading replaces the old one and has no residual."""
        if self.fusion is None:
            return None
        if isnan(self.residual):
            return Innovation(Aid.HEADING, self.fusion, t_ns)
        return Innovation(Aid.HEADING, self.fusion, t_ns, (), (self.residual,), (self.innovation_variance,))


def direction(v: Vec3, otherwise: Vec3) -> Vec3:
    """v at unit length, or ``otherwise`` where v has no direction."""
    length = norm(v)
    return scale(v, 1.0 / length) if length > MIN_LENGTH else otherwise


def across(v: Vec3, axis: Vec3) -> Vec3:
    """The part of v at right angles to the unit vector ``axis``."""
    return sub(v, scale(axis, dot(v, axis)))


def made_level(north: Vec3, down: Vec3) -> Vec3:
    """north made level (unit ``down``) and of unit length; if it pointed up or down, any level direction."""
    aside: Vec3 = (0.0, 1.0, 0.0) if abs(down[1]) < 0.8 else (1.0, 0.0, 0.0)
    return direction(across(north, down), direction(across(aside, down), aside))


def level_axes(north: Vec3, down: Vec3) -> Mat3:
    """C, body to NED, from unit north and down directions in the body."""
    return (north, cross(down, north), down)


def earth_rate(north: NorthVector, down: Vec3, latitude: float, declination: float) -> Vec3:
    """The Earth's turn in the body, rad/s, eq. (16); its vertical part alone without a heading, zero without latitude.

    latitude, declination: rad, NaN where unknown. North is magnetic: true north lies ``declination`` to its left.
    """
    if isnan(latitude):
        return (0.0, 0.0, 0.0)
    vertical = scale(down, -EARTH_RATE * sin(latitude))
    if not north.known:
        return vertical
    true_north = north.direction if isnan(declination) else turned_east(north.direction, down, -declination)
    return add(scale(true_north, EARTH_RATE * cos(latitude)), vertical)


def turned_east(north: Vec3, down: Vec3, angle: float) -> Vec3:
    """The level unit vector ``north`` turned towards its east by ``angle``, rad."""
    return add(scale(north, cos(angle)), scale(cross(down, north), sin(angle)))


def heading_error(north: Vec3, down: Vec3, mag: Vec3) -> float:
    """Angle of the level part of the field east of ``north``, rad; NaN where the field shows no heading."""
    length = norm(mag)
    level = across(mag, down)
    if not is_field(mag) or norm(level) < MIN_HORIZONTAL_FIELD * length:
        return nan
    return atan2(dot(cross(down, north), level), dot(north, level))


def north_from_heading(heading: float, down: Vec3, otherwise: Vec3) -> Vec3:
    """North in the body of a vehicle whose nose has this heading, rad; ``otherwise`` if the nose is not level."""
    nose = across((1.0, 0.0, 0.0), down)
    if norm(nose) < 1e-3:
        return otherwise
    return turned_east(direction(nose, otherwise), down, -heading)
