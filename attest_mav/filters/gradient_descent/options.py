"""The options of the gradient-descent filter: their memory, and the sample that they hand to the filter's step.

The step itself stays the paper's: it gets the gyro without the bias learned at rest, the accelerometer low-passed in
almost inertial axes, and the magnetometer only while it shows the Earth's field.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import q_exp, q_mul, scale, sub
from attest_mav.filters.base import Start
from attest_mav.filters.field_monitor import VQF_LIMITS, FieldMonitor, monitored
from attest_mav.filters.gradient_descent.inertial_force import InertialForce, advanced, initial_force
from attest_mav.filters.gradient_descent.stationary_bias import StationaryBias, detect_bias, initial_bias
from attest_mav.plausible import is_force
from attest_mav.record import Record
from attest_mav.samples import ImuSample
from attest_mav.types import Quat


@mypyc_attr(acyclic=True)
class OptionMemory(Record):
    """The memory of each option; one that is off keeps that of the start."""

    def __init__(self, stationary: StationaryBias, inertial: InertialForce, field: FieldMonitor | None) -> None:
        self.stationary: Final = stationary
        """Gyro bias."""
        self.inertial: Final = inertial
        """Low-passed specific force."""
        self.field: Final = field
        """Field monitor, None before the first reading."""


def initial_memory(start: Start) -> OptionMemory:
    """The memory at the start."""
    field = monitored(None, start.q_nb, start.mag, 0.0, VQF_LIMITS)
    return OptionMemory(initial_bias(start.gyro_bias, start.accel), initial_force(start.q_nb, start.accel), field)


def advanced_memory(
    before: OptionMemory,
    q: Quat,
    sample: ImuSample,
    dt_s: float,
    rest_bias: bool,
    accel_time_s: float,
    field_gate: bool,
) -> OptionMemory:
    """The memory after one more sample, whose gyro is usable. q: the attitude ``dt_s`` earlier."""
    stationary, inertial, field = before.stationary, before.inertial, before.field
    if rest_bias:
        stationary = detect_bias(stationary, sample.gyro, sample.accel, dt_s)
    gyro = sub(sample.gyro, stationary.bias)
    if accel_time_s > 0.0:
        accel = sample.accel if has_usable_force(sample) else None
        inertial = advanced(inertial, gyro, accel, dt_s, accel_time_s)
    if field_gate:
        field = monitored(field, q_mul(q, q_exp(scale(gyro, 0.5 * dt_s))), sample.mag, dt_s, VQF_LIMITS)
    return OptionMemory(stationary, inertial, field)


def prepared_sample(memory: OptionMemory, sample: ImuSample, accel_time_s: float, field_gate: bool) -> ImuSample:
    """The sample as the step is to see it; an accelerometer that is not usable stays as it is."""
    field = memory.field
    accepted = not field_gate or (field is not None and field.is_earths_field)
    return sample.with_readings(
        sub(sample.gyro, memory.stationary.bias),
        memory.inertial.in_body if accel_time_s > 0.0 and has_usable_force(sample) else sample.accel,
        sample.mag if accepted else None,
    )


def has_usable_force(sample: ImuSample) -> bool:
    """True when the accelerometer's reading may enter a low-pass."""
    return not sample.saturated and is_force(sample.accel)
