"""Airspeed of a vehicle that goes where it points: its velocity through the air lies along the nose.

While fixes arrive the wind is estimated from them; without fixes the velocity less that wind, seen in the body, is
(airspeed, 0, 0), a pseudo-measurement. (Motion constraints of this kind: Groves, Principles of GNSS, Inertial, and
Multisensor Integrated Navigation Systems, 2nd ed., section 15.4.)
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, dot, q_to_matrix, rotate, scale, square, sub
from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.aids.fallback import FallbackUpdate
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.innovation import Aid, Innovation
from attest_mav.matrices import transpose
from attest_mav.plausible import MAX_SPEED
from attest_mav.record import Record
from attest_mav.types import Vec3

WIND_S: Final = 20.0
"""Time constant of the wind's mean, s."""
FLYING_SPEED: Final = 6.0
"""m/s: below this airspeed the direction of motion is not along the nose."""


@mypyc_attr(acyclic=True)
class Wind(Record):
    """The wind estimate."""

    def __init__(self, velocity: Vec3, averaged_s: float) -> None:
        self.velocity: Final = velocity
        """NED, m/s, with what an angle of attack adds."""
        self.averaged_s: Final = averaged_s
        """Length of the time that its mean was made of, s; 0 while it is not known and taken for calm."""


def unknown_wind() -> Wind:
    """The wind before anything is known of it."""
    return Wind((0.0, 0.0, 0.0), 0.0)


def has_airspeed_of_flight(inputs: FilterInputs) -> bool:
    """True when the vehicle goes where it points, at an airspeed of flight."""
    return airspeed_ahead(inputs) > FLYING_SPEED


def airspeed_ahead(inputs: FilterInputs) -> float:
    """Airspeed along the nose, m/s; 0 where there is none that can be used."""
    airspeed = inputs.airspeed
    if airspeed is None or not inputs.goes_where_it_points:
        return 0.0
    return airspeed.speed if 0.0 < airspeed.speed < MAX_SPEED else 0.0


def estimate_wind(wind: Wind, nav: NavigationState, airspeed: float, dt_s: float) -> Wind:
    """The wind after a step with velocity fixes. airspeed: m/s; one too low for flight tells nothing."""
    if not airspeed > FLYING_SPEED:
        return wind
    seen = sub(nav.velocity, rotate(nav.q_nb, (airspeed, 0.0, 0.0)))
    averaged_s = wind.averaged_s + dt_s
    share = dt_s / min(averaged_s, WIND_S)
    return Wind(add(wind.velocity, scale(sub(seen, wind.velocity), share)), averaged_s)


def fuse_airspeed(
    nav: NavigationState, wind: Vec3, airspeed: float, since_update_s: float, t_ns: int, parameters: FlightParameters
) -> tuple[NavigationState, Innovation]:
    """The state after the three measurements of the velocity through the air. wind: NED, m/s."""
    update = FallbackUpdate(nav, square(parameters.speed_noise) / since_update_s, estimates_sensors=False)
    for axis in range(3):
        update.fuse(airspeed_measurement(update.nav, wind, axis, airspeed), airspeed if axis == 0 else 0.0)
    return update.nav, update.innovation(Aid.AIRSPEED, t_ns)


def airspeed_measurement(nav: NavigationState, wind: Vec3, axis: int, airspeed: float) -> Measurement:
    """One axis of C^T (v - wind) = (airspeed, 0, 0): with c an axis of the body, c.v + theta.(c x v) + c.dv."""
    through_air = sub(nav.velocity, wind)
    c = transpose(q_to_matrix(nav.q_nb))[axis]
    expected = airspeed if axis == 0 else 0.0
    return Measurement(expected - dot(c, through_air), t=cross(c, through_air), v=c)
