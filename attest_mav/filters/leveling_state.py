"""State and innovation record of the leveling filter."""

from math import nan, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterState
from attest_mav.filters.level_model import Level, tilt_variance
from attest_mav.filters.north_vector import NorthVector
from attest_mav.types import Quat, Vec3


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class LevelingState(FilterState):
    """State after a step, with its innovation record.

    level: velocity, down vector and their covariance. north: the heading. stationary, moving: the measurement model
    in use; neither before the first speed. waited_s: since the last constraint rows. velocity_innovation: m/s, and
    length_innovation: what the rows of this step found; NaN for those not used.
    """

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        level: Level,
        north: NorthVector,
        stationary: bool,
        moving: bool,
        waited_s: float,
        velocity_innovation: Vec3,
        length_innovation: float,
    ) -> None:
        super().__init__(q_nb, gyro_bias, accel_used, mag_used, sqrt(tilt_variance(level)), sqrt(north.variance))
        self.level: Final = level
        self.north: Final = north
        self.stationary: Final = stationary
        self.moving: Final = moving
        self.waited_s: Final = waited_s
        self.velocity_innovation: Final = velocity_innovation
        self.length_innovation: Final = length_innovation


def held(before: LevelingState) -> LevelingState:
    """The state kept as it is."""
    return LevelingState(
        before.q_nb,
        before.gyro_bias,
        False,
        False,
        before.level,
        before.north,
        before.stationary,
        before.moving,
        before.waited_s,
        (nan, nan, nan),
        nan,
    )
