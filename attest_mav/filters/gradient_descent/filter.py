"""Gradient-descent filter for magnetic, angular-rate and gravity sensors (paper 1).

The gyro is integrated; each step also moves the quaternion at a fixed rate ``beta`` down the gradient of the misfit
between the gravity and field directions that the attitude predicts and those that were measured. Equation numbers
are the paper's; docs/filters/gradient-descent.md corrects its misprints.

The filter takes the accelerometer for gravity. Its attitude is good at rest and under brief disturbances; in a
sustained turn its attitude leans with the vehicle. Four options, none of them the paper's, are for hand-held motion:
see ``GradientDescent``.
"""

from dataclasses import dataclass
from math import isnan, sqrt
from typing import cast

from attest_mav.algebra import dot, down_in_body, norm, q_exp, q_mul, q_unit, scale, sub
from attest_mav.errors import ArgumentError
from attest_mav.filters.base import MAX_CORRECTION_DT_S, AttitudeFilter, FilterInputs, FilterState, Start
from attest_mav.filters.gradient_descent.gradients import descended, field_misfit, full_gradient, gravity_gradient
from attest_mav.filters.gradient_descent.heading_step import heading_corrected, heading_error
from attest_mav.filters.gradient_descent.options import advanced_memory, initial_memory, prepared_sample
from attest_mav.filters.gradient_descent.state import GradientDescentState, OptionState
from attest_mav.filters.parameter_check import check_parameters
from attest_mav.plausible import is_field, is_rate
from attest_mav.record import Record
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, Quat, Vec3


@dataclass(frozen=True)
class FixedField(Record):
    """A reference field of unit length in the vertical plane of its own north."""

    b_x: float
    """Its horizontal part."""
    b_z: float
    """Its vertical part, positive where the field dips down."""


