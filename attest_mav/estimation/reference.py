"""One source of the autopilot's attitudes: its time stamps, repeats, and the evidence against it."""

from typing import Final

from attest_mav.algebra import norm, tilt_between
from attest_mav.estimation.field_support import FieldSupport
from attest_mav.estimation.offset import OffsetMonitor
from attest_mav.estimation.timebase import wrapped_difference_ns
from attest_mav.samples import AttitudeSample
from attest_mav.types import Quat, Vec3

LONGEST_S: Final = 0.2
"""One attitude counts for at most this time as evidence, s."""
FROZEN_COUNT: Final = 3
"""Bit-identical attitudes under different time stamps while the vehicle turns: an autopilot that works sends none."""
FROZEN_RATE: Final = 0.02
"""rad/s."""
INTERVAL_SHARE: Final = 0.1
"""Share of a new interval in the usual one."""
CONTRADICTION: Final = 0.02
"""rad: two attitudes of one time stamp that differ by more cannot both be the autopilot's."""


class Reference:
    """State of the comparison with one source of attitudes."""

    def __init__(self, offset: OffsetMonitor) -> None:
        self.offset: Final = offset
        self.field: Final = FieldSupport()
        """The magnetic field as evidence between these attitudes and ours."""
        self.evidence_s = 0.0
        """Time for which all of our attitudes were contradicted, less the time for which they were not, s."""
        self.disagrees = False
        """Whether the evidence is enough for a disagreement."""
        self.is_accused = False
        """Whether the newest verdict on it was DISAGREE."""
        self.interval_s = 0.0
        """The usual interval of its time stamps, s; 0 while it is not known."""
        self.contradictions = 0
        """Attitudes that contradict another one of the same time stamp."""
        self._last_ns = -1
        self._last_q: Quat = (0.0, 0.0, 0.0, 0.0)
        self._same_count = 1

    def repeats(self, sample: AttitudeSample) -> bool:
        """True for a copy of the newest attitude, as a router loop or a second link makes it."""
        if sample.t_ns != self._last_ns:
            return False
        if sample.q_nb == self._last_q:
            return True
        if tilt_between(sample.q_nb, self._last_q) > CONTRADICTION:
            self.contradictions += 1
        return False

    def advance(self, sample: AttitudeSample) -> float:
        """Go on to this attitude; the time that it may count for as evidence, s."""
        first = self._last_ns < 0
        elapsed_s = 0.0 if first else wrapped_difference_ns(sample.t_ns, self._last_ns) * 1e-9
        if elapsed_s != 0.0:
            self._same_count = self._same_count + 1 if sample.q_nb == self._last_q else 1
        if elapsed_s > 0.0:
            usual = self.interval_s if self.interval_s > 0.0 else elapsed_s
            self.interval_s = usual + INTERVAL_SHARE * (elapsed_s - usual)
        if first or elapsed_s >= 0.0 or elapsed_s < -1.0:
            self._last_ns, self._last_q = sample.t_ns, sample.q_nb
        return min(max(elapsed_s, 0.0), LONGEST_S)

    def is_frozen(self, rates: Vec3) -> bool:
        """True when the autopilot repeats one attitude bit for bit while the vehicle turns (rates: rad/s)."""
        return self._same_count >= FROZEN_COUNT and norm(rates) > FROZEN_RATE

    def add(self, seconds: float, hold_s: float) -> None:
        """Add to the evidence, or take from it; the disagreement begins at ``hold_s`` and ends at half of that."""
        self.evidence_s = min(max(self.evidence_s + seconds, 0.0), hold_s)
        if seconds > 0.0 and self.evidence_s >= hold_s:
            self.disagrees = True
        elif self.evidence_s <= 0.5 * hold_s:
            self.disagrees = False
