"""Gradient-descent filter for magnetic, angular-rate and gravity sensors (paper 1).

The gyro is integrated; each step also moves the quaternion at a fixed rate ``beta`` down the gradient of the misfit
between the gravity and field directions that the attitude predicts and those that were measured. Equation numbers
are the paper's; docs/filters/gradient-descent.md corrects its misprints.

The filter takes the accelerometer for gravity. It is at home at rest and under brief disturbances; in a sustained
turn it leans with the vehicle. Four options, none of them the paper's, help it in a hand: see ``GradientDescent``.
"""

from dataclasses import dataclass
from math import isnan, sqrt
from typing import Final, cast

from mypy_extensions import mypyc_attr

from attest_mav.algebra import dot, down_in_body, norm, q_exp, q_mul, q_unit, scale, sub
from attest_mav.filters.base import MAX_CORRECTION_DT_S, AttitudeFilter, FilterInputs, FilterState, Start
from attest_mav.filters.gradient_descent.gradients import descended, field_misfit, full_gradient, gravity_gradient
from attest_mav.filters.gradient_descent.heading_step import heading_corrected, heading_error
from attest_mav.filters.gradient_descent.options import OptionMemory, advanced_memory, initial_memory, prepared_sample
from attest_mav.types import G_MPS2, ImuSample, Quat, Vec3

MAX_FIELD: Final = 1e9
"""A magnetometer reading of this length or more is not a field (NaN and infinity fail the same test)."""

MAX_RATE_SQ: Final = 1e4 * 1e4
"""A gyro reading of 10,000 rad/s or more is not a rate (NaN and infinity fail the same test)."""


@dataclass(frozen=True)
class FixedField:
    """A reference field of unit length in the vertical plane of its own north: (b_x, 0, b_z); b_z > 0 dips down."""

    b_x: float
    b_z: float


@mypyc_attr(acyclic=True, free_list_len=1)  # no cycles, and one spare kept: a new state replaces the last one
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


@mypyc_attr(acyclic=True, free_list_len=1)
class OptionState(GradientDescentState):
    """State of a filter with an option, with what each has learned. A heading with its own step has no residual."""

    def __init__(self, plain: GradientDescentState, q_nb: Quat, mag_used: bool, memory: OptionMemory) -> None:
        super().__init__(
            q_nb, memory.rest.bias, plain.accel_used, mag_used, plain.gravity_residual, plain.field_residual
        )
        self.memory: Final = memory


@dataclass(frozen=True)
class GradientDescent(AttitudeFilter):
    """Parameters; the defaults are the simplified form (31).

    beta: speed of the correction as a quaternion rate, rad/s (an angle moves at 2 beta). Too small: gyro bias wins
    (2 beta must exceed it with margin). Too large: sensor noise and every acceleration come through.
    full_fusion: the complete form (26)-(30). It slows gyro and correction alike when the vehicle turns slowly; it is
    here to study the paper, not to fly. alpha: its step ratio, > 1; an infinite one gives (31).
    exponential: turn exactly by the gyro, then compare with the readings. False is as printed: Euler's rule (9), and
    the attitude before the turn compared with the readings after it, which leads the truth by one interval's turn.
    field: the reference field; None takes it from the estimate, so that the field cannot tilt the attitude.
    min_accel_g, max_accel_g: the accelerometer is used while its length is between them, in g. Without it the field is
    not used either: alone it would tilt the attitude.

    The options, for hand-held motion, change the input of the step; docs/measurements.md has the effect of each:

    rest_bias: learn the gyro's bias at rest. accel_time_s: low-pass the accelerometer in almost inertial axes with this
    time constant, s; the limits in g are then those of the outcome; 0 is off. heading_rate: correct the heading by a
    step of its own, rad/s (an angle, which must exceed the gyro's bias), and leave the tilt to the accelerometer; 0 is
    off. field_gate: use the magnetometer only while its strength and dip are the usual ones.
    """

    beta: float = 0.033
    full_fusion: bool = False
    alpha: float = 100.0
    exponential: bool = True
    field: FixedField | None = None
    min_accel_g: float = 0.5
    max_accel_g: float = 1.5
    rest_bias: bool = False
    accel_time_s: float = 0.0
    heading_rate: float = 0.0
    field_gate: bool = False

    @property
    def name(self) -> str:
        """``gradient-descent``."""
        return "gradient-descent"

    def initial(self, start: Start) -> GradientDescentState:
        """Start from the alignment."""
        zero = (0.0, 0.0, 0.0)
        plain = GradientDescentState(start.q_nb, start.gyro_bias, False, False, zero, zero)
        if not (self.rest_bias or self.accel_time_s > 0.0 or self.heading_rate > 0.0 or self.field_gate):
            return plain
        return OptionState(plain, start.q_nb, False, initial_memory(start))

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
        if not dot(gyro, gyro) < MAX_RATE_SQ:
            return GradientDescentState(q, bias, False, False, none, none)
        share = self._fusion_share(gyro) if self.full_fusion else 1.0
        turned = self._turn(q, gyro, share * dt_s)
        accel_norm = norm(sample.accel)
        if sample.saturated or not self.min_accel_g * G_MPS2 < accel_norm < self.max_accel_g * G_MPS2:
            return GradientDescentState(q_unit(turned), bias, False, False, none, none)
        if self.exponential:
            q = turned
        down = down_in_body(q)
        f_g = sub(down, scale(sample.accel, -1.0 / accel_norm))  # (18)
        distance = share * self.beta * min(dt_s, MAX_CORRECTION_DT_S)
        mag = none if sample.mag is None else sample.mag
        mag_norm = norm(mag)
        if not 0.0 < mag_norm < MAX_FIELD:
            q = descended(turned, gravity_gradient(q, f_g), distance)
            return GradientDescentState(q, bias, True, False, f_g, none)
        direction = scale(mag, 1.0 / mag_norm)
        b_x, b_z = self._reference_field(down, direction)
        f_b = field_misfit(q, down, direction, b_x, b_z)
        q = descended(turned, full_gradient(q, f_g, f_b, b_x, b_z), distance)
        return GradientDescentState(q, bias, True, True, f_g, f_b)

    def _step_with_options(self, before: OptionState, dt_s: float, sample: ImuSample) -> OptionState:
        """The paper's step, given what the options make of the sample, and the heading's own behind it."""
        none: Vec3 = (0.0, 0.0, 0.0)
        if not dot(sample.gyro, sample.gyro) < MAX_RATE_SQ:
            unchanged = GradientDescentState(before.q_nb, none, False, False, none, none)
            return OptionState(unchanged, before.q_nb, False, before.memory)
        time_s, gate = self.accel_time_s, self.field_gate
        memory = advanced_memory(before.memory, before.q_nb, sample, dt_s, self.rest_bias, time_s, gate)
        prepared = prepared_sample(memory, sample, time_s, gate)
        without_bias = GradientDescentState(before.q_nb, none, False, False, none, none)
        mag = prepared.mag
        if self.heading_rate == 0.0 or mag is None:
            plain = self._plain_step(without_bias, dt_s, prepared)
            return OptionState(plain, plain.q_nb, plain.mag_used, memory)
        plain = self._plain_step(without_bias, dt_s, prepared.with_readings(prepared.gyro, prepared.accel, None))
        error = heading_error(plain.q_nb, mag)
        if isnan(error):
            return OptionState(plain, plain.q_nb, False, memory)
        q = heading_corrected(plain.q_nb, error, self.heading_rate, min(dt_s, MAX_CORRECTION_DT_S))
        return OptionState(plain, q, True, memory)

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
