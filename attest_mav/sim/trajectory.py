"""The true motions. Each stands still for ``STILL_S`` seconds first, so that a filter can align, and then never ends.

===================  ==============================================================================================
``still``            on the ground, slightly tilted
``hover``            a copter holding its place in gusts: a few degrees of tilt, slow yaw
``coordinated-turns``  a plane: take-off run, climb, then 540 degree turns to the right at 30 and to the left at 45
                     degrees of bank between short straights; the accelerometer never sees the bank
``square``           a copter flying a 40 m square, nose on track: up to 18 degrees of tilt, 90 degree yaws between
``tumbling``         turning over and over about all axes at up to about 3 rad/s while moving a little
===================  ==============================================================================================
"""

from abc import ABC, abstractmethod
from math import atan2, cos, pi, radians, sin, tan
from random import Random
from typing import Final

from attest_mav.errors import UsageError
from attest_mav.sim.motion import (
    ZERO,
    Jet,
    Motion,
    body_rates,
    constant,
    lifted_motion,
    plus,
    scaled,
    sine,
    smooth_ramp,
    smooth_step,
    times,
)
from attest_mav.types import G_MPS2, Vec3

STILL_S: Final = 6.0
"""How long every vehicle stands still at the start."""

TAKEOFF_S: Final = 5.0
HEIGHT_M: Final = 12.0
"""A copter climbs to this height in that time."""


class Trajectory(ABC):
    """A motion that is a function of time: no state, any order of calls. Time is in seconds from the start."""

    flies = True
    is_plane = False

    @abstractmethod
    def at(self, t_s: float) -> Motion:
        """The motion at time ``t_s``."""

    @abstractmethod
    def position(self, t_s: float) -> Vec3:
        """Position in NED from the start, m; its derivative is the velocity of ``at``."""


class Still(Trajectory):
    """On the ground, rolled 2 degrees, pitched -1, nose at 60 degrees."""

    flies = False

    def __init__(self) -> None:
        self.motion = Motion((radians(2.0), radians(-1.0), radians(60.0)), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3)

    def at(self, t_s: float) -> Motion:
        """See ``Trajectory``."""
        return self.motion

    def position(self, t_s: float) -> Vec3:
        """See ``Trajectory``."""
        return (0.0, 0.0, 0.0)


class CopterPath(Trajectory):
    """A copter on a path given as jets; the thrust does what the path needs."""

    @abstractmethod
    def path(self, t_s: float) -> tuple[Jet, Jet, Jet, Jet]:
        """North, east, down (m) and yaw (rad)."""

    def at(self, t_s: float) -> Motion:
        """See ``Trajectory``."""
        return lifted_motion(*self.path(t_s))

    def position(self, t_s: float) -> Vec3:
        """See ``Trajectory``."""
        north, east, down, _ = self.path(t_s)
        return (north[0], east[0], down[0])


def climb(t_s: float) -> Jet:
    """Down coordinate of a copter's take-off."""
    return scaled(smooth_step(t_s, STILL_S, TAKEOFF_S), -HEIGHT_M)


class Hover(CopterPath):
    """Holding place in gusts: each axis is pushed about by sines of incommensurate, seeded frequency and phase."""

    YAW = radians(60.0)
    HORIZONTAL_HZ = (0.07, 0.17, 0.37)
    VERTICAL_HZ = (0.11, 0.29)
    YAW_HZ = (0.03, 0.11)

    def __init__(self, rng: Random) -> None:
        self.north = self._gusts(rng, self.HORIZONTAL_HZ, 0.3)
        self.east = self._gusts(rng, self.HORIZONTAL_HZ, 0.3)
        self.down = self._gusts(rng, self.VERTICAL_HZ, 0.25)
        self.yaw = [(radians(9.0), omega, phase) for _, omega, phase in self._gusts(rng, self.YAW_HZ, 1.0)]

    @staticmethod
    def _gusts(rng: Random, frequencies_hz: tuple[float, ...], push: float) -> list[tuple[float, float, float]]:
        """(amplitude, omega, phase) of sines that each accelerate by up to about ``push``, m/s^2."""
        gusts = []
        for frequency_hz in frequencies_hz:
            omega = 2.0 * pi * frequency_hz * rng.uniform(0.8, 1.25)
            gusts.append((push * rng.uniform(0.7, 1.3) / omega**2, omega, rng.uniform(0.0, 2.0 * pi)))
        return gusts

    def path(self, t_s: float) -> tuple[Jet, Jet, Jet, Jet]:
        """See ``CopterPath``."""
        wind = smooth_step(t_s, STILL_S + 2.0, 6.0)
        return (
            self._pushed(t_s, self.north, wind),
            self._pushed(t_s, self.east, wind),
            plus(climb(t_s), self._pushed(t_s, self.down, wind)),
            plus(constant(self.YAW), self._pushed(t_s, self.yaw, wind)),
        )

    @staticmethod
    def _pushed(t_s: float, gusts: list[tuple[float, float, float]], wind: Jet) -> Jet:
        if wind[0] == 0.0:
            return ZERO
        total = ZERO
        for amplitude, omega, phase in gusts:
            total = plus(total, sine(t_s, amplitude, omega, phase))
        return times(total, wind)


