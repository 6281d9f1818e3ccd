"""The errors of hand-made rotations, by the definition of the data set's authors."""

import numpy as np
import pytest

from attest_mav.evaluation.broad.metric import angles, errors
from attest_mav.evaluation.broad.trial import Trial

TILTED = np.array([0.5, 0.5, -0.5, 0.5])


def trial(opt, counted):
    none = np.zeros((len(opt), 3))
    return Trial("x", 50.0, none, none, none, np.array(opt), np.array(counted))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("axis", "expected"),
    [
        ((0.0, 0.0, 1.0), (10.0, 10.0, 0.0)),
        ((0.0, 0.0, -1.0), (10.0, 10.0, 0.0)),
        ((1.0, 0.0, 0.0), (10.0, 0.0, 10.0)),
        ((0.0, -1.0, 0.0), (10.0, 0.0, 10.0)),
        ((3.0, -4.0, 0.0), (10.0, 0.0, 10.0)),
    ],
)
def test_a_turn_of_the_world_about_one_axis(turn, multiply, axis, expected, sign):
    """Multiplied from the left, whatever the attitude and the sign of the quaternion."""
    estimate = sign * multiply(turn(axis, np.radians(10.0)), TILTED)
    assert np.degrees(angles(estimate[None], TILTED[None]))[0] == pytest.approx(expected, abs=1e-5)


def test_a_turn_about_the_sensors_own_axis_is_inclination_where_that_axis_lies_level(turn, multiply):
    """TILTED turns the sensor's z to the world's -x... any level axis: from the right it is no heading."""
    estimate = multiply(TILTED, turn((0.0, 0.0, 1.0), np.radians(10.0)))
    assert np.degrees(angles(estimate[None], TILTED[None]))[0] == pytest.approx((10.0, 0.0, 10.0), abs=1e-5)


def test_heading_and_inclination_together(turn, multiply):
    """20 deg about z after 10 deg about x: cos(total/2) = cos 10 cos 5."""
    error = multiply(turn((0.0, 0.0, 1.0), np.radians(20.0)), turn((1.0, 0.0, 0.0), np.radians(10.0)))
    total = 2.0 * np.degrees(np.arccos(np.cos(np.radians(10.0)) * np.cos(np.radians(5.0))))
    found = np.degrees(angles(multiply(error, TILTED)[None], TILTED[None]))[0]
    assert found == pytest.approx((total, 20.0, 10.0), abs=1e-5)


def test_half_a_turn_is_defined():
    up_to_half = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]])
    same = np.tile((1.0, 0.0, 0.0, 0.0), (2, 1))
    assert np.degrees(angles(up_to_half, same)) == pytest.approx(np.array([[180.0, 180.0, 0.0], [180.0, 0.0, 180.0]]))


def test_the_figures_are_root_mean_squares_over_what_counts(turn):
    """3 and 4 degrees of heading count, 90 do not; sqrt((9 + 16) / 2)."""
    estimate = np.array([turn((0.0, 0.0, 1.0), np.radians(angle)) for angle in (3.0, 90.0, -4.0, 90.0)])
    found = errors(trial([[1.0, 0.0, 0.0, 0.0]] * 4, [True, False, True, False]), estimate)
    assert found.total == pytest.approx(np.sqrt(12.5), abs=1e-5)
    assert found.heading == pytest.approx(np.sqrt(12.5), abs=1e-5)
    assert found.inclination == pytest.approx(0.0, abs=1e-5)
