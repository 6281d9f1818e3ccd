"""A rover: level ground, and turns on nearly one spot, as fast as a vehicle with driven tracks makes them."""

from math import cos, radians, sin
from typing import Final

from attest_mav.mavlink.constants import MAV_TYPE_GROUND_ROVER
from attest_mav.sim.jets import Jet, constant, plus, scaled, smooth_ramp
from attest_mav.sim.motion import Motion
from attest_mav.sim.trajectory import STILL_S, Trajectory
from attest_mav.types import Vec3

YAW: Final = radians(60.0)


class Spins(Trajectory):
    """Circles of 0.2 m at up to 6 rad/s to the right and to the left by turns, with a rest between."""

    vehicle_type = MAV_TYPE_GROUND_ROVER

    RATE = 6.0
    RADIUS_M = 0.2
    RAMP_S = 1.0
    """The rate is reached, and given up, in this time."""
    TURN_S = 3.0
    """From the beginning of a turn to the beginning of its end."""
    REST_S = 2.0
    HALF_S = TURN_S + RAMP_S + REST_S
    """From one turn to the next, which goes the other way."""

    def heading(self, t_s: float) -> Jet:
        """Course over ground and heading, rad; what a turn to the right adds, one to the left takes away."""
        tau = max(t_s - STILL_S, 0.0) % (2.0 * self.HALF_S)
        return plus(constant(YAW), plus(self._turn(tau, 0.0, self.RATE), self._turn(tau, self.HALF_S, -self.RATE)))

    def _turn(self, tau: float, start: float, rate: float) -> Jet:
        begin = smooth_ramp(tau, start, self.RAMP_S)
        end = smooth_ramp(tau, start + self.TURN_S, self.RAMP_S)
        return scaled(plus(begin, scaled(end, -1.0)), rate)

    def at(self, t_s: float) -> Motion:
        """See ``Trajectory``."""
        heading, rate, d_rate, _ = self.heading(t_s)
        c, s, r = cos(heading), sin(heading), self.RADIUS_M
        velocity = (r * rate * c, r * rate * s, 0.0)
        acceleration = (r * (d_rate * c - rate * rate * s), r * (d_rate * s + rate * rate * c), 0.0)
        return Motion((0.0, 0.0, heading), (0.0, 0.0, rate), velocity, acceleration)

    def position(self, t_s: float) -> Vec3:
        """See ``Trajectory``."""
        heading = self.heading(t_s)[0]
        r = self.RADIUS_M
        return (r * (sin(heading) - sin(YAW)), r * (cos(YAW) - cos(heading)), 0.0)
