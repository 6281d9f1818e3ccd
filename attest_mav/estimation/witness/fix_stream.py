"""The receiver's fixes as one lane gets them: which is new, which repeats itself, and how well they usually fit."""

from math import hypot
from typing import Final

from attest_mav.algebra import norm
from attest_mav.types import Vec3, VelocitySample

FROZEN_COUNT: Final = 4
"""So many bit-identical velocities at more than ``FROZEN_SPEED`` (m/s) under new time stamps come from a receiver that
has frozen."""
FROZEN_SPEED: Final = 1.0
LEAST_GATE: Final = 3.0
LARGEST_GATE: Final = 12.0
GATE_USUALS: Final = 8.0
"""The gate on the normalised innovation squared of a fix, as a multiple of the usual one between these limits."""
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
        self._newest_ns = -1
        self._velocity: Vec3 = (0.0, 0.0, 0.0)
        self._same = 1

    @property
    def gate(self) -> float:
        """A fix beyond this is not used."""
        return min(LARGEST_GATE, max(LEAST_GATE, GATE_USUALS * self.usual_nis))

    @property
    def frozen(self) -> bool:
        """True while the receiver repeats one velocity."""
        return self._same >= FROZEN_COUNT and norm(self._velocity) > FROZEN_SPEED

    def is_new(self, fix: VelocitySample | None, spacing_s: float) -> bool:
        """True for the first sample that comes with this fix, unless it follows the last one too soon."""
        if fix is None or fix.t_ns == self._newest_ns:
            return False
        if 0.0 < (fix.t_ns - self._newest_ns) * 1e-9 < spacing_s - 1e-3:
            return False
        self._newest_ns = fix.t_ns
        self._same = self._same + 1 if fix.v_ned == self._velocity else 1
        self._velocity = fix.v_ned
        return True

    def expect(self, nis: float) -> None:
        """From now on this is usual, if it is more: the receiver has turned out noisier."""
        self.usual_nis = max(self.usual_nis, nis)

    def learn(self, nis: float, innovation: Vec3) -> None:
        """A fix was used in good times."""
        size = min(hypot(innovation[0], innovation[1]), LARGEST_USUALS * self.usual_innovation)
        self.usual_innovation += USUAL_SHARE * (size - self.usual_innovation)
        self.usual_nis += USUAL_SHARE * (min(nis, LARGEST_GATE) - self.usual_nis)
