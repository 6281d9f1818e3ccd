"""Gradient-descent filter for magnetic, angular-rate and gravity sensors (paper 1).

The gyro is integrated; each step also moves the quaternion at a fixed rate ``beta`` down the gradient of the misfit
between the gravity and field directions that the attitude predicts and those that were measured. Equation numbers
are the paper's; docs/filters.md says how its misprints are mended.

The filter takes the accelerometer for gravity. It is at home at rest and under brief disturbances; in a sustained
turn it leans with the vehicle.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Final, cast

from attest_mav.algebra import norm, q_exp, q_mul, q_norm, q_unit, rotate, scale, sub
from attest_mav.filters.base import MAX_CORRECTION_DT_S, Aids, AttitudeFilter, FilterState, Start
from attest_mav.types import G_MPS2, ImuSample, Quat, Vec3

MIN_GRADIENT: Final = 1e-9
"""Below this length the gradient has no direction: no correction is made."""

MAX_FIELD: Final = 1e9
"""A magnetometer reading of this length or more is not a field (NaN and infinity fail the same test)."""


@dataclass(frozen=True)
class FixedField:
    """A reference field of unit length in the vertical plane of its own north: (b_x, 0, b_z); b_z > 0 dips down."""

    b_x: float
    b_z: float


class GradientDescentState(FilterState):
    """State after a step, with its innovation.

    gravity_residual: predicted minus measured down direction, eq. (18). field_residual: predicted minus measured
    field direction, eq. (22). Both are differences of unit vectors in the body, zero where a sensor was not used.
    """

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        gravity_residual: Vec3,
        field_residual: Vec3,
    ) -> None:
        super().__init__(q_nb, gyro_bias, accel_used, mag_used)
        self.gravity_residual: Final = gravity_residual
        self.field_residual: Final = field_residual


@dataclass(frozen=True)
class GradientDescent(AttitudeFilter):
    """Parameters; the defaults are the simplified form (31).

    beta: speed of the correction as a quaternion rate, rad/s (an angle moves at 2 beta). Too small: gyro bias wins
    (2 beta must exceed it with margin). Too large: sensor noise and every acceleration come through.
    full_fusion: the complete form (26)-(30). It slows gyro and correction alike when the vehicle turns slowly; it is
    here to study the paper, not to fly. alpha: its step ratio, > 1; an infinite one gives (31).
    exponential: integrate the gyro exactly instead of by Euler's rule (9).
    field: the reference field; None takes it from the estimate, so that the field cannot tilt the attitude.
    min_accel_g, max_accel_g: the accelerometer is used while its length is within, in g. Without it the field is
    not used either: alone it would tilt the attitude.
    """

    beta: float = 0.033
    full_fusion: bool = False
    alpha: float = 100.0
    exponential: bool = True
    field: FixedField | None = None
    min_accel_g: float = 0.5
    max_accel_g: float = 1.5

    @property
    def name(self) -> str:
        """``gradient-descent``."""
        return "gradient-descent"

    def initial(self, start: Start) -> GradientDescentState:
        """Start from the alignment."""
        zero = (0.0, 0.0, 0.0)
        return GradientDescentState(start.q_nb, start.gyro_bias, False, False, zero, zero)

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, aids: Aids) -> GradientDescentState:
        """One step of (31), or of (26)-(30) with ``full_fusion``."""
        before = cast("GradientDescentState", state)
        q = before.q_nb
        gyro = sub(sample.gyro, before.gyro_bias)
        gradient: Quat = (0.0, 0.0, 0.0, 0.0)
        gravity_residual: Vec3 = (0.0, 0.0, 0.0)
        field_residual: Vec3 = (0.0, 0.0, 0.0)
        accel_norm = norm(sample.accel)
        accel_used = not sample.saturated and self.min_accel_g <= accel_norm / G_MPS2 <= self.max_accel_g
        mag = sample.mag
        mag_used = accel_used and mag is not None and 0.0 < norm(mag) < MAX_FIELD
        if accel_used:
            gravity_residual = gravity_misfit(q, scale(sample.accel, -1.0 / accel_norm))
            gradient = gravity_gradient(q, gravity_residual)
        if mag_used and mag is not None:
            direction = scale(mag, 1.0 / norm(mag))
            b_x, b_z = self._reference_field(q, direction)
            field_residual = field_misfit(q, direction, b_x, b_z)
            gradient = _sum(gradient, field_gradient(q, field_residual, b_x, b_z))
        share = self._fusion_share(gyro)
        descent = share * self.beta * min(dt_s, MAX_CORRECTION_DT_S)
        q = self._propagate(q, scale(gyro, share), dt_s, _scale(_direction(gradient), descent))
        return GradientDescentState(q, before.gyro_bias, accel_used, mag_used, gravity_residual, field_residual)

    def _reference_field(self, q: Quat, direction: Vec3) -> tuple[float, float]:
        """(b_x, b_z) of the reference field, eq. (20): fixed, or the measured one levelled by the estimate."""
        if self.field is not None:
            return (self.field.b_x, self.field.b_z)
        h = rotate(q, direction)
        return (sqrt(h[0] * h[0] + h[1] * h[1]), h[2])

    def _fusion_share(self, gyro: Vec3) -> float:
        """1 - gamma of (30), which scales gyro and correction alike once (28) and (29) are written out; 1 for (31)."""
        if not self.full_fusion:
            return 1.0
        step_rate = self.alpha * 0.5 * norm(gyro)
        return step_rate / (step_rate + self.beta) if step_rate + self.beta > 0.0 else 1.0

    def _propagate(self, q: Quat, gyro: Vec3, dt_s: float, correction: Quat) -> Quat:
        """Turn by the gyro over dt_s, take the correction off, normalise.

        The exact turn needs no sub-steps after a gap: with one rate it equals any number of them.
        """
        if self.exponential:
            turned = q_mul(q, q_exp(scale(gyro, 0.5 * dt_s)))
        else:
            turned = _sum(q, _scale(q_mul(q, (0.0, gyro[0], gyro[1], gyro[2])), 0.5 * dt_s))
        return q_unit(_sum(turned, _scale(correction, -1.0)))


def gravity_misfit(q: Quat, down: Vec3) -> Vec3:
    """f_g, eq. (18): predicted minus measured down direction (unit, body)."""
    q1, q2, q3, q4 = q
    return (
        2.0 * (q2 * q4 - q1 * q3) - down[0],
        2.0 * (q1 * q2 + q3 * q4) - down[1],
        2.0 * (0.5 - q2 * q2 - q3 * q3) - down[2],
    )


def gravity_gradient(q: Quat, f: Vec3) -> Quat:
    """J_g^T f_g, eqs. (13) and (19)."""
    q1, q2, q3, q4 = q
    return (
        -2.0 * q3 * f[0] + 2.0 * q2 * f[1],
        2.0 * q4 * f[0] + 2.0 * q1 * f[1] - 4.0 * q2 * f[2],
        -2.0 * q1 * f[0] + 2.0 * q4 * f[1] - 4.0 * q3 * f[2],
        2.0 * q2 * f[0] + 2.0 * q3 * f[1],
    )


def field_misfit(q: Quat, direction: Vec3, b_x: float, b_z: float) -> Vec3:
    """f_b, eq. (22): predicted minus measured field direction (unit, body)."""
    q1, q2, q3, q4 = q
    return (
        2.0 * b_x * (0.5 - q3 * q3 - q4 * q4) + 2.0 * b_z * (q2 * q4 - q1 * q3) - direction[0],
        2.0 * b_x * (q2 * q3 - q1 * q4) + 2.0 * b_z * (q1 * q2 + q3 * q4) - direction[1],
        2.0 * b_x * (q1 * q3 + q2 * q4) + 2.0 * b_z * (0.5 - q2 * q2 - q3 * q3) - direction[2],
    )


def field_gradient(q: Quat, f: Vec3, b_x: float, b_z: float) -> Quat:
    """J_b^T f_b, eqs. (13) and (23)."""
    q1, q2, q3, q4 = q
    x, z = 2.0 * b_x, 2.0 * b_z
    return (
        -z * q3 * f[0] + (z * q2 - x * q4) * f[1] + x * q3 * f[2],
        z * q4 * f[0] + (x * q3 + z * q1) * f[1] + (x * q4 - 2.0 * z * q2) * f[2],
        -(2.0 * x * q3 + z * q1) * f[0] + (x * q2 + z * q4) * f[1] + (x * q1 - 2.0 * z * q3) * f[2],
        (z * q2 - 2.0 * x * q4) * f[0] + (z * q3 - x * q1) * f[1] + x * q2 * f[2],
    )


def _direction(gradient: Quat) -> Quat:
    """The gradient at unit length, or zero where it has no direction."""
    length = q_norm(gradient)
    return _scale(gradient, 1.0 / length) if length >= MIN_GRADIENT else (0.0, 0.0, 0.0, 0.0)


def _sum(a: Quat, b: Quat) -> Quat:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3])


def _scale(a: Quat, k: float) -> Quat:
    return (k * a[0], k * a[1], k * a[2], k * a[3])
