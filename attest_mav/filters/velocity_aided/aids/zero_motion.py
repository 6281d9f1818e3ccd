"""Rest: what a vehicle that stands still tells, and how it is known to stand.

At rest the gyro shows its bias and the velocity is zero. An int16 gyro that reads zero hides up to a unit of
bias, in the same way for minutes on end, so rest never makes the bias better known than ``rest_floor``.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, scale, sub
from attest_mav.filters.velocity_aided.aids.gnss_velocity import unit_axis
from attest_mav.filters.velocity_aided.covariance import Row
from attest_mav.filters.velocity_aided.nav_state import Motion, reach_of, taken, with_variances
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
class Rest:
    """Running means (rad/s, m/s^2), and times, s.

    steady_s: for how long the sensors have been quiet. quiet_s: the same, while there was no speed. waited_s: since
    the last rows.
    """

    def __init__(self, gyro: Vec3, accel: Vec3, steady_s: float, quiet_s: float, waited_s: float) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.steady_s: Final = steady_s
        self.quiet_s: Final = quiet_s
        self.waited_s: Final = waited_s

    @property
    def resting(self) -> bool:
        """True while the vehicle stands still."""
        return self.quiet_s >= QUIET_S

    @property
    def settled(self) -> bool:
        """True when nothing has changed for so long that rows teach nothing of the sensors any more."""
        return self.steady_s >= SETTLED_S


def watched(rest: Rest, reading: Reading, speed: float, dt_s: float) -> Rest:
    """The watch after a sample. ``speed``: that the vehicle is known or feared to have, m/s."""
    share = min(1.0, dt_s / MEAN_S)
    gyro = add(rest.gyro, scale(sub(reading.gyro, rest.gyro), share))
    accel = add(rest.accel, scale(sub(reading.accel, rest.accel), share))
    steady = (
        norm(sub(reading.gyro, gyro)) < QUIET_RATE
        and norm(sub(reading.accel, accel)) < QUIET_ACCEL
        and norm(gyro) < MAX_BIAS
        and not reading.saturated
    )
    return Rest(
        gyro,
        accel,
        rest.steady_s + dt_s if steady else 0.0,
        rest.quiet_s + dt_s if steady and speed < MAX_SPEED else 0.0,
        rest.waited_s + dt_s,
    )


def rested(motion: Motion, rest: Rest, aided: bool, teaches: bool, settings: FlightParameters) -> tuple[Motion, Rest]:
    """Motion and watch after what is due at rest. ``aided``: velocity fixes arrive.

    teaches: the rows may tell something of the sensors.

    Then rest is not used: a hovering copter is as quiet as a standing one, and turns slowly while its own filter's
    heading creeps. Only the bias that a gyro reading zero may hide is kept in mind.
    """
    if not rest.resting or rest.waited_s < SPACING_S:
        return motion, rest
    floor = settings.rest_floor**2
    if norm(rest.gyro) < READS_ZERO or not aided:
        motion = with_variances(motion, floor, 0.0)
    if not aided:
        motion = _still(motion, rest, teaches, settings)
    return motion, Rest(rest.gyro, rest.accel, rest.steady_s, rest.quiet_s, 0.0)


def _still(motion: Motion, rest: Rest, teaches: bool, settings: FlightParameters) -> Motion:
    """The motion after the rows of rest: the mean gyro is its bias, the velocity is zero."""
    floor = settings.rest_floor**2
    for axis in range(3):
        row = Row(rest.gyro[axis] - motion.gyro_bias[axis], b=unit_axis(axis))
        seen = reach_of(motion, row)
        if seen.variance > floor:
            # One row of a mean over ``MEAN_S``.
            motion = taken(motion, row, seen, floor * MEAN_S / rest.waited_s, teaches)
    for axis in range(3):
        row = Row(-motion.velocity[axis], v=unit_axis(axis))
        motion = taken(motion, row, reach_of(motion, row), VELOCITY_SIGMA**2, teaches)
    return motion
