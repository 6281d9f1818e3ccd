"""Gravity: nothing accelerates sideways for ever, so the horizontal acceleration is zero in the mean.

The aid of last resort, a pseudo-measurement of the horizontal specific force.
"""

from attest_mav.filters.velocity_aided.aids.pseudo_measurement import robust_consider_update
from attest_mav.filters.velocity_aided.covariance import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.types import Vec3


def fuse_gravity(
    nav: NavigationState, specific_force: Vec3, since_update_s: float, parameters: FlightParameters
) -> NavigationState:
    """The state after two measurements of zero horizontal acceleration. ``specific_force``: NED, m/s^2."""
    variance = parameters.gravity_noise**2 / since_update_s
    first, second = gravity_measurements(specific_force)
    return robust_consider_update(robust_consider_update(nav, first, variance), second, variance)


def gravity_measurements(specific_force: Vec3) -> tuple[Measurement, Measurement]:
    """The true acceleration is C f + theta x (C f) + g: a horizontal part of C f is a tilt error."""
    x, y, z = specific_force
    return (Measurement(-x, t=(0.0, z, -y)), Measurement(-y, t=(-z, 0.0, x)))
