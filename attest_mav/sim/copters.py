"""Copters: the thrust does what the path needs, so the path decides the tilt. And a body that tumbles."""

from abc import abstractmethod
from math import cos, pi, radians, sin
from random import Random
from typing import Final

from attest_mav.sim.jets import ZERO, Jet, constant, plus, scaled, sine, smooth_ramp, smooth_step, times
from attest_mav.sim.motion import Motion, body_rates, lifted_motion
from attest_mav.sim.trajectory import STILL_S, Trajectory
from attest_mav.types import Vec3

TAKEOFF_S: Final = 5.0
HEIGHT_M: Final = 12.0
"""A copter climbs to this height in that time."""


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
