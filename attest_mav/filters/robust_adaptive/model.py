"""Prediction and measurements of a Kalman filter whose state is the attitude quaternion (paper 2, reading B).

A sample has four measurements: the three components of the unit specific force in the body, and the heading.
"""

from math import atan2, isinf, isnan, nan, sqrt
from typing import Final

from attest_mav.algebra import add, down_in_body, norm, q_dot, q_mul, rotate, scale, wrap_pi
from attest_mav.matrices4 import Mat4, add4, add_diagonal4, correction4, quadratic4, rank_one4, scale4, transpose4
from attest_mav.plausible import MIN_HORIZONTAL_FIELD, is_field, is_heading
from attest_mav.types import Quat, Vec3

MIN_NOSE: Final = 1e-9
"""Square of the horizontal part of the nose below which Euler's heading has no derivative."""


def predicted_covariance(p: Mat4, turn: Quat, q: Quat, noise: float, q_step: float) -> Mat4:
    """Phi P Phi^T + Q, eq. (4), where Phi multiplies by the quaternion ``turn`` from the right.

    A row of P times Phi^T is that row, read as a quaternion, times ``turn``; P is symmetric, so doing this to the
    rows, transposing, and doing it again makes both products. Q = noise (I - q q^T) + q_step I: white noise of the
    gyro moves the quaternion across itself, never along.
    """
    p = transpose4((q_mul(p[0], turn), q_mul(p[1], turn), q_mul(p[2], turn), q_mul(p[3], turn)))
    p = (q_mul(p[0], turn), q_mul(p[1], turn), q_mul(p[2], turn), q_mul(p[3], turn))
    return add_diagonal4(rank_one4(p, scale4(q, -noise), q), noise + q_step)


def measurement_jacobian(q: Quat, vertical: bool) -> Mat4:
    """H, the derivatives of unit specific force and heading by the quaternion.

    ``vertical``: the heading measurement turns about the vertical only, so that a bad heading cannot tilt the attitude;
    otherwise it is the derivative of Euler's heading, zero where the nose points straight up or down.
    """
    w, x, y, z = q
    return (
        (2.0 * y, -2.0 * z, 2.0 * w, -2.0 * x),
        (-2.0 * x, -2.0 * w, -2.0 * z, -2.0 * y),
        (-2.0 * w, 2.0 * x, 2.0 * y, -2.0 * z),
        (-2.0 * z, -2.0 * y, 2.0 * x, 2.0 * w) if vertical else _euler_heading_jacobian(q),
    )


def _euler_heading_jacobian(q: Quat) -> Quat:
    """d psi / d q for psi = atan2(s, c)."""
    w, x, y, z = q
    s = 2.0 * (w * z + x * y)
    c = w * w + x * x - y * y - z * z
    length_sq = s * s + c * c
    if length_sq < MIN_NOSE:
        return (0.0, 0.0, 0.0, 0.0)
    s, c = 2.0 * s / length_sq, 2.0 * c / length_sq
    return (c * z - s * w, c * y - s * x, c * x + s * y, c * w + s * z)


def accel_innovation(q: Quat, accel: Vec3) -> Vec3:
    """Measured minus predicted unit specific force: f/|f| + down."""
    return add(scale(accel, 1.0 / norm(accel)), down_in_body(q))


def heading_innovation(q: Quat, mag: Vec3 | None, heading: float | None) -> float:
    """Measured minus predicted heading, rad; NaN where nothing shows one.

    A supplied ``heading`` (rad) goes before the magnetometer. The field is levelled by the estimate: what
    is left of it east of the estimate's north is the error, without a detour through Euler angles.
    """
    if heading is not None and is_heading(heading):
        w, x, y, z = q
        return wrap_pi(heading - atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z))
    if mag is None:
        return nan
    field = rotate(q, mag)
    length = norm(mag)
    horizontal_sq = field[0] * field[0] + field[1] * field[1]
    if is_field(mag) and sqrt(horizontal_sq) > MIN_HORIZONTAL_FIELD * length:
        return -atan2(field[1], field[0])
    return nan


def state_variances_of(p: Mat4, jacobian: Mat4) -> Quat:
    """Diagonal of H P H^T."""
    return (
        quadratic4(p, jacobian[0]),
        quadratic4(p, jacobian[1]),
        quadratic4(p, jacobian[2]),
        quadratic4(p, jacobian[3]),
    )


def attitude_variances(q: Quat, p: Mat4) -> tuple[float, float]:
    """Variances of tilt (summed over both axes) and heading, rad^2: of 2 vec(dq conj(q)), the error turn in NED."""
    w, x, y, z = q
    north = quadratic4(p, (-2.0 * x, 2.0 * w, -2.0 * z, 2.0 * y))
    east = quadratic4(p, (-2.0 * y, 2.0 * z, 2.0 * w, -2.0 * x))
    vertical = quadratic4(p, (-2.0 * z, -2.0 * y, 2.0 * x, 2.0 * w))
    return (north + east, vertical)


def fused(dq: Quat, p: Mat4, h: Quat, z: float, r: float) -> tuple[Quat, Mat4]:
    """Correction and covariance after one more measurement; z is its innovation before any correction."""
    if isinf(r):
        return (dq, p)
    gain, p = correction4(p, h, r)
    return (add4(dq, scale4(gain, z - q_dot(h, dq))), p)


def nominal_nis(z: float, variance: float, inflation: float) -> float:
    """Normalised innovation squared of a measurement that is not inflated, 0 for the others."""
    return z * z / variance if inflation == 1.0 else 0.0


def nominal(inflation: float) -> float:
    """1 for a measurement that is not inflated, else 0."""
    return 1.0 if inflation == 1.0 else 0.0


def present(z: float, value: float) -> float:
    """value where the measurement has a reading, else 0."""
    return 0.0 if isnan(z) else value
