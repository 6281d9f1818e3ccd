"""Zero mean velocity: a vehicle that is carried or turned by hand stays where it is in the mean.

Assumed only of a vehicle that is not armed and never had a velocity. There the velocity averages to zero over seconds,
so the assumption may estimate the sensor errors too. (A soft zero-velocity update; Groves, Principles of GNSS,
Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 15.3.2.)
"""

from attest_mav.algebra import square, unit_axis
from attest_mav.filters.velocity_aided.aids.fallback import FallbackUpdate
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.innovation import Aid, Innovation


def fuse_zero_mean_velocity(
    nav: NavigationState, since_update_s: float, t_ns: int, parameters: FlightParameters
) -> tuple[NavigationState, Innovation]:
    """The state after three measurements of zero velocity."""
    update = FallbackUpdate(nav, square(parameters.place_noise) / since_update_s, estimates_sensors=True)
    for axis in range(3):
        update.fuse(Measurement(-update.nav.velocity[axis], v=unit_axis(axis)), 0.0)
    return update.nav, update.innovation(Aid.ZERO_MEAN_VELOCITY, t_ns)
