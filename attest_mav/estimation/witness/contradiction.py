"""All lanes contradict the receiver: the explanations that are tried, and the decision between them."""

from typing import Final

from attest_mav.estimation.witness.candidate import Candidate, Explanation, Hypothesis
from attest_mav.estimation.witness.flight_state import navigation_of
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.estimation.witness.moments import Moment
from attest_mav.filters.velocity_aided.filter import VelocityAided

SCORED_NS: Final = 1_600_000_000
"""Explanations are scored from so long before the contradiction."""
SENSOR_STARTS_NS: Final = tuple(int(1e9 * s) for s in (0.5, 1.0, 1.5, 2.0, 3.0, 4.5, 6.5, 9.0))
"""How long before the contradiction all gyros, or all accelerometers, may have stepped."""
LATE_STARTS_NS: Final = (0, 1_000_000_000, 2_500_000_000)
"""The same of the receiver's delay."""
SHIFTS_S: Final = tuple(0.05 * k for k in range(-2, 11))
LEAST_STEP_S: Final = 0.1
"""Shifts of the receiver's fixes that are tried; a smaller step belongs to the filter's own delay state."""
LIMIT_GATES: Final = 1.5
"""A fix beyond so many gates refutes an explanation."""
LEAD: Final = 6.0
"""The best explanation leads every other kind by this much when it is decided."""
LEAST_FIXES: Final = 2
RECEIVER_WAITS_NS: Final = 2_000_000_000
"""A receiver that makes no sense is not decided sooner while all gyros or all accelerometers still fit."""
PATIENCE_NS: Final = 3_000_000_000
"""Decided at the latest."""


def shifts_beside(present_s: float) -> list[float]:
    """The shifts that are a step away from the present one, s."""
    return [shift_s for shift_s in SHIFTS_S if abs(shift_s - present_s) > LEAST_STEP_S - 1e-6]


def hypotheses_at(contradicted_ns: int, present_s: float) -> list[Hypothesis]:
    """Everything that is tried when a fix that came at this instant contradicts; fixes are shifted by ``present_s``."""
    found = [
        Hypothesis(Explanation.RECEIVER, contradicted_ns, present_s),
        Hypothesis(Explanation.RECEIVER, contradicted_ns - SCORED_NS, present_s),
        Hypothesis(Explanation.OFFSET, contradicted_ns, present_s),
    ]
    for shift_s in shifts_beside(present_s):
        found += [Hypothesis(Explanation.LATE, contradicted_ns - start_ns, shift_s) for start_ns in LATE_STARTS_NS]
    for start_ns in SENSOR_STARTS_NS:
        found.append(Hypothesis(Explanation.GYROS, contradicted_ns - start_ns, present_s))
        found.append(Hypothesis(Explanation.ACCELEROMETERS, contradicted_ns - start_ns, present_s))
    return found


def run_again(
    hypothesis: Hypothesis, lane: LaneWatch, one: VelocityAided, contradicted_ns: int, shift_s: float
) -> Candidate | None:
    """A lane's last seconds under a hypothesis, up to now; None where they do not reach back far enough."""
    scored_ns = contradicted_ns - SCORED_NS
    first_ns = min(hypothesis.from_ns, scored_ns)
    oldest = lane.moments.oldest
    if oldest is None or (oldest.t_ns > first_ns and hypothesis.from_ns < oldest.t_ns):
        return None
    candidate: Candidate | None = None
    limit = max(3.0, LIMIT_GATES * lane.fixes.gate)
    for moment in lane.moments.since(first_ns):
        if candidate is None:
            if moment.before is None or navigation_of(moment.before) is None:
                if moment.t_ns >= hypothesis.from_ns:
                    return None
                continue
            candidate = Candidate(hypothesis, moment.before, shift_s, scored_ns, limit, lane.field)
        candidate.take(one, moment)
    return candidate


class Contradiction:
    """Explanations tried since a fix contradicted all lanes. contradicted_ns: time of that fix, sensor's clock."""

    def __init__(self, lane: LaneWatch, one: VelocityAided, contradicted_ns: int, shift_s: float) -> None:
        self.contradicted_ns: Final = contradicted_ns
        self.shift_s: Final = shift_s
        self.lane: Final = lane
        """The lane on which the explanations run."""
        self.candidates: list[Candidate] = []
        for hypothesis in hypotheses_at(contradicted_ns, shift_s):
            candidate = run_again(hypothesis, lane, one, contradicted_ns, shift_s)
            if candidate is not None:
                self.candidates.append(candidate)
        self._drop_refuted()

    def take(self, one: VelocityAided, moment: Moment) -> None:
        """Go on to the lane's next moment."""
        for candidate in self.candidates:
            candidate.take(one, moment)
        self._drop_refuted()

    def best_of(self, kind: Explanation) -> Candidate | None:
        """The best one of a kind that is not refuted."""
        best: Candidate | None = None
        for candidate in self.candidates:
            if candidate.hypothesis.kind == kind and (best is None or candidate.score < best.score):
                best = candidate
        return best

    @property
    def best(self) -> Candidate:
        """The best one of all; a receiver that makes no sense is never refuted."""
        return min(self.candidates, key=lambda candidate: candidate.score)

    def members(self) -> list[Candidate]:
        """The best of each kind that is about as good as the best of all."""
        least = self.best.score
        found: list[Candidate] = []
        for kind in Explanation:
            candidate = self.best_of(kind)
            if candidate is not None and candidate.score <= least + LEAD:
                found.append(candidate)
        return found

    def decided(self, now_ns: int) -> Candidate | None:
        """The explanation that is believed, None while that is open."""
        best = self.best
        elapsed_ns = now_ns - self.contradicted_ns
        if elapsed_ns >= PATIENCE_NS:
            return best
        if best.fixes < LEAST_FIXES or len(self.members()) > 1:
            return None
        if best.hypothesis.kind == Explanation.RECEIVER and elapsed_ns < RECEIVER_WAITS_NS:
            gyros, accels = self.best_of(Explanation.GYROS), self.best_of(Explanation.ACCELEROMETERS)
            if gyros is not None or accels is not None:
                return None
        return best

    def scores(self) -> str:
        """The scores of all kinds, for people."""
        parts: list[str] = []
        for kind in Explanation:
            candidate = self.best_of(kind)
            if candidate is not None:
                parts.append(f"{kind.name.lower()} {candidate.score:.0f}")
        return ", ".join(parts)

    def _drop_refuted(self) -> None:
        self.candidates = [
            candidate
            for candidate in self.candidates
            if candidate.hypothesis.kind == Explanation.RECEIVER or not candidate.is_refuted
        ]
