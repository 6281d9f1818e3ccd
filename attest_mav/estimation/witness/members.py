"""The set: the attitudes that are not refuted, beside the selected one."""

from math import radians
from typing import Final

from attest_mav.algebra import heading_between, q_conj, q_exp, q_mul, scale, sub, tilt_between
from attest_mav.estimation.difference import Member
from attest_mav.estimation.witness.candidate import Candidate
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.estimation.witness.moments import Moment
from attest_mav.filters.base import FilterState
from attest_mav.types import Quat

NEAR_TILT: Final = radians(0.7)
NEAR_HEADING: Final = radians(2.8)
"""rad: while something is disputed the selected attitude is published if all others are this near."""


def lane_member(selected: Moment, lane: LaneWatch) -> Member | None:
    """Another lane beside the selected one, carried to its instant by its own gyro."""
    newest, state = lane.moments.newest, lane.state
    if newest is None or state is None:
        return None
    apart_s = (selected.t_ns - newest.t_ns) * 1e-9
    rates = sub(newest.sample.gyro, state.gyro_bias)
    return _member(selected.state, state, q_mul(state.q_nb, q_exp(scale(rates, 0.5 * apart_s))))


def candidate_member(selected: Moment, candidate: Candidate) -> Member:
    """An explanation that runs on the selected lane."""
    return _member(selected.state, candidate.state, candidate.state.q_nb)


def is_near(selected: FilterState, member: Member) -> bool:
    """True where a member is near enough to the selected attitude to publish that."""
    other = q_mul(selected.q_nb, member.turn)
    near_tilt = tilt_between(selected.q_nb, other) < NEAR_TILT
    return near_tilt and abs(heading_between(selected.q_nb, other)) < NEAR_HEADING


def _member(selected: FilterState, state: FilterState, q_nb: Quat) -> Member:
    return Member(q_mul(q_conj(selected.q_nb), q_nb), state.tilt_sigma, state.heading_sigma)
