"""What is bad by the autopilot's own words, and for how long that is told."""

from math import nan, radians

import pytest

from attest_mav.algebra import q_from_euler
from attest_mav.estimation.self_report import SelfReport
from attest_mav.samples import AttitudeSample
from attest_mav.types import NO_TIME, AttitudeForm, AttitudeRole
from attest_mav.vehicle_reports import EstimatorNews, EstimatorNewsSample, EstimatorStatusSample, SensorHealthSample

SECOND = 1_000_000_000


def status(rx_s=0.0, valid=True, glitch=False, accel=False, **ratios):
    return EstimatorStatusSample("EKF_STATUS_REPORT", 1, 1, round(rx_s * SECOND), valid, glitch, accel, **ratios)


def remarks(now_s, *samples):
    report = SelfReport()
    for sample in samples:
        report.take(sample)
    return report.remarks(round(now_s * SECOND))


def test_an_autopilot_in_good_order_gives_no_remark():
    assert remarks(0.0) == ()
    assert remarks(1.0, status(velocity=0.2, compass=0.79, limit=0.8)) == ()
    assert remarks(1.0, status(airspeed=nan)) == ()
    assert remarks(1.0, SensorHealthSample("SYS_STATUS", 1, 1, 0, ())) == ()


@pytest.mark.parametrize(
    ("sample", "text"),
    [
        (status(compass=1.2, limit=0.8), "reports bad compass variance 1.2"),
        (status(velocity=1.31, limit=1.0), "reports bad velocity variance 1.3"),
        (status(valid=False), "reports no valid attitude"),
        (status(glitch=True), "reports a GPS glitch"),
        (status(accel=True), "reports bad vertical accelerations"),
        (SensorHealthSample("SYS_STATUS", 1, 1, 0, ("gyro", "AHRS")), "reports unhealthy gyro, AHRS"),
    ],
)
def test_a_bad_report_is_told_while_it_is_fresh(sample, text):
    assert remarks(3.0, sample) == (text,)
    assert remarks(5.1, sample) == ()


def news(rx_s, text, kind=EstimatorNews.LANE_SWITCH):
    return EstimatorNewsSample("STATUSTEXT", 1, 1, round(rx_s * SECOND), kind, text)


def test_a_text_is_quoted_with_its_age():
    switch = news(10.0, "EKF3 lane switch 1")
    assert remarks(13.0, switch) == ('said "EKF3 lane switch 1" 3 s ago',)
    assert remarks(71.0, switch) == ()


def test_of_several_texts_on_one_matter_the_first_is_quoted():
    switch, changed = news(10.0, "EKF3 lane switch 1"), news(10.1, "EKF primary changed:1")
    assert remarks(11.0, switch, changed) == ('said "EKF3 lane switch 1" 1 s ago',)
    variance = news(10.5, "EKF variance", EstimatorNews.VARIANCE)
    assert remarks(11.5, switch, variance) == ('said "EKF variance" 1 s ago',)


def attitude(source, roll_deg, rx_s, rates=(0.0, 0.0, 0.0)):
    euler = (radians(roll_deg), 0.0, 0.0)
    is_own = source == "ATTITUDE"
    return AttitudeSample(
        source,
        1,
        1,
        round(rx_s * SECOND) if is_own else NO_TIME,
        round(rx_s * SECOND),
        q_from_euler(*euler),
        rates if is_own else None,
        AttitudeRole.AUTOPILOT if is_own else AttitudeRole.SECONDARY,
        AttitudeForm.EULER,
        euler,
    )


@pytest.mark.parametrize("source", ["AHRS2", "AHRS3"])
def test_attitudes_of_one_autopilot_that_differ_are_told(source):
    text = f"shows 12 deg of tilt between {source} and its own attitude"
    assert remarks(1.0, attitude("ATTITUDE", 0.0, 0.0), attitude(source, 12.0, 0.1)) == (text,)
    assert remarks(1.0, attitude("ATTITUDE", 0.0, 0.0), attitude(source, 8.0, 0.1)) == ()
    assert remarks(1.0, attitude("ATTITUDE", 0.0, 0.0), attitude(source, 12.0, 0.8)) == (), "too far apart in time"


def test_a_turn_between_two_attitudes_is_no_difference():
    turning = attitude("ATTITUDE", 0.0, 0.0, (radians(60.0), 0.0, 0.0))
    assert remarks(1.0, turning, attitude("AHRS2", 18.0, 0.3)) == ()
