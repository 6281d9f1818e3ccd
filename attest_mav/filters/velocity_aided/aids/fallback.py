"""What takes the place of a velocity that is lost: the air speed of a wing, or the long-term mean of gravity.

A wing goes where it points, through air whose motion was learned while there were fixes: the velocity less the wind,
seen in the body, is (airspeed, 0, 0). For anything else it is assumed that it cannot accelerate sideways for ever:
the horizontal acceleration is zero, give or take ``gravity_noise``.
"""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, dot, q_to_matrix, rotate, scale, sub
from attest_mav.filters.velocity_aided.aids.gnss_velocity import unit_axis
from attest_mav.filters.velocity_aided.covariance import Reach, Row
from attest_mav.filters.velocity_aided.nav_state import Motion, reach_of, supposed, updated
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import transpose
from attest_mav.types import Vec3

SPACING_S: Final = 0.1
"""Time between rows."""
WIND_S: Final = 20.0
"""Time constant of the wind's mean."""
FLYING_SPEED: Final = 6.0
"""m/s: below this an airspeed says little about the direction of motion."""
GATE: Final = 2.0
"""Sigmas from which the variance of a row is inflated."""


@mypyc_attr(acyclic=True)
class Air:
    """wind: NED, m/s, with what an angle of attack adds. learned_s: for how long. waited_s: since the last rows."""

    def __init__(self, wind: Vec3, learned_s: float, waited_s: float) -> None:
        self.wind: Final = wind
        self.learned_s: Final = learned_s
        self.waited_s: Final = waited_s


def still_air() -> Air:
    """Before anything is known."""
    return Air((0.0, 0.0, 0.0), 0.0, 0.0)


def learned(air: Air, motion: Motion, airspeed: float, dt_s: float) -> Air:
    """The wind after a step during which the velocity was known. What is not needed has not been waited for."""
    if not airspeed > FLYING_SPEED:
        return Air(air.wind, air.learned_s, 0.0)
    seen = sub(motion.velocity, rotate(motion.q_nb, (airspeed, 0.0, 0.0)))
    learned_s = air.learned_s + dt_s
    share = dt_s / min(learned_s, WIND_S)
    return Air(add(air.wind, scale(sub(seen, air.wind), share)), learned_s, 0.0)


def held_by_air(motion: Motion, air: Air, airspeed: float, settings: FlightParameters) -> Motion:
    """The motion after the three rows of a wing's velocity through the air."""
    variance = settings.speed_noise**2 / air.waited_s
    for axis in range(3):
        motion = _supposed(motion, wing_row(motion, air.wind, axis, airspeed), variance)
    return motion


def wing_row(motion: Motion, wind: Vec3, axis: int, airspeed: float) -> Row:
    """One axis of C^T (v - wind) = (airspeed, 0, 0): with c an axis of the body, c.v + theta.(c x v) + c.dv."""
    through_air = sub(motion.velocity, wind)
    c = transpose(q_to_matrix(motion.q_nb))[axis]
    expected = airspeed if axis == 0 else 0.0
    return Row(expected - dot(c, through_air), t=cross(c, through_air), v=c)


def held_by_gravity(motion: Motion, force: Vec3, waited_s: float, settings: FlightParameters) -> Motion:
    """The motion after two rows of zero horizontal acceleration; ``force``: specific force, NED, m/s^2."""
    variance = settings.gravity_noise**2 / waited_s
    first, second = gravity_rows(force)
    return _supposed(_supposed(motion, first, variance), second, variance)


def held_in_place(motion: Motion, waited_s: float, settings: FlightParameters) -> Motion:
    """The motion after three rows of zero velocity."""
    variance = settings.place_noise**2 / waited_s
    for axis in range(3):
        motion = _soft(motion, Row(-motion.velocity[axis], v=unit_axis(axis)), variance)
    return motion


def gravity_rows(force: Vec3) -> tuple[Row, Row]:
    """The true acceleration is C f + theta x (C f) + g: what is seen of it in the horizontal is a tilt error."""
    x, y, z = force
    return (Row(-x, t=(0.0, z, -y)), Row(-y, t=(-z, 0.0, x)))


def _soft(motion: Motion, row: Row, variance: float) -> Motion:
    """The motion after a row with inflated variance."""
    seen = reach_of(motion, row)
    return updated(motion, row, seen, _inflated(row, seen, variance))


def _supposed(motion: Motion, row: Row, variance: float) -> Motion:
    """The same, of a row that is not measured."""
    seen = reach_of(motion, row)
    return supposed(motion, row, seen, _inflated(row, seen, variance))


def _inflated(row: Row, seen: Reach, variance: float) -> float:
    """The variance, growing with the residual from ``GATE`` sigmas on (paper 2, eq. (16))."""
    return variance * max(1.0, abs(row.residual) / sqrt(seen.variance + variance) / GATE)
