"""State of the leveling filter, and the records of its step."""

from math import isnan, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterState
from attest_mav.filters.leveling.model import LevelState, tilt_variance
from attest_mav.filters.leveling.north import NorthVector
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.record import Record
from attest_mav.types import Quat, Vec3


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class VelocityModel(Record):
    """The model of the velocity that is in use."""

    def __init__(self, stationary: bool, moving: bool, velocity: Vec3) -> None:
        self.stationary: Final = stationary
        """The vehicle stands."""
        self.moving: Final = moving
        """A speed reading has started the velocity."""
        self.velocity: Final = velocity
        """Body, m/s, of a vehicle without a speed: zero, or the last one while there were readings."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class VelocityFusion(Record):
    """The velocity measurements of one step; NaN for an axis that was not used."""

    def __init__(self, aid: Aid, observation: Vec3, residual: Vec3, variance: Vec3) -> None:
        self.aid: Final = aid
        """The aid by the model in use."""
        self.observation: Final = observation
        """Body, m/s."""
        self.residual: Final = residual
        """Measured minus predicted, m/s."""
        self.variance: Final = variance
        """Of the residuals, (m/s)^2."""

    def innovation(self, t_ns: int) -> Innovation:
        """The record: the axes that were used."""
        axes = [axis for axis in range(3) if not isnan(self.residual[axis])]
        return Innovation(
            self.aid,
            Fusion.USED,
            t_ns,
            tuple([self.observation[axis] for axis in axes]),
            tuple([self.residual[axis] for axis in axes]),
            tuple([self.variance[axis] for axis in axes]),
        )


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class LengthFusion(Record):
    """The unit-length constraint of one step."""

    def __init__(self, residual: float, variance: float) -> None:
        self.residual: Final = residual
        """1 minus the squared length of the down vector."""
        self.variance: Final = variance
        """Of the residual."""

    def innovation(self, t_ns: int) -> Innovation:
        """The record."""
        return Innovation(Aid.UNIT_LENGTH, Fusion.USED, t_ns, (1.0,), (self.residual,), (self.variance,))


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class LevelingState(FilterState):
    """State after a step."""

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        level: LevelState,
        north: NorthVector,
        velocity_model: VelocityModel,
        since_update_s: float,
        t_ns: int,
        velocity_fusion: VelocityFusion | None,
        length_fusion: LengthFusion | None,
    ) -> None:
        super().__init__(q_nb, gyro_bias, accel_used, mag_used, sqrt(tilt_variance(level)), sqrt(north.variance))
        self.level: Final = level
        """Velocity, down vector and their covariance."""
        self.north: Final = north
        """The heading."""
        self.velocity_model: Final = velocity_model
        """The model of the velocity."""
        self.since_update_s: Final = since_update_s
        """Time since the last measurements that need no reading (kept velocity, unit length), s."""
        self.t_ns: Final = t_ns
        """Sensor clock, ns."""
        self.velocity_fusion: Final = velocity_fusion
        """This step's velocity measurements, None without any."""
        self.length_fusion: Final = length_fusion
        """This step's unit-length constraint, None while it is not due."""

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """The records of this step, made when they are asked for."""
        records: list[Innovation] = []
        if self.velocity_fusion is not None:
            records.append(self.velocity_fusion.innovation(self.t_ns))
        if self.length_fusion is not None:
            records.append(self.length_fusion.innovation(self.t_ns))
        heading = self.north.innovation(self.t_ns)
        if heading is not None:
            records.append(heading)
        return tuple(records)


def unchanged(before: LevelingState) -> LevelingState:
    """The state as it was, after a step without a usable gyro."""
    return LevelingState(
        before.q_nb,
        before.gyro_bias,
        False,
        False,
        before.level,
        before.north.turned(before.north.direction, before.north.variance),
        before.velocity_model,
        before.since_update_s,
        before.t_ns,
        None,
        None,
    )
