"""Zero mean velocity: a vehicle that is carried or turned by hand stays where it is in the mean."""

from attest_mav.algebra import unit_axis
from attest_mav.filters.velocity_aided.aids.pseudo_measurement import robust_update
from attest_mav.filters.velocity_aided.covariance import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters


def fuse_zero_mean_velocity(
    nav: NavigationState, since_update_s: float, parameters: FlightParameters
) -> NavigationState:
    """The state after three measurements of zero velocity."""
    variance = parameters.place_noise**2 / since_update_s
    for axis in range(3):
        nav = robust_update(nav, Measurement(-nav.velocity[axis], v=unit_axis(axis)), variance)
    return nav
