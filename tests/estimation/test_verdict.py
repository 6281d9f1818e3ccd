"""The verdict on attitudes made for it, with sigmas, rates and offsets that are known."""

from math import degrees, nan, radians

import pytest

from attest_mav.algebra import q_exp, q_from_euler, q_mul
from attest_mav.estimate import Estimate
from attest_mav.estimation.attitude_check import AttitudeCheck
from attest_mav.estimation.difference import Member
from attest_mav.estimation.events import Agreement
from attest_mav.estimation.verdict import Judge, VerdictSettings
from attest_mav.samples import AttitudeSample
from attest_mav.types import AttitudeForm, AttitudeRole, North

LEVEL = (1.0, 0.0, 0.0, 0.0)
STILL = (0.0, 0.0, 0.0)
AGREE, DISAGREE, UNDECIDED = Agreement.AGREE, Agreement.DISAGREE, Agreement.UNDECIDED


def estimate(t_s, q_nb=LEVEL, rates=STILL, tilt_deg=0.5, heading_deg=0.5, dt_s=0.1, proven=True):
    t_ns = round(t_s * 1e9)
    sigmas = (radians(tilt_deg), radians(heading_deg))
    return Estimate("RAW_IMU", "any", t_ns, t_ns, q_nb, rates, North.TRUE, *sigmas, dt_s, sigma_is_proven=proven)


def attitude(t_s, q_nb, form=AttitudeForm.EULER, frame_known=True):
    t_ns = round(t_s * 1e9)
    who = (AttitudeRole.AUTOPILOT, form)
    return AttitudeSample("ATTITUDE", 1, 1, t_ns, t_ns, q_nb, STILL, *who, frame_known=frame_known)


def last_said(theirs, seconds=5.0, judge=None, start_s=0.0, members=(), **ours):
    """What is said in the end of an autopilot that reports that, 10 Hz."""
    judge = judge or Judge(VerdictSettings())
    said = []
    for k in range(round(seconds * 10)):
        t_s = start_s + 0.1 * k
        said += judge.take_estimate(estimate(t_s, **ours), members)
        said += judge.judge(attitude(t_s, theirs))
    return said[-1]


@pytest.mark.parametrize(
    ("roll_deg", "yaw_deg", "sigma_deg", "proven", "expected", "reason"),
    [
        (5.0, 0.0, 0.5, True, DISAGREE, "tilt"),
        (5.0, 0.0, 0.5, False, AGREE, "agrees"),
        (5.0, 0.0, nan, False, AGREE, "agrees"),
        (12.0, 0.0, 0.5, False, DISAGREE, "tilt"),
        (3.8, 0.0, 2.0, True, UNDECIDED, "low-confidence"),  # within two sigmas, but not near
        (2.0, 0.0, 2.5, True, UNDECIDED, "low-confidence"),  # near, but not sure enough to say so
        (0.0, 8.0, 0.5, True, DISAGREE, "heading"),  # twice the threshold of the tilt
        (0.0, 5.0, 0.5, True, AGREE, "agrees"),
        (0.0, 8.0, 0.5, False, AGREE, "agrees"),
        (0.0, 0.0, 6.0, True, UNDECIDED, "low-confidence"),
        (40.0, 0.0, 4.0, True, DISAGREE, "tilt"),  # unsure by degrees, but not by forty
    ],
)
def test_the_limits_go_by_what_our_own_attitude_can_do(roll_deg, yaw_deg, sigma_deg, proven, expected, reason):
    theirs, judge = q_from_euler(radians(roll_deg), 0.0, radians(yaw_deg)), Judge(VerdictSettings())
    last_said(LEVEL, judge=judge)  # without a compass a heading counts once both have agreed
    said = last_said(theirs, judge=judge, start_s=5.0, tilt_deg=sigma_deg, heading_deg=sigma_deg, proven=proven)
    assert (said.agreement, said.reason) == (expected, reason)


def test_without_a_compass_a_heading_that_never_agreed_is_not_held_against_the_autopilot():
    said = last_said(q_from_euler(0.0, 0.0, radians(40.0)), tilt_deg=0.5, heading_deg=0.5, proven=True)
    assert (said.agreement, said.reason) == (UNDECIDED, "doubted")


