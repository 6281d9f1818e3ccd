"""The receiver beside all lanes: used, contradicted, or only watched while the lanes coast.

Two sensors that agree cannot be wrong together within a fix. A fix that contradicts all lanes therefore stops all of
them from using any, until one explanation leads.
"""

from collections.abc import Sequence
from typing import Final

from attest_mav.algebra import hypotenuse
from attest_mav.estimation.events import LaneEvent, LaneEventKind
from attest_mav.estimation.witness.candidate import Candidate, Explanation, Hypothesis
from attest_mav.estimation.witness.contradiction import Contradiction, run_again
from attest_mav.estimation.witness.doubt import FAR_GATES, Doubt
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.estimation.witness.moments import Moment
from attest_mav.estimation.witness.return_watch import ReturnWatch
from attest_mav.filters.velocity_aided.filter import VelocityAided

JOINT_GATES: Final = 0.7
"""All lanes contradict the fixes when each is beyond this share of its gate, and one beyond its gate."""

_WORDS: Final = {
    Explanation.RECEIVER: "the receiver's velocity makes no sense: it is not used",
    Explanation.OFFSET: "the receiver's velocity is off by a constant",
    Explanation.LATE: "the receiver's velocity is late",
    Explanation.GYROS: "all gyros have stepped",
    Explanation.ACCELEROMETERS: "all accelerometers have stepped: the receiver is not used",
}


