"""The receiver beside all lanes: used, contradicted, or only watched while the lanes coast.

Two sensors that agree cannot be wrong together within a fix. A fix that contradicts all lanes therefore stops all of
them from using any, until one explanation leads.
"""

from collections.abc import Sequence
from math import hypot
from typing import Final

from attest_mav.algebra import heading_between, sub, tilt_between
from attest_mav.estimation.events import LaneEvent, LaneEventKind
from attest_mav.estimation.witness.candidate import DELAY_SIGMA, Candidate, Explanation, Hypothesis
from attest_mav.estimation.witness.challenger import Challenge, Challenger
from attest_mav.estimation.witness.coasting import Coasting
from attest_mav.estimation.witness.contradiction import Contradiction, run_again
from attest_mav.estimation.witness.doubt import Doubt
from attest_mav.estimation.witness.flight_state import (
    accel_bias,
    on_another_sensor,
    with_added_variance,
    with_delay_variance,
    with_velocity_unknown,
)
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.estimation.witness.moments import Moment
from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock
from attest_mav.filters.velocity_aided.filter import VelocityAided

JOINT_GATES: Final = 0.7
"""All lanes contradict a fix when each is beyond this share of its gate, and one beyond its gate."""
DOUBT_GATES: Final = 0.5
CHALLENGER_WAITS_NS: Final = 20_000_000_000
"""After accelerometers that stepped a challenger would only share their error; it is begun this much later."""
RESIDUAL_SHARE: Final = 0.1

_WORDS: Final = {
    Explanation.RECEIVER: "the receiver's velocity makes no sense: it is not used",
    Explanation.OFFSET: "the receiver's velocity is off by a constant",
    Explanation.LATE: "the receiver's velocity is late",
    Explanation.GYROS: "all gyros have stepped",
    Explanation.ACCELEROMETERS: "all accelerometers have stepped: the receiver is not used",
}


