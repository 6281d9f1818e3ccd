from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.sim import motion
from attest_mav.sim.motion import Jet

STEP = 1e-4


def finite_difference(function, t):
    """Derivatives of each jet entry, by central differences of the entry before it."""
    before, after = function(t - STEP), function(t + STEP)
    return [(b - a) / (2.0 * STEP) for a, b in zip(before, after, strict=True)]


def rotation(roll, pitch, yaw):
    """Body to NED, as the product of three elementary rotations."""
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


JETS = {
    "sine": lambda t: motion.sine(t, 1.5, 2.0, 0.3),
    "smooth_step": lambda t: motion.smooth_step(t, 1.0, 3.0),
    "smooth_ramp": lambda t: motion.smooth_ramp(t, 1.0, 3.0),
    "times": lambda t: motion.times(motion.sine(t, 1.0, 1.1, 0.0), motion.smooth_step(t, 0.5, 2.0)),
    "plus": lambda t: motion.plus(motion.sine(t, 1.0, 1.1, 0.0), motion.smooth_ramp(t, 0.5, 2.0)),
    "scaled": lambda t: motion.scaled(motion.sine(t, 1.0, 1.1, 0.0), -2.5),
}


@pytest.mark.parametrize("name", JETS)
@given(t=st.floats(-1.0, 6.0))
@settings(derandomize=True, max_examples=60, deadline=None)
def test_each_entry_of_a_jet_is_the_derivative_of_the_one_before(name, t):
    jet = JETS[name]
    first, second, third, _ = finite_difference(jet, t)
    assert (first, second) == pytest.approx(jet(t)[1:3], abs=2e-6)
    # The fourth derivative jumps where a step begins: the difference across that place is half a jump off.
    assert third == pytest.approx(jet(t)[3], abs=2e-3)


@pytest.mark.parametrize(("t", "expected"), [(0.9, 0.0), (2.5, 0.5), (4.1, 1.0)])
def test_smooth_step_goes_from_zero_to_one(t, expected):
    assert motion.smooth_step(t, 1.0, 3.0)[0] == pytest.approx(expected)


def test_smooth_ramp_ends_with_slope_one_half_a_duration_late():
    assert motion.smooth_ramp(10.0, 1.0, 3.0) == pytest.approx((7.5, 1.0, 0.0, 0.0))


@given(
    angles=st.tuples(*[st.floats(-7.0, 7.0)] * 3),
    angle_rates=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_body_rates_are_those_of_the_rotation_matrix(angles, angle_rates):
    angles, angle_rates = np.array(angles), np.array(angle_rates)
    before = rotation(*(angles - STEP * angle_rates))
    after = rotation(*(angles + STEP * angle_rates))
    spin = rotation(*angles).T @ (after - before) / (2.0 * STEP)  # the skew matrix of the body rate
    measured = (spin[2, 1], spin[0, 2], spin[1, 0])
    assert motion.body_rates(angles[0], angles[1], tuple(angle_rates)) == pytest.approx(measured, abs=1e-6)


def test_lifted_motion_puts_all_specific_force_on_the_up_axis():
    def path(t: float) -> tuple[Jet, Jet, Jet, Jet]:
        return (
            motion.sine(t, 3.0, 0.9, 0.1),
            motion.sine(t, 2.0, 1.2, 0.7),
            motion.sine(t, 1.0, 0.7, 0.2),
            motion.sine(t, pi, 0.3, 0.0),
        )

    for t in (0.0, 1.3, 5.1, 9.9):
        force = motion.lifted_motion(*path(t)).specific_force()
        assert force[:2] == pytest.approx((0.0, 0.0), abs=1e-12)
        assert force[2] < -5.0
