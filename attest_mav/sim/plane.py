"""A plane: take-off run, climb, and long coordinated turns, in which the accelerometer never sees the bank."""

from math import atan2, cos, pi, radians, sin, tan

from attest_mav.mavlink.constants import MAV_TYPE_FIXED_WING
from attest_mav.sim.jets import Jet, constant, plus, scaled, smooth_ramp, smooth_step
from attest_mav.sim.motion import Motion, body_rates
from attest_mav.sim.trajectory import STILL_S, Trajectory
from attest_mav.types import G_MPS2, Vec3


class CoordinatedTurns(Trajectory):
    """A plane without angle of attack or side-slip: the nose is where the velocity is, the side force is zero.

    In a turn at the heading rate W and speed V the bank is atan(V W / g). The heading is given in closed form; the
    position is its integral, by Gauss-Legendre quadrature, and remembered for every whole second.
    """

    is_plane = True
    vehicle_type = MAV_TYPE_FIXED_WING

    SPEED = 22.0
    RUN_S = 8.0
    """The take-off run lasts this long."""
    CLIMB_AT_S = STILL_S + RUN_S
    CLIMB_MPS = 4.0
    CLIMB_S = 10.0
    CLIMB_RAMP_S = 3.0
    FIRST_TURN_S = STILL_S + RUN_S + CLIMB_S + 1.0
    YAW = radians(60.0)
    ROLL_IN_S = 3.0
    STRAIGHT_S = 8.0
    RIGHT = G_MPS2 * tan(radians(30.0)) / SPEED
    LEFT = -G_MPS2 * tan(radians(45.0)) / SPEED
    TURN = 3.0 * pi
    """540 degrees: the straights point to and fro, and the plane stays in the area."""

    # Nodes and weights of the three-point rule on [0, 1].
    NODES = ((0.5 - 0.15**0.5, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + 0.15**0.5, 5.0 / 18.0))

    def __init__(self) -> None:
        self.milestones: list[tuple[float, float]] = [(0.0, 0.0)]
        """North and east, m, at 0 s, 1 s, 2 s ..., as far as anyone has asked."""
        self.right_s = self.TURN / self.RIGHT
        self.left_s = self.TURN / -self.LEFT
        self.period_s = self.right_s + self.left_s + 2.0 * (self.ROLL_IN_S + self.STRAIGHT_S)

    def heading(self, t_s: float) -> Jet:
        """Course over ground and heading, rad."""
        tau = max(t_s - self.FIRST_TURN_S, 0.0)
        tau -= self.period_s * (tau // self.period_s)
        left_at = self.right_s + self.ROLL_IN_S + self.STRAIGHT_S
        right = self._turn(tau, 0.0, self.right_s, self.RIGHT)
        left = self._turn(tau, left_at, self.left_s, self.LEFT)
        return plus(constant(self.YAW), plus(right, left))

    def _turn(self, tau: float, start: float, lasts_s: float, rate: float) -> Jet:
        """A turn at ``rate``, rolled into and out of in ``ROLL_IN_S``; it turns by ``rate * lasts_s`` in all."""
        begin = smooth_ramp(tau, start, self.ROLL_IN_S)
        end = smooth_ramp(tau, start + lasts_s, self.ROLL_IN_S)
        return scaled(plus(begin, scaled(end, -1.0)), rate)

    def speed(self, t_s: float) -> Jet:
        """Horizontal speed, m/s."""
        return scaled(smooth_step(t_s, STILL_S, self.RUN_S), self.SPEED)

    def down(self, t_s: float) -> Jet:
        """Down coordinate, m."""
        up = smooth_ramp(t_s, self.CLIMB_AT_S, self.CLIMB_RAMP_S)
        level = smooth_ramp(t_s, self.CLIMB_AT_S + self.CLIMB_S - self.CLIMB_RAMP_S, self.CLIMB_RAMP_S)
        return scaled(plus(up, scaled(level, -1.0)), -self.CLIMB_MPS)

    def at(self, t_s: float) -> Motion:
        """See ``Trajectory``."""
        heading, speed, down = self.heading(t_s), self.speed(t_s), self.down(t_s)
        cos_heading, sin_heading = cos(heading[0]), sin(heading[0])
        across = speed[0] * heading[1]
        d_across = speed[1] * heading[1] + speed[0] * heading[2]
        bank, d_bank = atan2(across, G_MPS2), G_MPS2 * d_across / (G_MPS2**2 + across**2)
        pitch, d_pitch = atan2(-down[1], speed[0]) if down[1] else 0.0, 0.0
        if down[1]:
            d_pitch = (down[1] * speed[1] - down[2] * speed[0]) / (down[1] ** 2 + speed[0] ** 2)
        return Motion(
            (bank, pitch, heading[0]),
            body_rates(bank, pitch, (d_bank, d_pitch, heading[1])),
            (speed[0] * cos_heading, speed[0] * sin_heading, down[1]),
            (
                speed[1] * cos_heading - across * sin_heading,
                speed[1] * sin_heading + across * cos_heading,
                down[2],
            ),
        )

    def position(self, t_s: float) -> Vec3:
        """See ``Trajectory``."""
        second = max(int(t_s), 0)
        while len(self.milestones) <= second:
            last = len(self.milestones) - 1
            self.milestones.append(self._advanced(self.milestones[last], float(last), 1.0))
        north, east = self._advanced(self.milestones[second], float(second), t_s - second)
        return (north, east, self.down(t_s)[0])

    def _advanced(self, start: tuple[float, float], t_s: float, dt_s: float) -> tuple[float, float]:
        """North and east ``dt_s`` seconds (at most one) after ``start``; the rule is good to 0.2 mm over 100 s."""
        north, east = start
        for node, weight in self.NODES:
            at = t_s + node * dt_s
            step = dt_s * weight * self.speed(at)[0]
            heading = self.heading(at)[0]
            north += step * cos(heading)
            east += step * sin(heading)
        return north, east
