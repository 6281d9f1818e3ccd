"""The attitude that the autopilot reports: the truth, slow errors of its filter, and what faults make of it."""

from math import pi, sin

from attest_mav.algebra import add, q_exp, q_mul, scale
from attest_mav.sim.draws import generator
from attest_mav.sim.faults import NOWHERE, Effect, Faults, FaultSchedule, Part, has, total
from attest_mav.sim.lanes import Lanes
from attest_mav.sim.motion import Motion
from attest_mav.types import Quat, Vec3

PERIODS_S = ((37.0, 91.0), (43.0, 79.0), (53.0, 127.0))
"""Of the two sines that make up the error about north, east and down."""


class AttitudeReport:
    """The attitude at the time to which the lanes have come.

    amplitude: of the filter's own error in NED, rad: without faults the reported attitude is q_exp(e(t) / 2) * q_true.
    """

    def __init__(self, amplitude: Vec3, lanes: Lanes, faults: FaultSchedule, seed: int) -> None:
        rng = generator(str(seed), "attitude")
        self.amplitude = amplitude
        self.lanes = lanes
        self.faults = faults
        self.frozen: tuple[Quat, Vec3] | None = None
        """Attitude and rates at the moment the report froze; None while it does not."""
        self.phases = [(rng.uniform(0.0, 2.0 * pi), rng.uniform(0.0, 2.0 * pi)) for _ in range(3)]

    def at(self, t_s: float, motion: Motion) -> tuple[Quat, Vec3]:
        """Reported q_nb and body rates (rad/s) at a time of the simulation, with the true motion then."""
        faults = self.faults.active(Part.ATTITUDE, t_s)
        if not has(faults, Effect.FREEZE):
            self.frozen = None
        elif self.frozen is None:
            self.frozen = self._reported(t_s, motion, faults)
        return self._reported(t_s, motion, faults) if self.frozen is None else self.frozen

    def _reported(self, t_s: float, motion: Motion, faults: Faults) -> tuple[Quat, Vec3]:
        error = add(add(self.error(t_s), self.lanes.angle), total(faults, Effect.OFFSET))
        q_nb = q_mul(q_exp(scale(error, 0.5)), motion.q_nb)
        if has(faults, Effect.TRIM):
            q_nb = q_mul(q_nb, q_exp(scale(total(faults, Effect.TRIM), 0.5)))
        wrong = self.lanes.rate
        return q_nb, motion.rates if wrong == NOWHERE else add(motion.rates, wrong)

    def error(self, t_s: float) -> Vec3:
        """The filter's own error as a rotation vector in NED, rad, at most ``amplitude`` about each axis."""
        x, y, z = (
            0.5 * a * (sin(2.0 * pi * t_s / slow + p) + sin(2.0 * pi * t_s / fast + q))
            for a, (fast, slow), (p, q) in zip(self.amplitude, PERIODS_S, self.phases, strict=True)
        )
        return (x, y, z)
