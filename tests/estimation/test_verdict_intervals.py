"""Intervals of the verdict: begin, end, reason and the largest differences; and the states of lanes."""

from math import isnan, nan

from attest_mav.estimation.events import Agreement, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.lane_standings import LaneStandings
from attest_mav.estimation.verdict_intervals import VerdictIntervals

A, D, U = Agreement.AGREE, Agreement.DISAGREE, Agreement.UNDECIDED
SECOND = 1_000_000_000


def verdict(agreement, t_s, reason="", tilt=nan, heading=nan):
    return Verdict(agreement, reason, tilt, heading, "ATTITUDE", round(t_s * SECOND), round(t_s * SECOND))


def intervals_of(verdicts):
    """The intervals that ended, and the one that goes on."""
    intervals = VerdictIntervals()
    changes = [intervals.take(one) for one in verdicts]
    ended = [one.ended for one in changes if one is not None and one.ended is not None]
    return ended, intervals.open_interval(verdicts[-1].rx_ns)


def test_an_interval_has_its_ends_its_reason_and_the_largest_differences():
    (agreed, off), last = intervals_of(
        [
            verdict(A, 0.0, "agrees", 0.01, -0.02),
            verdict(A, 1.0, "agrees", 0.03, 0.01),
            verdict(D, 2.0, "tilt", 0.1),
            verdict(D, 3.0, "tilt", 0.3, -0.5),
            verdict(D, 4.0, "settling", 0.2, 0.4),
            verdict(A, 5.0, "agrees", 0.0, 0.0),
            verdict(A, 9.0, "agrees", 0.0, 0.0),
        ]
    )
    assert (agreed.agreement, agreed.duration_s, agreed.peak_tilt, agreed.peak_heading) == (A, 2.0, 0.03, -0.02)
    assert (off.begin_ns, off.end_ns) == (2 * SECOND, 5 * SECOND)
    assert (off.agreement, off.reason, off.peak_tilt, off.peak_heading) == (D, "tilt", 0.3, -0.5)
    assert (last.agreement, last.duration_s) == (A, 4.0)


def test_a_short_doubt_leaves_no_trace_in_an_agreement():
    ended, last = intervals_of(
        [verdict(A, 0.0, "agrees", 0.01), verdict(U, 1.0, "settling", 0.2), verdict(A, 2.0, "agrees", 0.02)]
    )
    assert ended == []
    assert (last.duration_s, last.peak_tilt, last.reason) == (2.0, 0.02, "agrees")


def test_a_doubt_that_lasts_begins_at_its_first_verdict():
    (agreed,), doubt = intervals_of([verdict(A, 0.0), *[verdict(U, t_s, "low-confidence") for t_s in range(1, 13)]])
    assert agreed.duration_s == 1.0
    assert (doubt.begin_ns, doubt.duration_s, doubt.reason) == (SECOND, 11.0, "low-confidence")


def test_a_doubt_after_which_nothing_comes_settles_by_itself():
    intervals = VerdictIntervals()
    intervals.take(verdict(A, 0.0))
    assert intervals.settle(20 * SECOND) is None
    intervals.take(verdict(U, 1.0, "no-reference"))
    assert intervals.settle(10 * SECOND) is None
    change = intervals.settle(11 * SECOND)
    assert change.ended.agreement == A
    assert change.verdict.reason == "no-reference"
    assert intervals.settle(30 * SECOND) is None


def test_nothing_compared_is_no_difference_of_zero():
    _, only = intervals_of([verdict(U, 0.0, "no-estimate")])
    assert isnan(only.peak_tilt)
    assert isnan(only.peak_heading)


def states(*kinds, text="gyro x off"):
    standings = LaneStandings()
    for kind in kinds:
        standings.take(LaneEvent("RAW_IMU", kind, 0, 0, text))
    return standings.states


K = LaneEventKind


def test_the_state_of_a_lane_follows_its_events():
    assert states() == ()
    assert states(K.ALIGNED) == ("RAW_IMU used",)
    assert states(K.ALIGNED, K.STOPPED) == ("RAW_IMU stopped",)
    assert states(K.ALIGNED, K.STOPPED, K.GAP) == ("RAW_IMU used",)
    assert states(K.RESTARTED, K.GAP) == ("RAW_IMU aligning",)


def test_a_lane_set_aside_stays_so_until_it_returns():
    aside = ("RAW_IMU set aside: gyro x off",)
    assert states(K.ALIGNED, K.FAULTY) == aside
    assert states(K.ALIGNED, K.FAULTY, K.GAP, K.RESTARTED, K.ALIGNED) == aside
    assert states(K.ALIGNED, K.FAULTY, K.RETURNED) == ("RAW_IMU used",)
    assert states(K.ALIGNED, K.FAULTY, K.REBOOTED) == ("RAW_IMU aligning",)
