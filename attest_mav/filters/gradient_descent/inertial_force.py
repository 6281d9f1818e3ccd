"""The specific force, low-passed in axes that do not turn (Laidig and Seel, Information Fusion 91, 2023).

The gyro alone carries an attitude along, whose axes are almost inertial: they drift as slowly as the gyro's bias. There
gravity is constant, and the accelerations of a motion that stays in place average out, which in the body they do not
while it turns.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import q_exp, q_mul, q_unit, rotate, rotate_back, scale
from attest_mav.low_pass import Smoothed, smoothed, steady
from attest_mav.record import Record
from attest_mav.types import Quat, Vec3


@mypyc_attr(acyclic=True)
class InertialForce(Record):
    """The low-passed specific force."""

    def __init__(self, q_inertial_body: Quat, force: Smoothed) -> None:
        self.q_inertial_body: Final = q_inertial_body
        """From the body to the almost inertial axes."""
        self.force: Final = force
        """In these, m/s^2."""

    @property
    def in_body(self) -> Vec3:
        """The low-passed force in the body's axes now, m/s^2."""
        return rotate_back(self.q_inertial_body, self.force.value)


def initial_force(q: Quat, accel: Vec3) -> InertialForce:
    """At the start, with the mean of the readings (m/s^2) in the body; the axes are those that q turns to."""
    return InertialForce(q, steady(rotate(q, accel)))


def advanced(before: InertialForce, gyro: Vec3, accel: Vec3 | None, dt_s: float, time_s: float) -> InertialForce:
    """After one more sample. gyro: without its bias, rad/s. accel: m/s^2, None leaves the force as it is.

    time_s: time constant of the low-pass.
    """
    q_inertial_body = q_unit(q_mul(before.q_inertial_body, q_exp(scale(gyro, 0.5 * dt_s))))
    if accel is None:
        return InertialForce(q_inertial_body, before.force)
    return InertialForce(q_inertial_body, smoothed(before.force, rotate(q_inertial_body, accel), dt_s, time_s))
