"""The receiver's fixes as one lane gets them: which is new, which repeats itself, and how well they usually fit."""

from typing import Final

from attest_mav.algebra import hypotenuse, norm, sub
from attest_mav.samples import VelocitySample
from attest_mav.types import Vec3

FROZEN_COUNT: Final = 4
FROZEN_SPEED: Final = 1.0
FROZEN_CHANGE: Final = 0.1
"""So many bit-identical velocities of more than the first (m/s) under new time stamps come from a receiver that has
frozen, where the filter's own velocity has changed by more than the second meanwhile."""
LEAST_GATE: Final = 3.0
LARGEST_GATE: Final = 12.0
GATE_USUALS: Final = 8.0
"""The gate on the normalised innovation squared of a fix, as a multiple of the usual one between these limits."""
RUN_FIXES: Final = 5
LEAST_RUN_GATE: Final = 1.0
RUN_GATE_USUALS: Final = 4.0
"""The gate on the mean of so many fixes in a row: a small error that stays is none by chance."""
USUAL_SHARE: Final = 0.02
USUAL_AT_START: Final = 0.1
INNOVATION_AT_START: Final = 0.1
"""m/s."""
LARGEST_USUALS: Final = 4.0
"""One innovation counts for at most so many of the usual ones."""


class FixStream:
    """Follows the fixes of one lane."""

    def __init__(self) -> None:
        self.usual_nis = USUAL_AT_START
        """Slow mean of the normalised innovation squared in good times."""
        self.usual_innovation = INNOVATION_AT_START
        """The same of the size of a horizontal innovation, m/s."""
        self._run: Final[list[float]] = []
        """The newest fixes, old to new."""
        self._newest_ns = -1
        self._velocity: Vec3 = (0.0, 0.0, 0.0)
        self._same = 1
        self._own_velocity: Vec3 = (0.0, 0.0, 0.0)
        self._change = 0.0

    @property
    def gate(self) -> float:
        """A fix beyond this is not used."""
        return min(LARGEST_GATE, max(LEAST_GATE, GATE_USUALS * self.usual_nis))

    @property
    def misfit(self) -> float:
        """How far the newest fixes are off, the newest one or all in a row, as a share of the gate on that."""
        if not self._run:
            return 0.0
        alone = self._run[-1] / self.gate
        if len(self._run) < RUN_FIXES:
            return alone
        total = 0.0
        for nis in self._run:
            total += nis
        return max(alone, total / RUN_FIXES / max(LEAST_RUN_GATE, RUN_GATE_USUALS * self.usual_nis))

    def take(self, nis: float) -> None:
        """Take the next fix beside the lane, used or not."""
        if len(self._run) == RUN_FIXES:
            del self._run[0]
        self._run.append(nis)

    def forget_misfit(self) -> None:
        """The lane goes on from another state: what did not fit the old one says nothing of it."""
        self._run.clear()

    @property
    def frozen(self) -> bool:
        """True while the receiver repeats one velocity."""
        return self._same >= FROZEN_COUNT and norm(self._velocity) > FROZEN_SPEED and self._change > FROZEN_CHANGE

    def is_new(self, fix: VelocitySample | None, spacing_s: float, velocity: Vec3) -> bool:
        """True for the first sample that comes with this fix, unless it follows the last one too soon.

        velocity: the filter's own, NED, m/s.
        """
        if fix is None or fix.t_ns == self._newest_ns:
            return False
        if 0.0 < (fix.t_ns - self._newest_ns) * 1e-9 < spacing_s - 1e-3:
            return False
        self._newest_ns = fix.t_ns
        if fix.v_ned == self._velocity:
            self._same += 1
        else:
            self._same, self._own_velocity = 1, velocity
        self._change = norm(sub(velocity, self._own_velocity))
        self._velocity = fix.v_ned
        return True

    def expect(self, nis: float) -> None:
        """From now on this is usual, if it is more: the receiver has turned out noisier."""
        self.usual_nis = max(self.usual_nis, nis)

    def learn(self, nis: float, innovation: Vec3) -> None:
        """A fix was used in good times. Fixes that are off in a row are not usual."""
        if self.misfit > 1.0:
            return
        size = min(hypotenuse(innovation[0], innovation[1]), LARGEST_USUALS * self.usual_innovation)
        self.usual_innovation += USUAL_SHARE * (size - self.usual_innovation)
        self.usual_nis += USUAL_SHARE * (min(nis, LARGEST_GATE) - self.usual_nis)
