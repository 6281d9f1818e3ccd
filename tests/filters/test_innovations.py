"""The records that the filters without a velocity leave in each step: used, and not used with the reason."""

from math import isnan, nan, radians

import pytest

from attest_mav.algebra import q_from_euler, rotate_back
from attest_mav.filters.base import BodyVelocity, FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.leveling.filter import Leveling
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
from attest_mav.innovation import Aid, Fusion
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
ZERO = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, -G_MPS2)
FIELD = (0.2, 0.0, 0.4)
TIME_NS = 5_000_000_000


def sample(accel=LEVEL, mag=FIELD, saturated=False):
    return ImuSample("RAW_IMU", 1, 1, TIME_NS, 0, ZERO, accel, mag, saturated)


def stepped(chosen, *samples, inputs=None):
    """The records of the last of these samples, by aid."""
    state = chosen.initial(Start(UPRIGHT, ZERO, North.MAGNETIC, LEVEL, FIELD))
    assert state.innovations == ()
    for one in samples:
        state = chosen.step(state, 0.02, one, inputs or FilterInputs())
    assert all(one.t_ns == TIME_NS for one in state.innovations)
    return {one.aid: one for one in state.innovations}


TILTED = rotate_back(q_from_euler(radians(3.0), 0.0, 0.0), LEVEL)


def test_gradient_descent_compares_directions():
    found = stepped(GradientDescent(), sample(accel=TILTED))
    assert found.keys() == {Aid.GRAVITY, Aid.MAGNETOMETER}
    gravity = found[Aid.GRAVITY]
    assert gravity.fusion == Fusion.USED
    assert gravity.observation == pytest.approx(tuple(-a / G_MPS2 for a in TILTED))
    assert gravity.residual == pytest.approx((0.0, -TILTED[1] / G_MPS2, 0.0), abs=0.002)
    assert isnan(gravity.nis)


def test_gradient_descent_says_why_not():
    short = stepped(GradientDescent(), sample(accel=(0.0, 0.0, -2.0)))
    assert [one.fusion for one in short.values()] == [Fusion.IMPLAUSIBLE, Fusion.NOT_ALONE]
    assert stepped(GradientDescent(), sample(mag=ZERO))[Aid.MAGNETOMETER].fusion == Fusion.IMPLAUSIBLE
    assert Aid.MAGNETOMETER not in stepped(GradientDescent(), sample(mag=None))
    gated = GradientDescent(field_gate=True)
    strong = [sample(mag=tuple(2.0 * m for m in FIELD))] * 20
    assert stepped(gated, *strong)[Aid.MAGNETOMETER].fusion == Fusion.OUTSIDE_GATE
    assert stepped(gated, sample())[Aid.MAGNETOMETER].fusion == Fusion.USED
    assert Aid.MAGNETOMETER not in stepped(gated, sample(mag=None))


def test_gradient_descent_with_a_step_of_the_headings_own():
    turned = rotate_back(q_from_euler(0.0, 0.0, 0.1), FIELD)
    heading = stepped(GradientDescent(heading_rate=0.01), sample(mag=turned))[Aid.HEADING]
    assert heading.residual == pytest.approx((0.1,), abs=1e-9)


def test_robust_adaptive_uses_inflates_and_rejects():
    chosen = RobustAdaptive()
    found = stepped(chosen, sample())
    assert {aid: one.fusion for aid, one in found.items()} == {Aid.GRAVITY: Fusion.USED, Aid.HEADING: Fusion.USED}
    assert found[Aid.GRAVITY].residual == pytest.approx(ZERO, abs=1e-9)
    # The start has a variance of 1e-4 a component, so 4e-4 rad^2 an axis beside the measurement's own.
    assert found[Aid.HEADING].variance[0] == pytest.approx(2.7e-3 + 4e-4, rel=0.1)
    for degrees_off, fusion in ((10.0, Fusion.INFLATED), (60.0, Fusion.OUTSIDE_GATE)):
        turned = rotate_back(q_from_euler(0.0, 0.0, radians(degrees_off)), FIELD)
        heading = stepped(chosen, sample(mag=turned))[Aid.HEADING]
        assert heading.fusion == fusion
        assert heading.residual == pytest.approx((radians(degrees_off),))
        assert heading.nis == pytest.approx(radians(degrees_off) ** 2 / heading.variance[0])
    fallen = rotate_back(q_from_euler(radians(70.0), 0.0, 0.0), LEVEL)
    assert stepped(chosen, sample(accel=fallen))[Aid.GRAVITY].fusion == Fusion.OUTSIDE_GATE


def test_robust_adaptive_says_what_is_implausible():
    found = stepped(RobustAdaptive(), sample(accel=(0.0, 0.0, -20.0), mag=(nan, 0.0, 0.0)))
    assert {one.fusion for one in found.values()} == {Fusion.IMPLAUSIBLE}
    assert Aid.HEADING not in stepped(RobustAdaptive(), sample(mag=None))
    supplied = stepped(RobustAdaptive(), sample(mag=None), inputs=FilterInputs(heading=0.05))
    assert supplied[Aid.HEADING].residual == pytest.approx((0.05,))


def test_leveling_names_the_model_of_the_velocity():
    moving = stepped(Leveling(), sample(), sample(), inputs=FilterInputs(BodyVelocity(12.0, side=0.5)))[Aid.SPEED]
    assert moving.observation == (12.0, 0.5, 0.0)
    assert moving.residual == pytest.approx(ZERO, abs=0.01)
    sideways = stepped(Leveling(), sample(), inputs=FilterInputs(BodyVelocity(12.0, lateral_known=False)))[Aid.SPEED]
    assert len(sideways.residual) == len(sideways.variance) == 1
    standing = stepped(Leveling(), sample(), inputs=FilterInputs(stationary=True))
    # One square metre a second squared at the start, and r_stationary.
    assert standing[Aid.ZERO_VELOCITY].variance == pytest.approx((1.0, 1.0, 1.0), rel=0.01)
    assert Aid.CONSTANT_VELOCITY in stepped(Leveling(), sample())
    assert Aid.SPEED not in stepped(Leveling(), sample(), inputs=FilterInputs(BodyVelocity(12.0, is_new=False)))


def test_leveling_has_records_of_heading_and_length():
    turned = rotate_back(q_from_euler(0.0, 0.0, 0.1), FIELD)
    found = stepped(Leveling(), sample(mag=turned))
    assert found[Aid.HEADING].residual == pytest.approx((0.1,))
    assert found[Aid.UNIT_LENGTH].observation == (1.0,)
    assert Aid.UNIT_LENGTH not in stepped(Leveling(), sample(), sample())
    assert stepped(Leveling(), sample(mag=ZERO))[Aid.HEADING].fusion == Fusion.IMPLAUSIBLE
    assert Aid.HEADING not in stepped(Leveling(), sample(mag=None))
    supplied = stepped(Leveling(), sample(mag=None), inputs=FilterInputs(heading=0.3))[Aid.HEADING]
    assert (supplied.fusion, supplied.residual) == (Fusion.USED, ())


@pytest.mark.parametrize("chosen", [GradientDescent(), RobustAdaptive(), Leveling()])
def test_a_step_without_a_gyro_has_no_records(chosen):
    broken = ImuSample("RAW_IMU", 1, 1, TIME_NS, 0, (nan, 0.0, 0.0), LEVEL, FIELD)
    assert stepped(chosen, sample(), broken) == {}
