"""The way back from coasting: the receiver is steady, late, or right by a filter that was begun anew.

Each of them gives the lanes their receiver back with what is then known: nothing of the velocity, or a larger
variance, or another state.
"""

from collections.abc import Sequence
from math import hypot
from typing import Final

from attest_mav.algebra import heading_between, sub, tilt_between
from attest_mav.estimation.witness.candidate import DELAY_SIGMA
from attest_mav.estimation.witness.challenger import Challenge, Challenger
from attest_mav.estimation.witness.coasting import Coasting
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

CHALLENGER_WAITS_NS: Final = 20_000_000_000
"""After accelerometers that stepped a challenger would only share their error; it is begun this much later."""
RESIDUAL_SHARE: Final = 0.1
"""Share of a new field residual in the lane's mean one."""


class Returned:
    """The receiver is used again."""

    def __init__(self, words: str, shift_s: float) -> None:
        self.words: Final = words
        """The reason, for people."""
        self.shift_s: Final = shift_s
        """By how much fixes are older than they say from now on, s."""


class ReturnWatch:
    """Follows the innovations, and a challenger, while the lanes coast."""

    def __init__(self, began_ns: int, usual: float, by_sensors: bool, shift_s: float) -> None:
        """began_ns: sensor clock. usual: innovation before, m/s. by_sensors: the accelerometers have stepped.

        shift_s: by how much fixes are older than they say, s.
        """
        self._challenged_from_ns: Final = began_ns + (CHALLENGER_WAITS_NS if by_sensors else 0)
        self._shift_s: Final = shift_s
        self._innovations: Final = Coasting(usual, shift_s)
        self._challenger: Challenger | None = None
        self._lane_residual = 0.0
        self._fix_ns = -1

    def take(
        self, selected: LaneWatch, lanes: Sequence[LaneWatch], one: VelocityAided, moment: Moment
    ) -> Returned | None:
        """Follow the lanes to the selected one's newest moment; the return, once there is one."""
        self._run_challenger(selected, one, moment)
        fix = selected.fix
        if fix is None or fix.t_ns == self._fix_ns:
            return None
        self._fix_ns = fix.t_ns
        self._innovations.take(fix, selected.moments)
        late = self._innovations.lateness()
        if late is not None and late.is_proven:
            _free_velocity(lanes, DELAY_SIGMA**2)
            return Returned(f"late by {late.shift_s:.2f} s", late.shift_s)
        if late is not None and late.is_suspected:
            return None
        if self._innovations.is_steady(selected.field_fits):
            _free_velocity(lanes, 0.0)
            return Returned("off by a constant at most", self._shift_s)
        return self._answer(selected, lanes, one)

    def _run_challenger(self, selected: LaneWatch, one: VelocityAided, moment: Moment) -> None:
        if moment.t_ns < self._challenged_from_ns:
            return
        if self._challenger is None:
            self._challenger = Challenger(self._shift_s, moment)
        self._challenger.take(one, moment, selected.field)
        self._lane_residual += RESIDUAL_SHARE * (selected.field.residual - self._lane_residual)

    def _answer(self, selected: LaneWatch, lanes: Sequence[LaneWatch], one: VelocityAided) -> Returned | None:
        """The challenger's result, and the return to the receiver that follows from it."""
        challenger, state = self._challenger, selected.state
        if challenger is None or challenger.state is None or state is None:
            return None
        shown = challenger.shows(state, selected.field, self._lane_residual, selected.fixes.usual_nis)
        if shown == Challenge.OPEN:
            return None
        if shown == Challenge.FAR:
            for lane in lanes:
                _take_over(one, lane, selected, challenger.state)
            return Returned("right by a filter begun anew, the attitude was not", self._shift_s)
        apart = _apart(challenger.state, state)
        for lane in lanes:
            lane.fixes.expect(challenger.mean_nis)
            if lane.state is not None:
                lane.adopt(with_added_variance(one, lane.state, ErrorBlock.ATTITUDE, 0.5 * apart * apart))
        _free_velocity(lanes, 0.0)
        return Returned("right by a filter begun anew", self._shift_s)


def _free_velocity(lanes: Sequence[LaneWatch], delay_variance: float) -> None:
    """The lanes know nothing of their velocity any more, and less of the fixes' delay (s^2)."""
    for lane in lanes:
        if lane.state is not None and lane.filter is not None:
            free = with_velocity_unknown(lane.filter, lane.state)
            lane.adopt(with_delay_variance(lane.filter, free, delay_variance))


def _take_over(one: VelocityAided, lane: LaneWatch, selected: LaneWatch, state: FilterState) -> None:
    """A lane goes on from a state that was run on the selected one, with its own biases."""
    own, theirs = lane.state, selected.state
    if lane is selected or own is None or theirs is None:
        lane.adopt(state)
        return
    gyro, accel = sub(own.gyro_bias, theirs.gyro_bias), sub(accel_bias(own), accel_bias(theirs))
    lane.adopt(on_another_sensor(one, state, own, gyro, accel, 0.0))


def _apart(a: FilterState, b: FilterState) -> float:
    return hypot(tilt_between(a.q_nb, b.q_nb), heading_between(a.q_nb, b.q_nb))
