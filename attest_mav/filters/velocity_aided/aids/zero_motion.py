"""Rest: what a vehicle that stands still tells, and how it is known to stand.

At rest the gyro shows its bias and the velocity is zero. An int16 gyro that reads zero hides up to a unit of
bias, in the same way for minutes on end, so rest never makes the bias better known than ``rest_floor``.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, scale, sub, unit_axis
from attest_mav.filters.velocity_aided.covariance import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, fuse, with_variances
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import Reading
from attest_mav.types import Vec3

MEAN_S: Final = 0.3
"""Time constant of the running means of gyro and accelerometer."""
QUIET_RATE: Final = 0.02
"""rad/s: at rest the gyro stays this close to its mean,"""
QUIET_ACCEL: Final = 0.3
"""m/s^2: and the accelerometer to its own."""
MAX_BIAS: Final = 0.035
"""rad/s: a steady rate above this is a turn."""
QUIET_S: Final = 1.5
"""Quiet for this long is rest."""
SETTLED_S: Final = 60.0
"""Quiet for this long, nothing new is seen of the sensors: their errors cannot be told from those of the attitude."""
MAX_SPEED: Final = 0.3
"""m/s: what moves faster does not rest, however quiet: a plane in smooth cruise is as quiet as a desk."""
READS_ZERO: Final = 1e-4
"""rad/s: a mean below this comes from a gyro that reads zero."""
SPACING_S: Final = 0.1
"""Time between rows."""
VELOCITY_SIGMA: Final = 0.05
"""m/s: of the zero velocity."""


@mypyc_attr(acyclic=True)
class Stationary:
    """Running means (rad/s, m/s^2), and times, s.

    steady_s: for how long the sensors have been quiet. quiet_s: the same, while there was no speed. waited_s: since
    the last rows.
    """

    def __init__(
        self, mean_gyro: Vec3, mean_accel: Vec3, quiet_s: float, still_s: float, since_update_s: float
    ) -> None:
        self.mean_gyro: Final = mean_gyro
        self.mean_accel: Final = mean_accel
        self.quiet_s: Final = quiet_s
        self.still_s: Final = still_s
        self.since_update_s: Final = since_update_s

    @property
    def is_stationary(self) -> bool:
        """True while the vehicle stands still."""
        return self.still_s >= QUIET_S

    @property
    def is_settled(self) -> bool:
        """True when nothing has changed for so long that rows teach nothing of the sensors any more."""
        return self.quiet_s >= SETTLED_S


def detect(stationary: Stationary, reading: Reading, speed: float, dt_s: float) -> Stationary:
    """The watch after a sample. ``speed``: that the vehicle is known or feared to have, m/s."""
    share = min(1.0, dt_s / MEAN_S)
    gyro = add(stationary.mean_gyro, scale(sub(reading.gyro, stationary.mean_gyro), share))
    accel = add(stationary.mean_accel, scale(sub(reading.accel, stationary.mean_accel), share))
    quiet = (
        norm(sub(reading.gyro, gyro)) < QUIET_RATE
        and norm(sub(reading.accel, accel)) < QUIET_ACCEL
        and norm(gyro) < MAX_BIAS
        and not reading.saturated
    )
    return Stationary(
        gyro,
        accel,
        stationary.quiet_s + dt_s if quiet else 0.0,
        stationary.still_s + dt_s if quiet and speed < MAX_SPEED else 0.0,
        stationary.since_update_s + dt_s,
    )


def fuse_zero_motion(
    nav: NavigationState, stationary: Stationary, aided: bool, estimates_sensors: bool, parameters: FlightParameters
) -> tuple[NavigationState, Stationary]:
    """Motion and watch after what is due at rest. ``aided``: velocity fixes arrive.

    teaches: the rows may tell something of the sensors.

    Then rest is not used: a hovering copter is as quiet as a standing one, and turns slowly while its own filter's
    heading creeps. Only the bias that a gyro reading zero may hide is kept in mind.
    """
    if not stationary.is_stationary or stationary.since_update_s < SPACING_S:
        return nav, stationary
    floor = parameters.rest_floor**2
    if norm(stationary.mean_gyro) < READS_ZERO or not aided:
        nav = with_variances(nav, floor, 0.0)
    if not aided:
        nav = _zero_motion_update(nav, stationary, estimates_sensors, parameters)
    return nav, Stationary(stationary.mean_gyro, stationary.mean_accel, stationary.quiet_s, stationary.still_s, 0.0)


def _zero_motion_update(
    nav: NavigationState, stationary: Stationary, estimates_sensors: bool, parameters: FlightParameters
) -> NavigationState:
    """The motion after the rows of rest: the mean gyro is its bias, the velocity is zero."""
    floor = parameters.rest_floor**2
    for axis in range(3):
        measurement = Measurement(stationary.mean_gyro[axis] - nav.gyro_bias[axis], b=unit_axis(axis))
        cross_cov = cross_covariance_of(nav, measurement)
        if cross_cov.state_variance > floor:
            # One row of a mean over ``MEAN_S``.
            nav = fuse(nav, measurement, cross_cov, floor * MEAN_S / stationary.since_update_s, estimates_sensors)
    for axis in range(3):
        measurement = Measurement(-nav.velocity[axis], v=unit_axis(axis))
        nav = fuse(nav, measurement, cross_covariance_of(nav, measurement), VELOCITY_SIGMA**2, estimates_sensors)
    return nav
