"""The thresholds of the verdict, on attitudes made for it: a tilt of five degrees for five seconds."""

from math import nan, radians

import pytest

from attest_mav.algebra import q_from_euler
from attest_mav.estimation.events import Agreement
from attest_mav.estimation.verdict import Judge, VerdictSettings
from attest_mav.types import AttitudeRole, AttitudeSample, Estimate, North

LEVEL = (1.0, 0.0, 0.0, 0.0)
STILL = (0.0, 0.0, 0.0)


def agreement(roll_deg, yaw_deg, sigma_deg, aided):
    """What is said in the end of an autopilot that is off by that roll and yaw."""
    judge = Judge(VerdictSettings())
    sigma = radians(sigma_deg)
    theirs = q_from_euler(radians(roll_deg), 0.0, radians(yaw_deg))
    said = Agreement.UNDECIDED
    for k in range(50):
        t_ns = k * 100_000_000
        judge.take_estimate(
            Estimate("RAW_IMU", "any", t_ns, t_ns, LEVEL, STILL, North.TRUE, sigma, sigma, 0.1, aided=aided)
        )
        said = judge.judge(
            AttitudeSample("ATTITUDE", 1, 1, t_ns, t_ns, theirs, STILL, AttitudeRole.AUTOPILOT)
        ).agreement
    return said


@pytest.mark.parametrize(
    ("roll_deg", "yaw_deg", "sigma_deg", "aided", "expected"),
    [
        (5.0, 0.0, 0.5, True, Agreement.DISAGREE),
        (5.0, 0.0, 0.5, False, Agreement.AGREE),
        (5.0, 0.0, nan, False, Agreement.AGREE),
        (12.0, 0.0, 0.5, False, Agreement.DISAGREE),
        (5.0, 0.0, 2.0, True, Agreement.AGREE),  # within three sigmas
        (0.0, 8.0, 0.5, True, Agreement.DISAGREE),  # twice the threshold of the tilt
        (0.0, 5.0, 0.5, True, Agreement.AGREE),
        (0.0, 8.0, 0.5, False, Agreement.AGREE),
        (0.0, 0.0, 6.0, True, Agreement.UNDECIDED),  # not sure enough to say anything
    ],
)
def test_a_velocity_makes_the_judge_stricter(roll_deg, yaw_deg, sigma_deg, aided, expected):
    assert agreement(roll_deg, yaw_deg, sigma_deg, aided) is expected