class ReceiverMonitor:
    """What becomes of the fixes. Instants are those of the sensor's clock, ns."""

    def __init__(self, doubt: Doubt) -> None:
        self.contradiction: Contradiction | None = None
        self.coasting: Coasting | None = None
        self.shift_s = 0.0
        """By how much fixes are older than they say, s."""
        self._doubt: Final = doubt
        self._challenger: Challenger | None = None
        self._lane_residual = 0.0
        self._judged_ns = -1

    @property
    def is_used(self) -> bool:
        """Whether the lanes take fixes."""
        return self.contradiction is None and self.coasting is None

    def candidates(self) -> list[Candidate]:
        """Explanations that are members of the set; the receiver that makes no sense is the lane itself."""
        if self.contradiction is None:
            return []
        members = self.contradiction.members()
        return [one for one in members if one.hypothesis.kind != Explanation.RECEIVER]

    def abandon(self) -> None:
        """The lane on which explanations ran is gone: what contradicted may have been its own fault."""
        self.contradiction = None

    def take(self, selected: LaneWatch, lanes: Sequence[LaneWatch], disputed: bool) -> list[LaneEvent]:
        """Follow the lanes in good standing to the selected one's newest moment."""
        moment, one = selected.moments.newest, selected.filter
        if moment is None or one is None:
            return []
        if self.contradiction is not None:
            return self._decide(self.contradiction, selected, lanes, one, moment)
        if self.coasting is not None:
            return self._coast(self.coasting, selected, lanes, one, moment)
        return [] if disputed else self._judge(selected, lanes, one, moment)

    def _judge(
        self, selected: LaneWatch, lanes: Sequence[LaneWatch], one: VelocityAided, moment: Moment
    ) -> list[LaneEvent]:
        """Whether the newest fix contradicts all lanes; it is judged once all have seen it."""
        fix = selected.fix
        if fix is None or fix.t_ns == self._judged_ns:
            return []
        shares: list[float] = []
        for lane in lanes:
            if lane.fix is None or lane.fix.t_ns != fix.t_ns:
                return []
            shares.append(lane.fix.nis / lane.fixes.gate)
        self._judged_ns = fix.t_ns
        self._on_probation(selected)
        if min(shares) > DOUBT_GATES:
            self._doubt.fix_contradicts(moment.t_ns)
        if max(shares) <= 1.0 or min(shares) <= JOINT_GATES:
            return []
        self.contradiction = Contradiction(selected, one, selected.fix_seen_ns, self.shift_s)
        if not self.contradiction.candidates:
            self.contradiction = None
            return []
        text = f"all sensors contradict the receiver: innovation {_size(selected):.1f} m/s"
        return [_event(selected, moment, LaneEventKind.CONTRADICTED, text)]

    def _on_probation(self, selected: LaneWatch) -> None:
        self._doubt.fix_on_probation(_size(selected), selected.fixes.usual_innovation, selected.field_fits)

    def _decide(
        self,
        contradiction: Contradiction,
        selected: LaneWatch,
        lanes: Sequence[LaneWatch],
        one: VelocityAided,
        moment: Moment,
    ) -> list[LaneEvent]:
        """Run the explanations on, and act on the one that leads."""
        if selected is not contradiction.lane:
            self.contradiction = None
            return []
        contradiction.take(one, moment)
        fix = selected.fix
        if fix is not None and fix.t_ns != self._judged_ns:
            self._judged_ns = fix.t_ns
            self._doubt.fix_contradicts(moment.t_ns)
        best = contradiction.decided(moment.t_ns)
        if best is None:
            return []
        self.contradiction = None
        self._doubt.fix_is_explained()
        self._believe(best, contradiction, selected, lanes)
        elapsed_s = (moment.t_ns - contradiction.contradicted_ns) * 1e-9
        text = f"{_words(best)} ({contradiction.scores()}; after {elapsed_s:.1f} s)"
        return [_event(selected, moment, LaneEventKind.EXPLAINED, text)]

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
            self._begin_coasting(contradiction.contradicted_ns, usual, kind == Explanation.ACCELEROMETERS)
        elif kind == Explanation.GYROS:
            self._doubt.begin_probation()
        for lane in lanes:
            again = adopted if lane is selected else _again(adopted.hypothesis, contradiction, lane)
            if again is not None:
                lane.adopt(again.state)
        self.shift_s = best.hypothesis.shift_s

    def _begin_coasting(self, now_ns: int, usual: float, by_sensors: bool) -> None:
        self.coasting = Coasting(now_ns, usual, by_sensors, self.shift_s)
        self._challenger = None
        self._lane_residual = 0.0

    def _coast(
        self,
        coasting: Coasting,
        selected: LaneWatch,
        lanes: Sequence[LaneWatch],
        one: VelocityAided,
        moment: Moment,
    ) -> list[LaneEvent]:
        """Watch the innovations until the receiver makes sense again."""
        self._challenge(coasting, selected, one, moment)
        fix = selected.fix
        if fix is None or fix.t_ns == self._judged_ns:
            return []
        self._judged_ns = fix.t_ns
        coasting.take(fix, selected.moments)
        late = coasting.lateness()
        if late is not None and late.is_proven:
            self.shift_s = late.shift_s
            return self._return(selected, lanes, moment, f"late by {late.shift_s:.2f} s", DELAY_SIGMA**2)
        if late is not None and late.is_suspected:
            return []
        if coasting.is_steady(selected.field_fits):
            return self._return(selected, lanes, moment, "steady", 0.0)
        return self._answer(selected, lanes, one, moment)

    def _challenge(self, coasting: Coasting, selected: LaneWatch, one: VelocityAided, moment: Moment) -> None:
        """Take the challenger on; it is begun at once, or later where the accelerometers did it."""
        waits_ns = CHALLENGER_WAITS_NS if coasting.by_sensors else 0
        if moment.t_ns - coasting.began_ns < waits_ns:
            return
        if self._challenger is None:
            self._challenger = Challenger(self.shift_s, moment)
        self._challenger.take(one, moment, selected.field)
        self._lane_residual += RESIDUAL_SHARE * (selected.field.residual - self._lane_residual)

    def _answer(
        self, selected: LaneWatch, lanes: Sequence[LaneWatch], one: VelocityAided, moment: Moment
    ) -> list[LaneEvent]:
        """Act on what the challenger shows."""
        challenger, state = self._challenger, selected.state
        if challenger is None or challenger.state is None or state is None:
            return []
        shown = challenger.shows(state, selected.field, self._lane_residual)
        if shown == Challenge.OPEN:
            return []
        if shown == Challenge.FAR:
            for lane in lanes:
                _take_over(one, lane, selected, challenger.state)
            self.coasting = self._challenger = None
            text = "the receiver is used again: a filter begun anew fits it, the attitude did not"
            return [_event(selected, moment, LaneEventKind.RECEIVER_USED, text)]
        apart = _apart(challenger.state, state)
        for lane in lanes:
            lane.fixes.expect(challenger.mean_nis)
            if lane.state is not None:
                lane.adopt(with_added_variance(one, lane.state, ErrorBlock.ATTITUDE, 0.5 * apart * apart))
        return self._return(selected, lanes, moment, "right by a filter begun anew", 0.0)

    def _return(
        self, selected: LaneWatch, lanes: Sequence[LaneWatch], moment: Moment, words: str, delay_variance: float
    ) -> list[LaneEvent]:
        """All lanes use the receiver again; nothing is known of the velocity, or of its error."""
        for lane in lanes:
            if lane.state is not None and lane.filter is not None:
                free = with_velocity_unknown(lane.filter, lane.state)
                lane.adopt(with_delay_variance(lane.filter, free, delay_variance))
        self.coasting = self._challenger = None
        text = f"the receiver is used again: its velocity is {words}"
        return [_event(selected, moment, LaneEventKind.RECEIVER_USED, text)]


def _again(hypothesis: Hypothesis, contradiction: Contradiction, lane: LaneWatch) -> Candidate | None:
    """The explanation on another lane."""
    if lane.filter is None:
        return None
    return run_again(hypothesis, lane, lane.filter, contradiction.contradicted_ns, contradiction.shift_s)


def _take_over(one: VelocityAided, lane: LaneWatch, selected: LaneWatch, state: FilterState) -> None:
    """A lane goes on from a state of the selected one, with its own biases."""
    own, theirs = lane.state, selected.state
    if lane is selected or own is None or theirs is None:
        lane.adopt(state)
        return
    gyro, accel = sub(own.gyro_bias, theirs.gyro_bias), sub(accel_bias(own), accel_bias(theirs))
    lane.adopt(on_another_sensor(one, state, gyro, accel, 0.0))


def _words(best: Candidate) -> str:
    words = _WORDS[best.hypothesis.kind]
    return f"{words} by {best.hypothesis.shift_s:.2f} s" if best.hypothesis.kind == Explanation.LATE else words


def _size(lane: LaneWatch) -> float:
    """Horizontal size of the newest innovation, m/s."""
    return 0.0 if lane.fix is None else hypot(lane.fix.innovation[0], lane.fix.innovation[1])


def _apart(a: FilterState, b: FilterState) -> float:
    return hypot(tilt_between(a.q_nb, b.q_nb), heading_between(a.q_nb, b.q_nb))


def _event(lane: LaneWatch, moment: Moment, kind: LaneEventKind, text: str) -> LaneEvent:
    return LaneEvent(lane.name, kind, moment.t_ns, moment.sample.rx_ns, text)
