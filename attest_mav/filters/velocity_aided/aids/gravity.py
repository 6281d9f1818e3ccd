"""Gravity: no vehicle accelerates sideways for ever, so the horizontal acceleration is zero in the mean.

The aid of last resort, a pseudo-measurement of the horizontal specific force. Its residual contains the accelerometer's
bias as well, which the update considers. (Levelling by the accelerometer: Groves, Principles of GNSS, Inertial, and
Multisensor Integrated Navigation Systems, 2nd ed., section 5.6.2.)
"""

from attest_mav.algebra import square
from attest_mav.filters.velocity_aided.aids.fallback import FallbackUpdate
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.innovation import Aid, Innovation
from attest_mav.types import Vec3


def fuse_gravity(
    nav: NavigationState, specific_force: Vec3, since_update_s: float, t_ns: int, parameters: FlightParameters
) -> tuple[NavigationState, Innovation]:
    """The state after two measurements of zero horizontal acceleration. ``specific_force``: NED, m/s^2."""
    update = FallbackUpdate(nav, square(parameters.gravity_noise) / since_update_s, estimates_sensors=False)
    north, east = gravity_measurements(specific_force)
    update.fuse(north, 0.0)
    update.fuse(east, 0.0)
    return update.nav, update.innovation(Aid.GRAVITY, t_ns)


def gravity_measurements(specific_force: Vec3) -> tuple[Measurement, Measurement]:
    """The true acceleration is C f + t x (C f) + g: a horizontal part of C f is a tilt error t."""
    x, y, z = specific_force
    return (Measurement(-x, t=(0.0, z, -y)), Measurement(-y, t=(-z, 0.0, x)))
