"""The misfits and gradients of the gradient-descent filter, and the step down them. Equation numbers are paper 1's."""

from typing import Final

from attest_mav.algebra import q_norm, q_unit
from attest_mav.types import Quat, Vec3

MIN_GRADIENT: Final = 1e-9
"""Below this length the gradient has no direction: no correction is made."""


def descended(q: Quat, gradient: Quat, distance: float) -> Quat:
    """q moved so far down the gradient, (12), and normalised; without a gradient there is no way to go."""
    slope = q_norm(gradient)
    k = distance / slope if slope >= MIN_GRADIENT else 0.0
    return q_unit((q[0] - k * gradient[0], q[1] - k * gradient[1], q[2] - k * gradient[2], q[3] - k * gradient[3]))


def gravity_gradient(q: Quat, f_g: Vec3) -> Quat:
    """J_g^T f_g, eqs. (13) and (19)."""
    q1, q2, q3, q4 = q
    u_x, u_y, u_z = 2.0 * f_g[0], 2.0 * f_g[1], 4.0 * f_g[2]
    return (
        q2 * u_y - q3 * u_x,
        q4 * u_x + q1 * u_y - q2 * u_z,
        q4 * u_y - q1 * u_x - q3 * u_z,
        q2 * u_x + q3 * u_y,
    )


def field_misfit(q: Quat, down: Vec3, direction: Vec3, b_x: float, b_z: float) -> Vec3:
    """f_b, eq. (22): predicted minus measured field direction (unit, body). ``down`` is that of q, in the body.

    The field is b_x times north plus b_z times down; north in body axes is the first row of C(q).
    """
    q1, q2, q3, q4 = q
    x = 2.0 * b_x
    return (
        x * (0.5 - q3 * q3 - q4 * q4) + b_z * down[0] - direction[0],
        x * (q2 * q3 - q1 * q4) + b_z * down[1] - direction[1],
        x * (q1 * q3 + q2 * q4) + b_z * down[2] - direction[2],
    )


def full_gradient(q: Quat, f_g: Vec3, f_b: Vec3, b_x: float, b_z: float) -> Quat:
    """J_g^T f_g + J_b^T f_b, eqs. (19), (23) and (25).

    As the field is b_x north + b_z down, J_b = b_x J_n + b_z J_g, and the sum is J_g^T (f_g + b_z f_b) + J_n^T b_x f_b.
    """
    q1, q2, q3, q4 = q
    u_x, u_y, u_z = 2.0 * (f_g[0] + b_z * f_b[0]), 2.0 * (f_g[1] + b_z * f_b[1]), 4.0 * (f_g[2] + b_z * f_b[2])
    v_x, v_y, v_z = 4.0 * b_x * f_b[0], 2.0 * b_x * f_b[1], 2.0 * b_x * f_b[2]
    return (
        q2 * u_y - q3 * u_x + q3 * v_z - q4 * v_y,
        q4 * u_x + q1 * u_y - q2 * u_z + q3 * v_y + q4 * v_z,
        q4 * u_y - q1 * u_x - q3 * u_z - q3 * v_x + q2 * v_y + q1 * v_z,
        q2 * u_x + q3 * u_y - q4 * v_x - q1 * v_y + q2 * v_z,
    )
