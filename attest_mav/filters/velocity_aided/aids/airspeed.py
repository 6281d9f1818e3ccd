"""Airspeed of a vehicle that goes where it points: its velocity through the air lies along the nose.

While fixes arrive the wind is estimated from them; without fixes the velocity less that wind, seen in the body, is
(airspeed, 0, 0), a pseudo-measurement.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, dot, q_to_matrix, rotate, scale, sub
from attest_mav.filters.velocity_aided.aids.pseudo_measurement import robust_consider_update
from attest_mav.filters.velocity_aided.covariance import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import transpose
from attest_mav.types import Vec3

WIND_S: Final = 20.0
"""Time constant of the wind's mean, s."""
FLYING_SPEED: Final = 6.0
"""m/s: below this airspeed the direction of motion is not along the nose."""


@mypyc_attr(acyclic=True)
class Wind:
    """The wind estimate. velocity: NED, m/s, with what an angle of attack adds. averaged_s: length of its mean.

    since_update_s: since the last update of a fallback aid.
    """

    def __init__(self, velocity: Vec3, averaged_s: float, since_update_s: float) -> None:
        self.velocity: Final = velocity
        self.averaged_s: Final = averaged_s
        self.since_update_s: Final = since_update_s


def unknown_wind() -> Wind:
    """The wind before anything is known of it: calm."""
    return Wind((0.0, 0.0, 0.0), 0.0, 0.0)


def estimate_wind(wind: Wind, nav: NavigationState, airspeed: float, dt_s: float) -> Wind:
    """The wind after a step with velocity fixes. The fallback timer is reset, because no fallback is needed."""
    if not airspeed > FLYING_SPEED:
        return Wind(wind.velocity, wind.averaged_s, 0.0)
    seen = sub(nav.velocity, rotate(nav.q_nb, (airspeed, 0.0, 0.0)))
    averaged_s = wind.averaged_s + dt_s
    share = dt_s / min(averaged_s, WIND_S)
    return Wind(add(wind.velocity, scale(sub(seen, wind.velocity), share)), averaged_s, 0.0)


def fuse_airspeed(nav: NavigationState, wind: Wind, airspeed: float, parameters: FlightParameters) -> NavigationState:
    """The state after the three measurements of the velocity through the air."""
    variance = parameters.speed_noise**2 / wind.since_update_s
    for axis in range(3):
        nav = robust_consider_update(nav, airspeed_measurement(nav, wind.velocity, axis, airspeed), variance)
    return nav


def airspeed_measurement(nav: NavigationState, wind: Vec3, axis: int, airspeed: float) -> Measurement:
    """One axis of C^T (v - wind) = (airspeed, 0, 0): with c an axis of the body, c.v + theta.(c x v) + c.dv."""
    through_air = sub(nav.velocity, wind)
    c = transpose(q_to_matrix(nav.q_nb))[axis]
    expected = airspeed if axis == 0 else 0.0
    return Measurement(expected - dot(c, through_air), t=cross(c, through_air), v=c)
