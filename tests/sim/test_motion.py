from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.sim.jets import Jet, sine
from attest_mav.sim.motion import body_rates, lifted_motion

STEP = 1e-4


def rotation(roll, pitch, yaw):
    """Body to NED, as the product of three elementary rotations."""
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


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
    assert body_rates(angles[0], angles[1], tuple(angle_rates)) == pytest.approx(measured, abs=1e-6)


def test_lifted_motion_puts_all_specific_force_on_the_up_axis():
    def path(t: float) -> tuple[Jet, Jet, Jet, Jet]:
        return (
            sine(t, 3.0, 0.9, 0.1),
            sine(t, 2.0, 1.2, 0.7),
            sine(t, 1.0, 0.7, 0.2),
            sine(t, pi, 0.3, 0.0),
        )

    for t in (0.0, 1.3, 5.1, 9.9):
        force = lifted_motion(*path(t)).specific_force()
        assert force[:2] == pytest.approx((0.0, 0.0), abs=1e-12)
        assert force[2] < -5.0
