"""What the options of the gradient-descent filter learn, and what they make of a sample before the filter's step.

The step itself stays the paper's: it gets the gyro without the bias learned at rest, the accelerometer low-passed in
almost inertial axes, and the magnetometer only while it shows the Earth's field.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import dot, q_exp, q_mul, scale, sub
from attest_mav.filters.base import Start
from attest_mav.filters.gradient_descent.field_gate import FieldMonitor, initial_monitor, monitored
from attest_mav.filters.gradient_descent.inertial_force import InertialForce, advanced, initial_force
from attest_mav.filters.gradient_descent.rest_bias import StationaryBias, detect_bias, initial_bias
from attest_mav.types import ImuSample, Quat

MAX_FORCE_SQ: Final = 1e3 * 1e3
"""A specific force of 1000 m/s^2 or more is not one, and must not enter a low-pass (NaN and infinity neither)."""


@mypyc_attr(acyclic=True)
class OptionMemory:
    """What each option knows; one that is off knows what it knew at the start."""

    def __init__(self, rest: StationaryBias, inertial: InertialForce, gate: FieldMonitor) -> None:
        self.rest: Final = rest
        self.inertial: Final = inertial
        self.gate: Final = gate


def initial_memory(start: Start) -> OptionMemory:
    """At the start."""
    gate = monitored(initial_monitor(), start.q_nb, start.mag, 0.0)
    return OptionMemory(initial_bias(start.gyro_bias, start.accel), initial_force(start.q_nb, start.accel), gate)


def advanced_memory(
    before: OptionMemory,
    q: Quat,
    sample: ImuSample,
    dt_s: float,
    rest_bias: bool,
    accel_time_s: float,
    field_gate: bool,
) -> OptionMemory:
    """After one more sample, whose gyro is usable. q: the attitude ``dt_s`` earlier."""
    rest, inertial, gate = before.rest, before.inertial, before.gate
    if rest_bias:
        rest = detect_bias(rest, sample.gyro, sample.accel, dt_s)
    gyro = sub(sample.gyro, rest.bias)
    if accel_time_s > 0.0:
        accel = sample.accel if has_usable_force(sample) else None
        inertial = advanced(inertial, gyro, accel, dt_s, accel_time_s)
    if field_gate:
        gate = monitored(gate, q_mul(q, q_exp(scale(gyro, 0.5 * dt_s))), sample.mag, dt_s)
    return OptionMemory(rest, inertial, gate)


def prepared_sample(memory: OptionMemory, sample: ImuSample, accel_time_s: float, field_gate: bool) -> ImuSample:
    """The sample as the step is to see it; an accelerometer that is not usable stays what it is."""
    return sample.with_readings(
        sub(sample.gyro, memory.rest.bias),
        memory.inertial.in_body if accel_time_s > 0.0 and has_usable_force(sample) else sample.accel,
        sample.mag if not field_gate or memory.gate.is_earths_field else None,
    )


def has_usable_force(sample: ImuSample) -> bool:
    """Whether the accelerometer's reading is a specific force."""
    return not sample.saturated and dot(sample.accel, sample.accel) < MAX_FORCE_SQ