class Square(CopterPath):
    """Laps of a square to the right: speed up, fly, slow down, turn on the spot, and so on."""

    SIDE_M = 40.0
    SPEED = 6.0
    RAMP_S = 4.0
    LEG_S = SIDE_M / SPEED + RAMP_S
    CORNER_S = 4.0
    YAW = radians(60.0)
    DIRECTIONS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
    """Of the four legs, (along, across) the first one."""

    def path(self, t_s: float) -> tuple[Jet, Jet, Jet, Jet]:
        """See ``CopterPath``."""
        since = t_s - STILL_S - TAKEOFF_S
        period = self.LEG_S + self.CORNER_S
        leg = max(int(since // period), 0)
        tau = since - leg * period
        done = plus(
            smooth_ramp(tau, 0.0, self.RAMP_S), scaled(smooth_ramp(tau, self.SIDE_M / self.SPEED, self.RAMP_S), -1.0)
        )
        along, across = self._corner(leg)
        step = self.DIRECTIONS[leg % 4]
        x = plus(constant(along), scaled(done, self.SPEED * step[0]))
        y = plus(constant(across), scaled(done, self.SPEED * step[1]))
        turn = scaled(smooth_step(tau, self.LEG_S, self.CORNER_S), 0.5 * pi)
        cos_yaw, sin_yaw = cos(self.YAW), sin(self.YAW)
        return (
            plus(scaled(x, cos_yaw), scaled(y, -sin_yaw)),
            plus(scaled(x, sin_yaw), scaled(y, cos_yaw)),
            climb(t_s),
            plus(constant(self.YAW + 0.5 * pi * leg), turn),
        )

    def _corner(self, leg: int) -> tuple[float, float]:
        """Where a leg starts, m along and across the first leg."""
        return ((0.0, 0.0), (self.SIDE_M, 0.0), (self.SIDE_M, self.SIDE_M), (0.0, self.SIDE_M))[leg % 4]


class Tumbling(CopterPath):
    """Turning over about all three axes, on its way round a small figure. The attitude does not follow the path."""

    def path(self, t_s: float) -> tuple[Jet, Jet, Jet, Jet]:
        """See ``CopterPath``; the yaw is not used."""
        swing = smooth_step(t_s, STILL_S, 3.0)
        return (
            times(sine(t_s, 0.8, 1.3, 0.4), swing),
            times(sine(t_s, 0.6, 1.7, 1.1), swing),
            times(sine(t_s, 0.5, 1.1, 2.0), swing),
            ZERO,
        )

    def at(self, t_s: float) -> Motion:
        """See ``Trajectory``."""
        north, east, down, _ = self.path(t_s)
        grow = smooth_step(t_s, STILL_S, 3.0)
        turned = smooth_ramp(t_s, STILL_S, 3.0)
        roll = plus(scaled(turned, 0.9), times(grow, sine(t_s, 0.8, 1.1, 0.0)))
        pitch = times(grow, sine(t_s, 1.9, 0.53, 0.5))
        yaw = plus(plus(constant(1.0), scaled(turned, 0.35)), times(grow, sine(t_s, 0.9, 0.7, 1.0)))
        return Motion(
            (roll[0], pitch[0], yaw[0]),
            body_rates(roll[0], pitch[0], (roll[1], pitch[1], yaw[1])),
            (north[1], east[1], down[1]),
            (north[2], east[2], down[2]),
        )


class CoordinatedTurns(Trajectory):
    """A plane without angle of attack or side-slip: the nose is where the velocity is, the side force is zero.

    In a turn at the heading rate W and speed V the bank is atan(V W / g). The heading is given in closed form; the
    position is its integral, by Gauss-Legendre quadrature, and remembered for every whole second.
    """

    is_plane = True

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


SCENARIOS: Final = ("still", "hover", "coordinated-turns", "square", "tumbling")


def make_trajectory(name: str, seed: int) -> Trajectory:
    """The trajectory of that name; UsageError lists the names there are. Only ``hover`` depends on the seed."""
    if name == "still":
        return Still()
    if name == "hover":
        return Hover(Random(f"hover {seed}"))  # noqa: S311  # a simulation, no secret
    if name == "coordinated-turns":
        return CoordinatedTurns()
    if name == "square":
        return Square()
    if name == "tumbling":
        return Tumbling()
    raise UsageError(f"unknown scenario {name[:40]!r}: expected one of {', '.join(SCENARIOS)}")