@pytest.mark.parametrize(("roll_deg", "expected"), [(5.0, UNDECIDED), (7.0, DISAGREE)])
def test_below_ten_hertz_a_tilt_must_exceed_three_sigmas(roll_deg, expected):
    """Errors from motion between the samples last longer there than a verdict takes."""
    theirs = q_from_euler(radians(roll_deg), 0.0, 0.0)
    assert last_said(theirs, tilt_deg=2.0).agreement is DISAGREE
    assert last_said(theirs, tilt_deg=2.0, dt_s=0.25).agreement is expected


def test_a_heading_within_our_own_twenty_degrees_is_no_agreement():
    """An autopilot whose heading is not aligned yet, beside a filter that does not know its own well."""
    said = last_said(q_from_euler(0.0, 0.0, radians(15.0)), heading_deg=6.7)
    assert (said.agreement, said.reason) == (UNDECIDED, "heading-uncertain")


def test_evidence_is_time_by_the_autopilots_stamps():
    judge, wrong = Judge(VerdictSettings()), q_from_euler(radians(6.0), 0.0, 0.0)
    last_said(LEVEL, judge=judge)
    assert last_said(wrong, 0.5, judge, 5.0).agreement == UNDECIDED
    assert last_said(wrong, 0.3, judge, 5.5).agreement == DISAGREE
    assert last_said(LEVEL, 0.2, judge, 5.8).agreement == DISAGREE
    assert last_said(LEVEL, 0.3, judge, 6.0).agreement == AGREE


def test_two_attitudes_of_one_stamp_that_contradict_each_other_are_counted():
    judge = Judge(VerdictSettings())
    last_said(LEVEL, judge=judge)
    judge.judge(attitude(4.9, q_from_euler(0.3, 0.0, 0.0)))
    assert judge.contradictions("ATTITUDE") == 1


@pytest.mark.parametrize(("turn_deg", "expected", "reason"), [(1.0, DISAGREE, "tilt"), (-6.0, UNDECIDED, "disputed")])
def test_only_what_contradicts_all_members_is_wrong(turn_deg, expected, reason):
    other = Member(q_exp((0.5 * radians(-turn_deg), 0.0, 0.0)), radians(0.5), radians(0.5))
    said = last_said(q_from_euler(radians(6.0), 0.0, 0.0), members=(other,))
    assert (said.agreement, said.reason) == (expected, reason)


