"""Zero motion: how a vehicle is known to stand, and the zero-rate and zero-velocity updates that follow.

At rest the gyro shows its bias and the velocity is zero. An int16 gyro that reads zero hides up to a unit of bias, in
the same way for minutes on end, so rest never makes the bias better known than ``rest_floor``. (Zero updates: Groves,
Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 15.3.)
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, scale, square, sub, unit_axis
from attest_mav.filters.stationary import MAX_GYRO_BIAS, StillnessLimits, is_near
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, fuse
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import Reading
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.record import Record
from attest_mav.types import Vec3

MEAN_S: Final = 0.3
"""Time constant of the running means of gyro and accelerometer, s."""
LIMITS: Final = StillnessLimits(rate=0.02, accel=0.3)
"""At rest the readings stay this close to their means."""
STILL_S: Final = 1.5
"""Quiet and without a speed for this long, the vehicle is stationary, s."""
SETTLED_S: Final = 60.0
"""Quiet for this long, nothing new is seen of the sensors, s: repeated identical readings carry no new information
about their errors, and every update considers them."""
MAX_SPEED: Final = 0.3
"""m/s: a faster vehicle does not rest, however quiet: a plane in smooth cruise is as quiet as a desk."""
READS_ZERO: Final = 1e-4
"""rad/s: a mean below this comes from a gyro that reads zero."""
SPACING_S: Final = 0.1
"""Time between two updates, s."""
VELOCITY_SIGMA: Final = 0.05
"""m/s: of the zero velocity."""


@mypyc_attr(acyclic=True, free_list_len=1)
class Stationary(Record):
    """The state of the stationary detector, and of the zero updates."""

    def __init__(
        self,
        mean_gyro: Vec3,
        mean_accel: Vec3,
        quiet_s: float,
        still_s: float,
        since_update_s: float,
        innovations: tuple[Innovation, ...],
    ) -> None:
        self.mean_gyro: Final = mean_gyro
        """Running mean of the gyro, rad/s."""
        self.mean_accel: Final = mean_accel
        """Running mean of the accelerometer, m/s^2."""
        self.quiet_s: Final = quiet_s
        """Time for which the sensors have been quiet, s."""
        self.still_s: Final = still_s
        """The same, of the time without a speed."""
        self.since_update_s: Final = since_update_s
        """Time since the last update, s."""
        self.innovations: Final = innovations
        """Of this step's updates."""

    @property
    def is_stationary(self) -> bool:
        """True while the vehicle stands still."""
        return self.still_s >= STILL_S

    @property
    def is_settled(self) -> bool:
        """True when nothing has changed for so long that updates consider the sensor errors only."""
        return self.quiet_s >= SETTLED_S


def initial_stationary(reading: Reading) -> Stationary:
    """The detector at its first reading."""
    return Stationary(reading.gyro, reading.accel, 0.0, 0.0, 0.0, ())


def detect(before: Stationary, reading: Reading, speed: float, dt_s: float) -> Stationary:
    """The detector after a sample. ``speed``: that the vehicle is known or feared to have, m/s."""
    share = min(1.0, dt_s / MEAN_S)
    gyro = add(before.mean_gyro, scale(sub(reading.gyro, before.mean_gyro), share))
    accel = add(before.mean_accel, scale(sub(reading.accel, before.mean_accel), share))
    quiet = (
        is_near(reading.gyro, reading.accel, gyro, accel, LIMITS)
        and norm(gyro) < MAX_GYRO_BIAS
        and not reading.saturated
    )
    return Stationary(
        gyro,
        accel,
        before.quiet_s + dt_s if quiet else 0.0,
        before.still_s + dt_s if quiet and speed < MAX_SPEED else 0.0,
        before.since_update_s + dt_s,
        (),
    )


def fuse_zero_motion(
    nav: NavigationState,
    stationary: Stationary,
    has_velocity: bool,
    estimates_sensors: bool,
    t_ns: int,
    parameters: FlightParameters,
) -> tuple[NavigationState, Stationary]:
    """State and detector after the zero updates that are due.

    While velocity fixes arrive (has_velocity), the zero-velocity and zero-rate updates are not applied: a hovering
    copter looks as quiet as one on the ground, and turns slowly while its own filter's heading creeps. Only the bias
    that a gyro reading zero may hide is kept in mind.
    """
    if not stationary.is_stationary or stationary.since_update_s < SPACING_S:
        return nav, stationary
    floor = square(parameters.rest_floor)
    if norm(stationary.mean_gyro) < READS_ZERO or not has_velocity:
        nav = nav.with_gyro_bias_floor(floor)
    if has_velocity:
        innovations: tuple[Innovation, ...] = (
            Innovation(Aid.ZERO_RATE, Fusion.REDUNDANT, t_ns),
            Innovation(Aid.ZERO_VELOCITY, Fusion.REDUNDANT, t_ns),
        )
    else:
        nav, rate = _zero_rate_update(nav, stationary, floor, estimates_sensors, t_ns)
        nav, velocity = _zero_velocity_update(nav, estimates_sensors, t_ns)
        innovations = (rate, velocity)
    return nav, Stationary(
        stationary.mean_gyro, stationary.mean_accel, stationary.quiet_s, stationary.still_s, 0.0, innovations
    )


def _zero_rate_update(
    nav: NavigationState, stationary: Stationary, floor: float, estimates_sensors: bool, t_ns: int
) -> tuple[NavigationState, Innovation]:
    """The mean gyro is its bias, where that is not known to ``floor`` (a variance) already."""
    # One measurement of a mean over ``MEAN_S``.
    variance = floor * MEAN_S / stationary.since_update_s
    residuals: list[float] = []
    variances: list[float] = []
    fusion = Fusion.UNINFORMATIVE
    for axis in range(3):
        measurement = Measurement(stationary.mean_gyro[axis] - nav.gyro_bias[axis], b=unit_axis(axis))
        cross_cov = cross_covariance_of(nav, measurement)
        residuals.append(measurement.residual)
        variances.append(cross_cov.state_variance + variance)
        if cross_cov.state_variance > floor:
            fusion = Fusion.USED
            nav = fuse(nav, measurement, cross_cov, variance, estimates_sensors)
    return nav, Innovation(Aid.ZERO_RATE, fusion, t_ns, stationary.mean_gyro, tuple(residuals), tuple(variances))


def _zero_velocity_update(
    nav: NavigationState, estimates_sensors: bool, t_ns: int
) -> tuple[NavigationState, Innovation]:
    """The velocity is zero."""
    residuals: list[float] = []
    variances: list[float] = []
    for axis in range(3):
        measurement = Measurement(-nav.velocity[axis], v=unit_axis(axis))
        cross_cov = cross_covariance_of(nav, measurement)
        residuals.append(measurement.residual)
        variances.append(cross_cov.state_variance + VELOCITY_SIGMA**2)
        nav = fuse(nav, measurement, cross_cov, VELOCITY_SIGMA**2, estimates_sensors)
    zero = (0.0, 0.0, 0.0)
    return nav, Innovation(Aid.ZERO_VELOCITY, Fusion.USED, t_ns, zero, tuple(residuals), tuple(variances))