@dataclass(frozen=True)
class GradientDescent(AttitudeFilter):
    """Parameters; the defaults are the simplified form (31).

    The last four are options for hand-held motion, none of them the paper's; docs/measurements.md has the effect of
    each.
    """

    beta: float = 0.033
    """rad/s. Speed of the correction as a quaternion rate; an angle moves at 2 beta. Too small and the gyro's bias wins
    (2 beta must exceed it with margin); too large and sensor noise and every acceleration come through."""
    full_fusion: bool = False
    """Whether the complete form (26)-(30) runs. That form slows gyro and correction alike when the vehicle turns
    slowly; use it for study of the paper, not for flight."""
    alpha: float = 100.0
    """1. Step ratio of the complete form, above 1; an infinite one gives (31)."""
    exponential: bool = True
    """Whether the filter turns exactly by the gyro and then compares with the readings. False is as printed: Euler's
    rule (9), and the attitude before the turn compared with readings after it, one interval's turn late."""
    field: FixedField | None = None
    """Reference field; None takes it from the estimate, so that the field cannot tilt the attitude."""
    min_accel_g: float = 0.5
    """g. The accelerometer is used while its length is above. Without it the field is not used either: alone it would
    tilt the attitude."""
    max_accel_g: float = 1.5
    """g. The accelerometer is used while its length is below."""
    rest_bias: bool = False
    """Whether the gyro's bias is learned while the sensor is stationary."""
    accel_time_s: float = 0.0
    """s. Time constant of the accelerometer's low-pass in almost inertial axes; the limits in g are then those of its
    output. 0 is off."""
    heading_rate: float = 0.0
    """rad/s. Speed of a correction of the heading of its own, which must exceed the gyro's bias; the tilt is left to
    the accelerometer. 0 is off."""
    field_gate: bool = False
    """Whether the magnetometer is used only while its strength and inclination are the usual ones."""

    def __post_init__(self) -> None:
        """Refuse parameters that make no sense."""
        check_parameters(self, positive=("beta", "alpha"))
        if not self.min_accel_g < self.max_accel_g:
            raise ArgumentError(f"max_accel_g = {self.max_accel_g}; expected more than min_accel_g, {self.min_accel_g}")

    @property
    def name(self) -> str:
        """``gradient-descent``."""
        return "gradient-descent"

    def initial(self, start: Start) -> GradientDescentState:
        """Start from the alignment."""
        zero = (0.0, 0.0, 0.0)
        plain = GradientDescentState(start.q_nb, start.gyro_bias, False, False, zero, zero, None)
        if not (self.rest_bias or self.accel_time_s > 0.0 or self.heading_rate > 0.0 or self.field_gate):
            return plain
        return OptionState(plain, start.q_nb, False, initial_memory(start), None, False)

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> GradientDescentState:
        """One step of (31), or of (26)-(30) with ``full_fusion``. Without a usable gyro the attitude is held."""
        if isinstance(state, OptionState):
            return self._step_with_options(state, dt_s, sample)
        return self._plain_step(cast("GradientDescentState", state), dt_s, sample)

    def _plain_step(self, before: GradientDescentState, dt_s: float, sample: ImuSample) -> GradientDescentState:
        """The step of the paper."""
        q, bias = before.q_nb, before.gyro_bias
        none: Vec3 = (0.0, 0.0, 0.0)
        gyro = sub(sample.gyro, bias)
        if not is_rate(gyro):
            return GradientDescentState(q, bias, False, False, none, none, None)
        share = self._fusion_share(gyro) if self.full_fusion else 1.0
        turned = self._turn(q, gyro, share * dt_s)
        accel_norm = norm(sample.accel)
        if sample.saturated or not self.min_accel_g * G_MPS2 < accel_norm < self.max_accel_g * G_MPS2:
            return GradientDescentState(q_unit(turned), bias, False, False, none, none, sample)
        if self.exponential:
            q = turned
        down = down_in_body(q)
        f_g = sub(down, scale(sample.accel, -1.0 / accel_norm))  # (18)
        distance = share * self.beta * min(dt_s, MAX_CORRECTION_DT_S)
        mag = sample.field
        if not (sample.has_field and is_field(mag)):
            q = descended(turned, gravity_gradient(q, f_g), distance)
            return GradientDescentState(q, bias, True, False, f_g, none, sample)
        direction = scale(mag, 1.0 / norm(mag))
        b_x, b_z = self._reference_field(down, direction)
        f_b = field_misfit(q, down, direction, b_x, b_z)
        q = descended(turned, full_gradient(q, f_g, f_b, b_x, b_z), distance)
        return GradientDescentState(q, bias, True, True, f_g, f_b, sample)

    def _step_with_options(self, before: OptionState, dt_s: float, sample: ImuSample) -> OptionState:
        """The paper's step on the sample as the options prepare it, and the heading's own step behind it."""
        none: Vec3 = (0.0, 0.0, 0.0)
        without_bias = GradientDescentState(before.q_nb, none, False, False, none, none, None)
        if not is_rate(sample.gyro):
            return OptionState(without_bias, before.q_nb, False, before.memory, None, False)
        time_s, gate = self.accel_time_s, self.field_gate
        memory = advanced_memory(before.memory, before.q_nb, sample, dt_s, self.rest_bias, time_s, gate)
        prepared = prepared_sample(memory, sample, time_s, gate)
        mag = prepared.mag
        rejected = mag is None and sample.mag is not None
        if self.heading_rate == 0.0 or mag is None:
            plain = self._plain_step(without_bias, dt_s, prepared)
            return OptionState(plain, plain.q_nb, plain.mag_used, memory, None, rejected)
        plain = self._plain_step(without_bias, dt_s, prepared.with_readings(prepared.gyro, prepared.accel, None))
        error = heading_error(plain.q_nb, mag)
        if isnan(error):
            return OptionState(plain, plain.q_nb, False, memory, None, rejected)
        q = heading_corrected(plain.q_nb, error, self.heading_rate, min(dt_s, MAX_CORRECTION_DT_S))
        return OptionState(plain, q, True, memory, error, rejected)

    def _reference_field(self, down: Vec3, direction: Vec3) -> tuple[float, float]:
        """(b_x, b_z) of the reference field: fixed, or eq. (20), the measured field levelled by the estimate.

        Levelling a unit vector keeps its part along the estimated vertical; the rest is horizontal.
        """
        if self.field is not None:
            return (self.field.b_x, self.field.b_z)
        b_z = dot(down, direction)
        return (sqrt(max(0.0, 1.0 - b_z * b_z)), b_z)

    def _turn(self, q: Quat, gyro: Vec3, dt_s: float) -> Quat:
        """Turn by a constant rate, exactly or by Euler's rule (9).

        The exact turn needs no sub-steps after a gap: with one rate it equals any number of them.
        """
        half_angle = scale(gyro, 0.5 * dt_s)
        return q_mul(q, q_exp(half_angle) if self.exponential else (1.0, half_angle[0], half_angle[1], half_angle[2]))

    def _fusion_share(self, gyro: Vec3) -> float:
        """1 - gamma of (30). Once (28) and (29) are written out, (26) is (31) with both its terms times this."""
        step_rate = self.alpha * 0.5 * norm(gyro)
        return 1.0 - self.beta / (step_rate + self.beta) if step_rate + self.beta > 0.0 else 1.0