class ReceiverMonitor:
    """Decides on the use of the fixes. Instants are those of the sensor's clock, ns."""

    def __init__(self, doubt: Doubt) -> None:
        self.contradiction: Contradiction | None = None
        self.coasting: ReturnWatch | None = None
        self.shift_s = 0.0
        """By how much fixes are older than they say, s."""
        self._doubt: Final = doubt
        self._judged_ns = -1

    @property
    def is_used(self) -> bool:
        """Whether the lanes take fixes."""
        return self.contradiction is None and self.coasting is None

    def candidates(self) -> tuple[Candidate, ...]:
        """Explanations that are members of the set; the receiver that makes no sense is the lane itself."""
        if self.contradiction is None:
            return ()
        members = self.contradiction.members()
        return tuple([one for one in members if one.hypothesis.kind != Explanation.RECEIVER])

    def abandon(self, lane: LaneWatch) -> None:
        """A lane stands aside, or has lost the attitude that was contradicted: explanations do not run on it."""
        if self.contradiction is not None and self.contradiction.lane is lane:
            self.contradiction = None

    def take(self, selected: LaneWatch, lanes: Sequence[LaneWatch], disputed: bool) -> LaneEvent | None:
        """Follow the lanes in good standing to the selected one's newest moment."""
        moment, one = selected.moments.newest, selected.filter
        if moment is None or one is None:
            return None
        if self.contradiction is not None:
            return self._decide(self.contradiction, selected, lanes, one, moment)
        if self.coasting is not None:
            return self._coast(self.coasting, selected, lanes, one, moment)
        return None if disputed else self._judge(selected, lanes, one, moment)

    def _judge(
        self, selected: LaneWatch, lanes: Sequence[LaneWatch], one: VelocityAided, moment: Moment
    ) -> LaneEvent | None:
        """Whether the newest fix contradicts all lanes; it is judged once all have seen it."""
        fix = selected.fix
        if fix is None or fix.t_ns == self._judged_ns:
            return None
        shares: list[float] = []
        misfits: list[float] = []
        for lane in lanes:
            if lane.fix is None or lane.fix.t_ns != fix.t_ns:
                return None
            shares.append(lane.fix.nis / lane.fixes.gate)
            misfits.append(lane.fixes.misfit)
        self._judged_ns = fix.t_ns
        self._on_probation(selected)
        self._doubt.take_fix(min(shares), moment.t_ns)
        if max(misfits) <= 1.0 or min(misfits) <= JOINT_GATES or not selected.proving.done:
            return None
        self.contradiction = Contradiction(selected, one, selected.fix_seen_ns, self.shift_s)
        if not self.contradiction.candidates:
            self.contradiction = None
            return None
        text = f"all sensors contradict the receiver: innovation {_size(selected):.1f} m/s"
        return _event(selected, moment, LaneEventKind.CONTRADICTED, text)

    def _on_probation(self, selected: LaneWatch) -> None:
        self._doubt.fix_on_probation(_size(selected), selected.fixes.usual_innovation, selected.field_fits)

    def _decide(
        self,
        contradiction: Contradiction,
        selected: LaneWatch,
        lanes: Sequence[LaneWatch],
        one: VelocityAided,
        moment: Moment,
    ) -> LaneEvent | None:
        """Run the explanations on, and act on the one that leads."""
        if selected is not contradiction.lane:
            self.contradiction = None
            return None
        contradiction.take(one, moment)
        fix = selected.fix
        if fix is not None and fix.t_ns != self._judged_ns:
            self._judged_ns = fix.t_ns
            if fix.nis > FAR_GATES * selected.fixes.gate:  # the set has the explanations: one fix is enough
                self._doubt.fix_contradicts(moment.t_ns)
        best = contradiction.decided(moment.t_ns)
        if best is None:
            return None
        self.contradiction = None
        self._doubt.fix_is_explained()
        self._believe(best, contradiction, selected, lanes)
        elapsed_s = (moment.t_ns - contradiction.contradicted_ns) * 1e-9
        text = f"{_words(best)} ({contradiction.scores()}; after {elapsed_s:.1f} s)"
        return _event(selected, moment, LaneEventKind.EXPLAINED, text)

    def _believe(
        self, best: Candidate, contradiction: Contradiction, selected: LaneWatch, lanes: Sequence[LaneWatch]
    ) -> None:
        """All lanes take the state that was run again under the explanation, or coast."""
        kind, usual = best.hypothesis.kind, selected.fixes.usual_innovation
        adopted = best
        if kind == Explanation.ACCELEROMETERS:
            without = contradiction.best_of(Explanation.RECEIVER)
            adopted = best if without is None else without
        if kind in (Explanation.RECEIVER, Explanation.ACCELEROMETERS):
            by_sensors = kind == Explanation.ACCELEROMETERS
            self.coasting = ReturnWatch(contradiction.contradicted_ns, usual, by_sensors, self.shift_s)
        elif kind == Explanation.GYROS:
            self._doubt.begin_probation()
        for lane in lanes:
            again = adopted if lane is selected else _again(adopted.hypothesis, contradiction, lane)
            if again is not None:
                lane.adopt(again.state)
        self.shift_s = best.hypothesis.shift_s

    def _coast(
        self,
        coasting: ReturnWatch,
        selected: LaneWatch,
        lanes: Sequence[LaneWatch],
        one: VelocityAided,
        moment: Moment,
    ) -> LaneEvent | None:
        """Watch the receiver until it makes sense again."""
        returned = coasting.take(selected, lanes, one, moment)
        if returned is None:
            return None
        self.coasting = None
        self._judged_ns = -1 if selected.fix is None else selected.fix.t_ns
        self.shift_s = returned.shift_s
        text = f"the receiver is used again: its velocity is {returned.words}"
        return _event(selected, moment, LaneEventKind.RECEIVER_USED, text)


def _again(hypothesis: Hypothesis, contradiction: Contradiction, lane: LaneWatch) -> Candidate | None:
    """The explanation on another lane."""
    if lane.filter is None:
        return None
    return run_again(hypothesis, lane, lane.filter, contradiction.contradicted_ns, contradiction.shift_s)


def _words(best: Candidate) -> str:
    words = _WORDS[best.hypothesis.kind]
    return f"{words} by {best.hypothesis.shift_s:.2f} s" if best.hypothesis.kind == Explanation.LATE else words


def _size(lane: LaneWatch) -> float:
    """Horizontal size of the newest innovation, m/s."""
    return 0.0 if lane.fix is None else hypotenuse(lane.fix.innovation[0], lane.fix.innovation[1])


def _event(lane: LaneWatch, moment: Moment, kind: LaneEventKind, text: str) -> LaneEvent:
    return LaneEvent(lane.name, kind, moment.t_ns, moment.sample.rx_ns, text)
