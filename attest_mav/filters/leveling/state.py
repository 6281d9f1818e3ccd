"""State and innovation record of the leveling filter."""

from math import nan, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterState
from attest_mav.filters.leveling.model import LevelState, tilt_variance
from attest_mav.filters.leveling.north import NorthVector
from attest_mav.types import Quat, Vec3


@mypyc_attr(acyclic=True)  # as FilterState
class VelocityModel:
    """What is taken for granted of the velocity.

    stationary: the vehicle stands. moving: a speed reading has started the velocity. velocity: in the body, m/s, what
    a vehicle without a speed is taken to keep: zero, or the last one while there were readings.
    """

    def __init__(self, stationary: bool, moving: bool, velocity: Vec3) -> None:
        self.stationary: Final = stationary
        self.moving: Final = moving
        self.velocity: Final = velocity


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class LevelingState(FilterState):
    """State after a step, with its innovation record.

    level: velocity, down vector and their covariance. north: the heading. motion: the model of the velocity.
    waited_s: since the last rows without a reading. velocity_innovation: m/s, and length_innovation: what the rows of
    this step found; NaN for those not used.
    """

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
        velocity_innovation: Vec3,
        length_innovation: float,
    ) -> None:
        super().__init__(q_nb, gyro_bias, accel_used, mag_used, sqrt(tilt_variance(level)), sqrt(north.variance))
        self.level: Final = level
        self.north: Final = north
        self.velocity_model: Final = velocity_model
        self.since_update_s: Final = since_update_s
        self.velocity_innovation: Final = velocity_innovation
        self.length_innovation: Final = length_innovation


def unchanged(before: LevelingState) -> LevelingState:
    """The state kept as it is."""
    return LevelingState(
        before.q_nb,
        before.gyro_bias,
        False,
        False,
        before.level,
        before.north,
        before.velocity_model,
        before.since_update_s,
        (nan, nan, nan),
        nan,
    )
