"""The attitude that the autopilot reports: the truth, slow errors of its filter, and injected faults."""

from math import pi, sin
from random import Random

from attest_mav.algebra import add, q_exp, q_mul, scale
from attest_mav.sim.motion import Motion
from attest_mav.sim.settings import Faults
from attest_mav.sim.trajectory import Trajectory
from attest_mav.types import Quat, Vec3

PERIODS_S = ((37.0, 91.0), (43.0, 79.0), (53.0, 127.0))
"""Of the two sines that make up the error about north, east and down."""


class AttitudeReport:
    """A function of time, so that it does not matter when or how often it is asked.

    amplitude: of the error in NED, rad: the reported attitude is q_exp(e(t) / 2) * q_true.
    """

    def __init__(self, trajectory: Trajectory, amplitude: Vec3, faults: Faults, seed: int) -> None:
        rng = Random(f"{seed} attitude")  # noqa: S311  # a simulation, no secret
        self.trajectory = trajectory
        self.amplitude = amplitude
        self.faults = faults
        self.phases = [(rng.uniform(0.0, 2.0 * pi), rng.uniform(0.0, 2.0 * pi)) for _ in range(3)]

    def at(self, t_s: float, motion: Motion) -> tuple[Quat, Vec3]:
        """Reported q_nb and body rates (rad/s) at a time of the simulation, with the true motion then."""
        start, end = self.faults.attitude_frozen
        if start <= t_s < end:
            t_s, motion = start, self.trajectory.at(start)
        error = self.error(t_s)
        if t_s >= self.faults.attitude_offset_from_s:
            error = add(error, self.faults.attitude_offset)
        return q_mul(q_exp(scale(error, 0.5)), motion.q_nb), motion.rates

    def error(self, t_s: float) -> Vec3:
        """The filter's own error as a rotation vector in NED, rad, at most ``amplitude`` about each axis."""
        x, y, z = (
            0.5 * a * (sin(2.0 * pi * t_s / slow + p) + sin(2.0 * pi * t_s / fast + q))
            for a, (fast, slow), (p, q) in zip(self.amplitude, PERIODS_S, self.phases, strict=True)
        )
        return (x, y, z)
