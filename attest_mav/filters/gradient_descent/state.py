"""State of the gradient-descent filter, and the records of its step."""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import norm, scale
from attest_mav.filters.base import FilterState
from attest_mav.filters.gradient_descent.options import OptionMemory
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.plausible import is_field
from attest_mav.samples import ImuSample
from attest_mav.types import Quat, Vec3


@mypyc_attr(acyclic=True, free_list_len=1)  # no cycles, and one spare kept: a new state replaces the last one
class GradientDescentState(FilterState):
    """State after a step."""

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        gravity_residual: Vec3,
        field_residual: Vec3,
        sample: ImuSample | None,
    ) -> None:
        super().__init__(q_nb, gyro_bias, accel_used, mag_used)
        self.gravity_residual: Final = gravity_residual
        """Predicted minus measured down direction, eq. (18), unit vectors in the body; zero without one."""
        self.field_residual: Final = field_residual
        """Predicted minus measured field direction, eq. (22), likewise."""
        self.sample: Final = sample
        """The sample as the step saw it, None before the first and where the gyro could not be used."""

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """Gravity and field of this step, made when they are asked for: the filter has no covariance."""
        sample = self.sample
        if sample is None:
            return ()
        gravity = self._gravity(sample)
        mag = sample.mag
        return (gravity,) if mag is None else (gravity, self._field(sample.t_ns, mag))

    def _gravity(self, sample: ImuSample) -> Innovation:
        """The accelerometer taken for gravity; one outside its limits in g is no reading of gravity."""
        if not self.accel_used:
            return Innovation(Aid.GRAVITY, Fusion.IMPLAUSIBLE, sample.t_ns)
        down = scale(sample.accel, -1.0 / norm(sample.accel))
        return Innovation(Aid.GRAVITY, Fusion.USED, sample.t_ns, down, scale(self.gravity_residual, -1.0))

    def _field(self, t_ns: int, mag: Vec3) -> Innovation:
        """The field's direction."""
        if not is_field(mag):
            return Innovation(Aid.MAGNETOMETER, Fusion.IMPLAUSIBLE, t_ns)
        direction = scale(mag, 1.0 / norm(mag))
        if not self.accel_used:
            return Innovation(Aid.MAGNETOMETER, Fusion.NOT_ALONE, t_ns, direction)
        return Innovation(Aid.MAGNETOMETER, Fusion.USED, t_ns, direction, scale(self.field_residual, -1.0))


@mypyc_attr(acyclic=True, free_list_len=1)
class OptionState(GradientDescentState):
    """State of a filter with an option."""

    def __init__(
        self,
        plain: GradientDescentState,
        q_nb: Quat,
        mag_used: bool,
        memory: OptionMemory,
        heading_error: float | None,
        field_rejected: bool,
    ) -> None:
        super().__init__(
            q_nb,
            memory.stationary.bias,
            plain.accel_used,
            mag_used,
            plain.gravity_residual,
            plain.field_residual,
            plain.sample,
        )
        self.plain: Final = plain
        """The paper's part of the step."""
        self.memory: Final = memory
        """Of the options."""
        self.heading_error: Final = heading_error
        """Heading minus that of the field, rad, where the heading has its own step; else None."""
        self.field_rejected: Final = field_rejected
        """Whether the monitor rejected the sample's field."""

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """As without options, with the heading's own step, and the field that the monitor rejected."""
        sample = self.sample
        if sample is None:
            return ()
        gravity = self._gravity(sample)
        if self.heading_error is not None:
            heading = Innovation(Aid.HEADING, Fusion.USED, sample.t_ns, (), (-self.heading_error,))
            return (gravity, heading)
        if self.field_rejected:
            return (gravity, Innovation(Aid.MAGNETOMETER, Fusion.OUTSIDE_GATE, sample.t_ns))
        mag = sample.mag
        return (gravity,) if mag is None else (gravity, self._field(sample.t_ns, mag))