@pytest.mark.parametrize("hz", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("ahead_s", [0.005, 0.13])
def test_slow_streams_are_compared_at_each_attitude(hz, ahead_s):
    """A vehicle that turns steadily; the autopilot's attitude is stamped before the sample of its burst."""
    judge, rate, said = Judge(VerdictSettings()), 0.3, []
    for k in range(60):
        t_s = k / hz
        q_nb = q_from_euler(0.0, 0.0, rate * t_s)
        earlier = q_from_euler(0.0, 0.0, rate * (t_s - ahead_s))
        said += judge.judge(attitude(t_s - ahead_s + 10.0, earlier))
        said += judge.take_estimate(estimate(t_s + 10.0, q_nb, (0.0, 0.0, rate), dt_s=1.0 / hz))
    assert len(said) >= 58
    assert {v.agreement for v in said[2:]} == {AGREE}
    assert max(degrees(abs(v.heading)) for v in said[2:]) < 0.01


def test_a_filter_without_sigma_is_blind_on_a_slow_stream():
    said = last_said(LEVEL, tilt_deg=nan, heading_deg=nan, dt_s=0.5, proven=False)
    assert (said.agreement, said.reason) == (UNDECIDED, "low-rate")


# --- an offset that is not known ---


def banked(k):
    return q_from_euler(radians(2.0) * (k % 7 - 3), radians(1.5) * (k % 5 - 2), 0.02 * k)


def reported(q_nb, trim, form):
    """What ArduPilot reports with this trim (roll, pitch, degrees): an Euler difference, or a body-side turn."""
    x, y = radians(trim[0]), radians(trim[1])
    if form == AttitudeForm.QUATERNION:
        return q_mul(q_nb, q_exp((-0.5 * x, -0.5 * y, 0.0)))
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    w, i, j, k = q_nb
    yaw, pitch, roll = Rotation.from_quat([i, j, k, w]).as_euler("ZYX")
    i, j, k, w = Rotation.from_euler("ZYX", [yaw, pitch - y, roll - x]).as_quat().tolist()
    return (w, i, j, k)


def fly(judge, trim, form, start_s, seconds, frame_known=False, **ours):
    said = []
    for k in range(round(start_s * 10), round((start_s + seconds) * 10)):
        said += judge.take_estimate(estimate(0.1 * k, banked(k), **ours))
        said += judge.judge(attitude(0.1 * k, reported(banked(k), trim, form), form, frame_known))
    return said


@pytest.mark.parametrize("form", list(AttitudeForm))
def test_a_steady_offset_is_named_and_not_accused(form):
    judge = Judge(VerdictSettings())
    said = fly(judge, (4.0, 2.0), form, 0.0, 20.0)
    assert DISAGREE not in {v.agreement for v in said}
    assert (said[-1].agreement, said[-1].reason) == (UNDECIDED, "offset")
    assert [degrees(a) for a in said[-1].offset] == pytest.approx([4.0, 2.0], abs=0.05)


@pytest.mark.parametrize("before", [(0.0, 0.0), (4.0, 2.0)])
def test_an_offset_that_arises_in_flight_is_a_disagreement(before):
    judge = Judge(VerdictSettings())
    fly(judge, before, AttitudeForm.EULER, 0.0, 20.0)
    said = fly(judge, (before[0] + 5.0, before[1]), AttitudeForm.EULER, 20.0, 5.0)
    assert (said[-1].agreement, said[-1].reason) == (DISAGREE, "tilt")


def test_an_offset_that_our_own_sigma_explains_is_none():
    """At first ours is wrong by two degrees, and says so; later both agree."""
    judge = Judge(VerdictSettings())
    fly(judge, (2.0, 0.0), AttitudeForm.EULER, 0.0, 10.0, tilt_deg=1.5)
    said = fly(judge, (0.0, 0.0), AttitudeForm.EULER, 10.0, 10.0, tilt_deg=1.5)
    assert (said[-1].agreement, said[-1].reason) == (AGREE, "agrees")


def test_a_known_trim_leaves_no_room_for_an_offset():
    judge = Judge(VerdictSettings())
    said = fly(judge, (4.0, 2.0), AttitudeForm.EULER, 0.0, 20.0, frame_known=True)
    assert said[-1].agreement == DISAGREE
    assert said[-1].offset is None


def test_an_offset_larger_than_a_trim_can_be_is_a_disagreement():
    judge = Judge(VerdictSettings())
    assert fly(judge, (20.0, 0.0), AttitudeForm.EULER, 0.0, 20.0)[-1].agreement == DISAGREE


def test_a_difference_that_no_trim_could_make_is_a_disagreement_at_once():
    said = fly(Judge(VerdictSettings()), (20.0, 0.0), AttitudeForm.EULER, 0.0, 2.0)
    assert said[-1].agreement == DISAGREE


def test_no_hold_time_means_at_once():
    judge = Judge(VerdictSettings(hold_s=0.0))
    last_said(LEVEL, judge=judge)
    assert last_said(q_from_euler(0.2, 0.0, 0.0), 0.1, judge, 5.0).agreement == DISAGREE


def test_attitudes_that_led_their_stream_accuse_nobody_once_it_has_stopped():
    """A second vehicle's frames come at once, with stamps of the next two seconds; then its true attitudes come."""
    check, wrong = AttitudeCheck(VerdictSettings()), q_from_euler(radians(30.0), 0.0, 0.0)
    for k in range(50):
        check.take_estimate(estimate(0.1 * k))
        check.take(attitude(0.1 * k, LEVEL))
    for k in range(20):
        check.take(attitude(5.0 + 0.1 * k, wrong))
    assert check.poll(8_000_000_000)[-1].reason == "no-reference"
    said = []
    for k in range(30):
        said += check.take_estimate(estimate(5.0 + 0.1 * k))
        said += check.take(attitude(5.0 + 0.1 * k, LEVEL)) if k >= 20 else []
    assert {one.agreement for one in said} == {AGREE}
