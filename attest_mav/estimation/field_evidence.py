"""The readings of one magnetometer as evidence between the autopilot's attitude and ours.

Gyros that are off alike turn every attitude of ours away from a right autopilot, and look like an autopilot that is
wrong. The field tells both apart: each attitude levels the same reading, and the one under which the field keeps the
direction that it had while both agreed is the right one. A reading that jumps under both attitudes is the
magnetometer's own change, and moves that direction.
"""

from math import asin, nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, clamp, norm, rotate, scale, sub, unit
from attest_mav.estimation.timebase import wrapped_difference_ns
from attest_mav.estimation.witness.field_watch import FieldWatch
from attest_mav.record import Record
from attest_mav.types import Quat, Vec3

LARGEST_EVIDENCE: Final = 12.0
"""The evidence is limited to this size, so that a new fault of the other side is seen soon."""
JUMP: Final = 0.06
JUMP_USUALS: Final = 6.0
"""Change of the direction between two readings, beyond both, as a share of the field: no turn makes it under both."""
FOREIGN: Final = 0.5
"""rad: a field whose inclination is further from that of the Earth's at the place was made by something else. A
calibrated magnetometer beside iron errs by some degrees."""
FRESH_S: Final = 1.5
"""Age of the last reading up to which the field tells something, s."""
APART_USUALS: Final = 2.0
APART_LEAST: Final = 0.012
"""Attitudes are apart for the field when they level a reading to directions that differ by more than both."""


@mypyc_attr(acyclic=True)  # as Sample
class FieldReading(Record):
    """One reading of a magnetometer, with what our filter made of it.

    field: in the body, gauss. hard_iron: of it by its filter, gauss. lane: the one whose attitude q_nb is, at the
    reading's instant t_ns. inclination: of the Earth's field at the place, rad, NaN where it is not known.
    """

    def __init__(
        self, field: Vec3, hard_iron: Vec3, lane: str, q_nb: Quat, t_ns: int, inclination: float = nan
    ) -> None:
        self.field: Final = field
        self.hard_iron: Final = hard_iron
        self.lane: Final = lane
        self.q_nb: Final = q_nb
        self.t_ns: Final = t_ns
        self.inclination: Final = inclination

    @property
    def is_foreign(self) -> bool:
        """Whether the Earth's field cannot be what it shows."""
        sine = clamp(self.direction(self.hard_iron)[2], -1.0, 1.0)
        return abs(asin(sine) - self.inclination) > FOREIGN

    def direction(self, hard_iron: Vec3) -> Vec3:
        """Direction of the field in NED by our attitude, free of this hard iron, unit length."""
        return rotate(self.q_nb, unit(sub(self.field, hard_iron)))


class FieldEvidence:
    """Log-likelihood ratio of one magnetometer's field between our attitude and one source of the autopilot's."""

    def __init__(self) -> None:
        self.ratio = 0.0
        """Above zero the field is for our attitude."""
        self.has_refuted = False
        """Whether the field was against our attitude beyond doubt since both last levelled it alike."""
        self._watch: Final = FieldWatch()
        """The direction that the field had while both agreed."""
        self._hard_iron: Vec3 = (0.0, 0.0, 0.0)
        """By our filter while both agreed: an attitude that is wrong takes its error for hard iron."""
        self._ours: Vec3 = (0.0, 0.0, 0.0)
        self._theirs: Vec3 = (0.0, 0.0, 0.0)
        self.is_foreign = False
        """Whether the newest reading cannot be of the Earth's field."""
        self._t_ns = -1

    def take(self, reading: FieldReading, turn: Quat, agree: bool) -> None:
        """Take the newest reading. turn: NED rotation from our attitude to the autopilot's; agree: they are near."""
        if reading.t_ns == self._t_ns:
            return
        self.is_foreign = reading.is_foreign
        if agree:
            self._hard_iron = reading.hard_iron
        ours = reading.direction(self._hard_iron)
        theirs = rotate(turn, ours)
        if self._t_ns >= 0:
            self._follow_jump(sub(ours, self._ours), sub(theirs, self._theirs))
        self._ours, self._theirs, self._t_ns = ours, theirs, reading.t_ns
        watch = self._watch
        if agree or watch.mean is not None:
            watch.take(scale(add(ours, theirs), 0.5), reading.t_ns, agree)
        if agree:
            self.ratio, self.has_refuted = 0.0, self.has_refuted and self.shows_difference
        elif watch.mean is not None:
            ratio = self.ratio + watch.score_of(watch.residual_of(theirs)) - watch.score_of(watch.residual_of(ours))
            self.ratio = min(max(ratio, -LARGEST_EVIDENCE), LARGEST_EVIDENCE)
            self.has_refuted = self.has_refuted or self.ratio <= -LARGEST_EVIDENCE

    def speaks(self, now_ns: int) -> bool:
        """Whether the magnetometer has a say: a reading has come lately, and both attitudes have agreed before."""
        return self._watch.mean is not None and wrapped_difference_ns(now_ns, self._t_ns) * 1e-9 <= FRESH_S

    @property
    def shows_difference(self) -> bool:
        """Whether both attitudes level its newest reading to directions that are apart."""
        return norm(sub(self._theirs, self._ours)) > max(APART_LEAST, APART_USUALS * self._watch.usual)

    def _follow_jump(self, ours: Vec3, theirs: Vec3) -> None:
        """The magnetometer has changed: both attitudes see it."""
        if min(norm(ours), norm(theirs)) > max(JUMP, JUMP_USUALS * self._watch.usual):
            self._watch.shift(scale(add(ours, theirs), 0.5))
