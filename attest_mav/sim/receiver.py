"""A GNSS receiver: five fixes a second, each telling of 100 ms before, as in ArduPilot's simulator."""

from math import exp, sqrt
from typing import Final

from attest_mav.algebra import add, scale, sub
from attest_mav.sim.draws import generator, noise
from attest_mav.sim.faults import NOWHERE, Effect, Faults, has, total
from attest_mav.sim.trajectory import Trajectory
from attest_mav.types import Vec3

GPS_PERIOD_NS: Final = 200_000_000
GPS_PHASE_NS: Final = 71_000_000
GPS_DELAY_S: Final = 0.1
GPS_SPEED_NOISE: Final = 0.04
"""m/s, one deviation of each horizontal component."""
GPS_POSITION_NOISE_M: Final = 0.3
WANDER_S: Final = 5.0
"""Time constant with which reflections move the velocity, s."""


class Gps:
    """The latest fix."""

    def __init__(self, trajectory: Trajectory, first_fix_s: float, seed: int) -> None:
        self.trajectory = trajectory
        self.rng = generator(str(seed), "gps")
        self.fault_rng = generator(str(seed), "gps fault")
        self.due_ns = GPS_PHASE_NS + GPS_PERIOD_NS * round(first_fix_s * 1e9 / GPS_PERIOD_NS)
        self.fix_ns = 0
        """Time of the latest fix, 0 before the first."""
        self.has_fix = False
        """Whether the receiver has a fix now."""
        self.position: Vec3 = NOWHERE
        """NED from the start, m."""
        self.velocity: Vec3 = NOWHERE
        """NED, m/s."""
        self.accuracy = 0.0
        """Reported standard deviation of the velocity, m/s; 0 for none."""
        self.error: Vec3 = NOWHERE
        """Error that faults have added to the velocity, NED, m/s."""
        self.wander: Vec3 = NOWHERE
        """Error of a velocity that wanders, as a share of its deviation."""

    def update(self, t_ns: int, faults: Faults = ()) -> None:
        """Take a fix if one is due."""
        if faults and has(faults, Effect.OFF):
            self.has_fix, self.error = False, NOWHERE
        if t_ns < self.due_ns:
            return
        due_ns = self.due_ns
        self.due_ns += GPS_PERIOD_NS
        at_s = due_ns * 1e-9 - GPS_DELAY_S
        errors = noise(self.rng, GPS_POSITION_NOISE_M), noise(self.rng, GPS_SPEED_NOISE)
        position = add(self.trajectory.position(at_s), errors[0])
        velocity = add(self.trajectory.at(at_s).v_ned, errors[1])
        if faults and has(faults, Effect.OFF):
            return
        self.fix_ns, self.has_fix = due_ns, True
        self.accuracy, self.error = 0.0, NOWHERE
        if not faults:
            self.position, self.velocity = position, velocity
            return
        self._take_wrong(at_s, errors, faults)
        self.error = sub(self.velocity, velocity)

    def _take_wrong(self, at_s: float, errors: tuple[Vec3, Vec3], faults: Faults) -> None:
        """The fix of that time, with its usual errors of position and velocity, as the faults make it."""
        if has(faults, Effect.FREEZE):
            return
        deviation = sum(fault.size for fault in faults if fault.effect is Effect.NOISE)
        earlier_s = at_s - sum(fault.size for fault in faults if fault.effect is Effect.LATE)
        self.position = add(self.trajectory.position(earlier_s), errors[0])
        velocity = add(self.trajectory.at(earlier_s).v_ned, errors[1])
        if deviation > 0.0:
            self.accuracy = deviation
            velocity = add(velocity, noise(self.fault_rng, deviation))
        velocity = add(velocity, self._wandered(faults))
        for fault in faults:
            if fault.effect is Effect.RAMP:
                velocity = add(velocity, scale(fault.vector, max(at_s - fault.start_s, 0.0)))
        self.velocity = add(velocity, total(faults, Effect.OFFSET))

    def _wandered(self, faults: Faults) -> Vec3:
        """The error of a velocity that wanders, m/s: a Gauss-Markov process of first order."""
        deviation = sum(fault.size for fault in faults if fault.effect is Effect.WANDER)
        if deviation == 0.0:
            return NOWHERE
        kept = exp(-1e-9 * GPS_PERIOD_NS / WANDER_S)
        self.wander = add(scale(self.wander, kept), noise(self.fault_rng, sqrt(1.0 - kept * kept)))
        return scale(self.wander, deviation)
