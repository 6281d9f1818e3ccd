"""The parameters of each filter as they are configured: one record a filter, checked, with the filter's own defaults.

Where a parameter may be infinite, its range has no upper end. The meaning of each stands beside it in
configs/attest-mav.toml and, with its equation, in the filter's own docstring.
"""

from math import cos, radians, sin
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.gradient_descent.filter import FixedField, GradientDescent
from attest_mav.filters.leveling.filter import Leveling
from attest_mav.filters.own import Parameter, own_filter
from attest_mav.filters.registry import unknown_filter
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Share = Annotated[float, Meta(gt=0.0, le=1.0)]

# Taken from instances: a compiled class has no values of its own.
_GRADIENT_DESCENT = GradientDescent()
_ROBUST_ADAPTIVE = RobustAdaptive()
_LEVELING = Leveling()
_FLIGHT = FlightParameters()


class GradientDescentConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Parameters of ``GradientDescent``; ``reference_dip_deg`` stands for its fixed field."""

    beta: Annotated[float, Meta(gt=0.0, le=10.0)] = _GRADIENT_DESCENT.beta
    full_fusion: bool = _GRADIENT_DESCENT.full_fusion
    alpha: Annotated[float, Meta(gt=1.0)] = _GRADIENT_DESCENT.alpha
    exponential: bool = _GRADIENT_DESCENT.exponential
    reference_dip_deg: Literal["estimate"] | Annotated[float, Meta(ge=-90.0, le=90.0)] = "estimate"
    min_accel_g: Annotated[float, Meta(ge=0.0, le=1.0)] = _GRADIENT_DESCENT.min_accel_g
    max_accel_g: Annotated[float, Meta(ge=1.0, le=100.0)] = _GRADIENT_DESCENT.max_accel_g
    rest_bias: bool = _GRADIENT_DESCENT.rest_bias
    accel_time_s: Annotated[float, Meta(ge=0.0, le=60.0)] = _GRADIENT_DESCENT.accel_time_s
    heading_rate: Annotated[float, Meta(ge=0.0, le=10.0)] = _GRADIENT_DESCENT.heading_rate
    field_gate: bool = _GRADIENT_DESCENT.field_gate

    def build(self) -> AttitudeFilter:
        """The filter with these parameters."""
        parameters = msgspec.structs.asdict(self)
        dip = parameters.pop("reference_dip_deg")
        field = None if dip == "estimate" else FixedField(cos(radians(dip)), sin(radians(dip)))
        return GradientDescent(field=field, **parameters)


class RobustAdaptiveConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Parameters of ``RobustAdaptive``."""

    printed: bool = _ROBUST_ADAPTIVE.printed
    robust: bool = _ROBUST_ADAPTIVE.robust
    adaptive: bool = _ROBUST_ADAPTIVE.adaptive
    c: Positive = _ROBUST_ADAPTIVE.c
    c_reject: Positive = _ROBUST_ADAPTIVE.c_reject
    reacquire_s: Positive = _ROBUST_ADAPTIVE.reacquire_s
    average_s: Annotated[float, Meta(gt=0.0, le=3600.0)] = _ROBUST_ADAPTIVE.average_s
    max_disagreement: Positive = _ROBUST_ADAPTIVE.max_disagreement
    min_alpha: Share = _ROBUST_ADAPTIVE.min_alpha
    r_accel: Annotated[float, Meta(gt=0.0, le=1e3)] = _ROBUST_ADAPTIVE.r_accel
    r_heading: Annotated[float, Meta(gt=0.0, le=1e3)] = _ROBUST_ADAPTIVE.r_heading
    gyro_noise: Annotated[float, Meta(ge=0.0, le=1e3)] = _ROBUST_ADAPTIVE.gyro_noise
    q_step: Annotated[float, Meta(ge=0.0, le=1.0)] = _ROBUST_ADAPTIVE.q_step
    p0: Annotated[float, Meta(gt=0.0, le=1.0)] = _ROBUST_ADAPTIVE.p0
    max_accel_error_g: Annotated[float, Meta(gt=0.0, le=100.0)] = _ROBUST_ADAPTIVE.max_accel_error_g

    def build(self) -> AttitudeFilter:
        """The filter with these parameters."""
        return RobustAdaptive(**msgspec.structs.asdict(self))


class LevelingConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Parameters of ``Leveling``."""

    q_velocity: Annotated[float, Meta(ge=0.0, le=1e6)] = _LEVELING.q_velocity
    q_down: Annotated[float, Meta(ge=0.0, le=1e3)] = _LEVELING.q_down
    r_speed: Annotated[float, Meta(gt=0.0, le=1e6)] = _LEVELING.r_speed
    r_stationary: Annotated[float, Meta(gt=0.0, le=1e6)] = _LEVELING.r_stationary
    r_unaided: Positive = _LEVELING.r_unaided
    r_sideslip: Positive = _LEVELING.r_sideslip
    r_length_start: Annotated[float, Meta(gt=0.0, le=1e6)] = _LEVELING.r_length_start
    r_length: Annotated[float, Meta(gt=0.0, le=1e6)] = _LEVELING.r_length
    spacing_s: Annotated[float, Meta(ge=0.0, le=60.0)] = _LEVELING.spacing_s
    p0_velocity: Annotated[float, Meta(gt=0.0, le=1e6)] = _LEVELING.p0_velocity
    p0_down: Annotated[float, Meta(gt=0.0, le=1e3)] = _LEVELING.p0_down
    p0_down_moving: Annotated[float, Meta(gt=0.0, le=1e3)] = _LEVELING.p0_down_moving
    heading_time_s: Annotated[float, Meta(gt=0.0, le=3600.0)] = _LEVELING.heading_time_s
    heading_noise: Annotated[float, Meta(ge=0.0, le=1e3)] = _LEVELING.heading_noise
    r_heading: Annotated[float, Meta(gt=0.0, le=1e3)] = _LEVELING.r_heading
    gravity: Annotated[float, Meta(ge=9.7, le=9.9)] = _LEVELING.gravity

    def build(self) -> AttitudeFilter:
        """The filter with these parameters."""
        return Leveling(**msgspec.structs.asdict(self))


class VelocityAidedConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Parameters of ``VelocityAided`` that depend on the vehicle; all others are fixed (``FlightParameters``).

    ``auto``: the autopilot's own setting, and the filter's default until that is known. A number always holds.
    """

    low_pass_hz: Literal["auto"] | Annotated[float, Meta(ge=0.0, le=1000.0)] = "auto"  # noqa: S105  # no password
    fix_delay_s: Literal["auto"] | Annotated[float, Meta(ge=0.0, le=1.0)] = "auto"
    mag_delay_s: Annotated[float, Meta(ge=0.0, le=1.0)] = _FLIGHT.mag_delay_s
    accel_bias_sigma: Annotated[float, Meta(ge=0.0, le=1.0)] = _FLIGHT.accel_bias_sigma

    def build(self) -> AttitudeFilter:
        """The filter with these parameters."""
        low_pass, fix_delay = self.low_pass_hz, self.fix_delay_s
        parameters = FlightParameters(
            low_pass_hz=_FLIGHT.low_pass_hz if isinstance(low_pass, str) else low_pass,
            low_pass_delay_sigma=_FLIGHT.low_pass_delay_sigma if isinstance(low_pass, str) else 0.0,
            fix_delay_s=_FLIGHT.fix_delay_s if isinstance(fix_delay, str) else fix_delay,
            mag_delay_s=self.mag_delay_s,
            accel_bias_sigma=self.accel_bias_sigma,
        )
        return VelocityAided(parameters, isinstance(low_pass, str), isinstance(fix_delay, str))


class OwnFilterConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A filter of one's own: the class MODULE:CLASS, and the parameters that it is made with."""

    filter_class: str = msgspec.field(name="class", default="")
    parameters: dict[str, Parameter] = {}

    def build(self) -> AttitudeFilter:
        """The filter with these parameters."""
        return own_filter(self.filter_class, self.parameters)


_AnyConfig = GradientDescentConfig | RobustAdaptiveConfig | LevelingConfig | VelocityAidedConfig


class FilterConfig(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The filter that is published, and the parameters of each: one table a filter, named like it.

    auto is velocity-aided, which falls back to airspeed, gravity or zero motion when no velocity is available.
    """

    name: Literal["auto", "gradient-descent", "robust-adaptive", "leveling", "velocity-aided", "own"] = "auto"
    gradient_descent: GradientDescentConfig = msgspec.field(
        name="gradient-descent", default_factory=GradientDescentConfig
    )
    robust_adaptive: RobustAdaptiveConfig = msgspec.field(name="robust-adaptive", default_factory=RobustAdaptiveConfig)
    leveling: LevelingConfig = msgspec.field(default_factory=LevelingConfig)
    velocity_aided: VelocityAidedConfig = msgspec.field(name="velocity-aided", default_factory=VelocityAidedConfig)

    own: OwnFilterConfig = msgspec.field(default_factory=OwnFilterConfig)

    @property
    def chosen(self) -> str:
        """The name of the filter that runs."""
        return "velocity-aided" if self.name == "auto" else self.name

    def build(self) -> AttitudeFilter:
        """The chosen filter."""
        return self.named(self.chosen)

    def named(self, name: str) -> AttitudeFilter:
        """The filter of that name, or of the class MODULE:CLASS, with its parameters.

        UsageError lists the names if there is none.
        """
        if ":" in name:
            return own_filter(name, self.own.parameters if name == self.own.filter_class else {})
        return self.own.build() if name == "own" else self._config(name).build()

    def parameters(self, name: str) -> dict[str, Any]:
        """The parameters of a filter of the package, as a configuration has them; UsageError lists the names."""
        return msgspec.structs.asdict(self._config(name))

    def _config(self, name: str) -> _AnyConfig:
        configs: dict[str, _AnyConfig] = {
            "gradient-descent": self.gradient_descent,
            "robust-adaptive": self.robust_adaptive,
            "leveling": self.leveling,
            "velocity-aided": self.velocity_aided,
        }
        if name not in configs:
            raise unknown_filter(name)
        return configs[name]
