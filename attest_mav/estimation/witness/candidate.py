"""One explanation of a contradiction, run beside the lanes: the fault that it assumes, and its fit."""

from enum import IntEnum
from typing import Final

from attest_mav.estimation.witness.field_watch import FieldWatch
from attest_mav.estimation.witness.flight_state import (
    FixRecord,
    field_direction,
    has_field_reading,
    navigation_of,
    shifted,
    used_fix,
    with_added_variance,
    with_delay_variance,
    with_velocity_unknown,
)
from attest_mav.estimation.witness.moments import Instant
from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import VelocitySample

LARGEST_NIS: Final = 18.0
"""One fix counts for no more."""
UNUSED_COST: Final = 3.0
"""Of a fix that is not used, also of one that is too old for the velocity history."""
COST: Final = 8.0
"""Of every explanation but a receiver that makes no sense."""
GYRO_STEP: Final = 0.07
"""rad/s (4 deg/s): by how much all gyros may have stepped."""
ACCEL_STEP: Final = 1.5
"""m/s^2: by how much all accelerometers may have."""
DELAY_SIGMA: Final = 0.03
"""s: of a delay that has stepped."""


class Explanation(IntEnum):
    """The fault that a candidate assumes."""

    RECEIVER = 0
    """The receiver makes no sense."""
    OFFSET = 1
    """The receiver's velocity is off by a constant."""
    LATE = 2
    """Its velocity is older than it says."""
    GYROS = 3
    """All gyros have stepped."""
    ACCELEROMETERS = 4
    """All accelerometers have."""


class Hypothesis:
    """An explanation with its numbers.

    from_ns: the instant of the sensor's clock from which on it holds. shift_s: by how much fixes are older than they
    say from then on.
    """

    def __init__(self, kind: Explanation, from_ns: int, shift_s: float) -> None:
        self.kind: Final = kind
        self.from_ns: Final = from_ns
        self.shift_s: Final = shift_s

    @property
    def cost(self) -> float:
        """Penalty of the explanation, added to its score."""
        return 0.0 if self.kind == Explanation.RECEIVER else COST

    def begun(self, one: VelocityAided, state: FilterState) -> FilterState:
        """The state with which the explanation starts."""
        if self.kind == Explanation.OFFSET:
            return with_velocity_unknown(one, state)
        if self.kind == Explanation.LATE:
            return with_delay_variance(one, state, DELAY_SIGMA**2)
        if self.kind == Explanation.GYROS:
            return with_added_variance(one, state, ErrorBlock.GYRO_BIAS, GYRO_STEP**2)
        if self.kind == Explanation.ACCELEROMETERS:
            return with_added_variance(one, state, ErrorBlock.ACCEL_BIAS, ACCEL_STEP**2)
        return state


class Candidate:
    """A filter that runs under a hypothesis.

    state: at the moment before the first one that it takes. shift_s: by which fixes are older than they say before
    the hypothesis. scored_from_ns: from then on it is scored. limit: of the normalised innovation squared of a fix,
    beyond which it is refuted. field: of the lane, for its mean.
    """

    def __init__(
        self,
        hypothesis: Hypothesis,
        state: FilterState,
        shift_s: float,
        scored_from_ns: int,
        limit: float,
        field: FieldWatch,
    ) -> None:
        self.hypothesis: Final = hypothesis
        self.state = state
        self.score = hypothesis.cost
        self.is_refuted = False
        self.fixes = 0
        """Fixes since it holds."""
        self._scored_from_ns: Final = scored_from_ns
        self._limit: Final = limit
        self._field: Final = field
        self._begun = False
        self._shift_s = shift_s
        self._fix_ns = -1
        self._used_ns = -1

    def take(self, one: VelocityAided, moment: Instant) -> None:
        """Go on to the next moment."""
        if not self._begun and moment.t_ns >= self.hypothesis.from_ns:
            self._begun = True
            self.state = self.hypothesis.begun(one, self.state)
        fix = moment.inputs.velocity
        is_new = fix is not None and fix.t_ns != self._fix_ns
        if fix is not None and is_new:
            self._fix_ns = fix.t_ns
            if self._begun:
                self._shift_s = self.hypothesis.shift_s
        self.state = one.step(self.state, moment.dt_s, moment.sample, moment.inputs.with_velocity(self._given(fix)))
        if moment.t_ns >= self._scored_from_ns:
            self._score_fix(is_new, one)
            self._score_field(moment)
        self.is_refuted = self.is_refuted or navigation_of(self.state) is None

    def _given(self, fix: VelocitySample | None) -> VelocitySample | None:
        """The fix as the filter gets it."""
        if fix is None or (self._begun and self.hypothesis.kind == Explanation.RECEIVER):
            return None
        return shifted(fix, self._shift_s)

    def _score_fix(self, is_new: bool, one: VelocityAided) -> None:
        record = self._newly_used()
        if record is not None:
            self.score += 2.0 * min(record.nis, LARGEST_NIS)
            self.is_refuted = self.is_refuted or (self._begun and record.nis > self._limit)
        elif is_new:
            self.score += UNUSED_COST
            if self._begun and self.fixes > 0 and self.hypothesis.kind == Explanation.LATE:
                self.is_refuted = True
        if is_new and self._begun:
            self.fixes += 1

    def _newly_used(self) -> FixRecord | None:
        record = used_fix(self.state)
        if record is None or record.t_ns == self._used_ns:
            return None
        self._used_ns = record.t_ns
        return record

    def _score_field(self, moment: Instant) -> None:
        direction = field_direction(self.state, moment.sample) if has_field_reading(self.state) else None
        if direction is not None:
            self.score += self._field.score_of(self._field.residual_of(direction))
