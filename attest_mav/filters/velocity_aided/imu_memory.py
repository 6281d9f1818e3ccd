"""The memory of dead reckoning between two samples, and the differences of the last three readings."""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import mat_vec, norm, q_to_matrix, scale, sub
from attest_mav.filters.velocity_aided.history import DeltaVelocityHistory, empty_history
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.reading import Reading
from attest_mav.filters.velocity_aided.white_noise import WhiteNoise, no_white_noise
from attest_mav.record import Record
from attest_mav.types import Vec3

MAX_STEP_RATIO: Final = 1.5
"""Two steps whose lengths differ by no more than this factor count as even."""


@mypyc_attr(acyclic=True, free_list_len=1)
class ImuMemory(Record):
    """The memory of dead reckoning between two samples."""

    def __init__(
        self,
        gyro: Vec3,
        accel: Vec3,
        gyro_change: Vec3,
        accel_change: Vec3,
        dt_s: float,
        specific_force: Vec3,
        gyro_aliasing: float,
        accel_aliasing: Vec3,
        gyro_white: WhiteNoise,
        accel_white: WhiteNoise,
        history: DeltaVelocityHistory,
    ) -> None:
        self.gyro: Final = gyro
        """The last gyro reading, rad/s."""
        self.accel: Final = accel
        """The last accelerometer reading, m/s^2."""
        self.gyro_change: Final = gyro_change
        """The last gyro reading minus the one before, rad/s."""
        self.accel_change: Final = accel_change
        """The last accelerometer reading minus the one before, m/s^2."""
        self.dt_s: Final = dt_s
        """Time between these two, s."""
        self.specific_force: Final = specific_force
        """The last specific force without bias, NED, m/s^2."""
        self.gyro_aliasing: Final = gyro_aliasing
        """Largest second difference of the gyro of late that its low-pass lets hide, rad/s, decaying."""
        self.accel_aliasing: Final = accel_aliasing
        """Largest second difference of the accelerometer of late in each axis of the body, m/s^2, decaying."""
        self.gyro_white: Final = gyro_white
        """White noise of the gyro, rad/s."""
        self.accel_white: Final = accel_white
        """White noise of the accelerometer, m/s^2."""
        self.history: Final = history
        """Recent gains of velocity."""

    @property
    def hidden_acceleration(self) -> float:
        """Size of the acceleration that the samples of late may not have shown, m/s^2."""
        return norm(self.accel_aliasing)

    @property
    def angular_acceleration(self) -> Vec3:
        """By the last two gyro readings, rad/s^2; zero before the second."""
        return scale(self.gyro_change, 1.0 / self.dt_s) if self.dt_s > 0.0 else (0.0, 0.0, 0.0)

    def with_attitude(self, nav: NavigationState) -> "ImuMemory":
        """The memory after a correction: the last specific force as the corrected state sees it."""
        return ImuMemory(
            self.gyro,
            self.accel,
            self.gyro_change,
            self.accel_change,
            self.dt_s,
            specific_force_ned(nav, self.accel),
            self.gyro_aliasing,
            self.accel_aliasing,
            self.gyro_white,
            self.accel_white,
            self.history,
        )


def initial_memory(nav: NavigationState, reading: Reading, t_ns: int) -> ImuMemory:
    """The memory at the first sample of a navigation."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    force = specific_force_ned(nav, reading.accel)
    quiet = no_white_noise()
    return ImuMemory(reading.gyro, reading.accel, zero, zero, 0.0, force, 0.0, zero, quiet, quiet, empty_history(t_ns))


def specific_force_ned(nav: NavigationState, accel: Vec3) -> Vec3:
    """C (f - a), NED, m/s^2."""
    return mat_vec(q_to_matrix(nav.q_nb), sub(accel, nav.accel_bias))


@mypyc_attr(acyclic=True, free_list_len=1)
class ThreePoint(Record):
    """Differences of the last three readings."""

    def __init__(
        self,
        gyro_change: Vec3,
        accel_change: Vec3,
        gyro_second_difference: Vec3,
        accel_second_difference: Vec3,
        trapezoid_excess: Vec3,
    ) -> None:
        self.gyro_change: Final = gyro_change
        """First difference of the gyro, rad/s."""
        self.accel_change: Final = accel_change
        """First difference of the accelerometer, m/s^2."""
        self.gyro_second_difference: Final = gyro_second_difference
        """Second difference of the gyro, rad/s."""
        self.accel_second_difference: Final = accel_second_difference
        """Second difference of the accelerometer, m/s^2."""
        self.trapezoid_excess: Final = trapezoid_excess
        """Mean rate by the trapezoid minus that by the three-point rule of Adams and Moulton, rad/s: the latter is
        (5 w2 + 8 w1 - w0) / 12, exact for a rate with a constant second derivative."""


def three_point_of(memory: ImuMemory, reading: Reading, dt_s: float) -> ThreePoint:
    """The differences at this reading. Uneven steps have no three-point rule."""
    gyro_change, accel_change = sub(reading.gyro, memory.gyro), sub(reading.accel, memory.accel)
    second_difference = sub(gyro_change, memory.gyro_change)
    even = MAX_STEP_RATIO * dt_s > memory.dt_s > dt_s / MAX_STEP_RATIO
    excess: Vec3 = scale(second_difference, 1.0 / 12.0) if even else (0.0, 0.0, 0.0)
    accel_second_difference = sub(accel_change, memory.accel_change)
    return ThreePoint(gyro_change, accel_change, second_difference, accel_second_difference, excess)
