"""The flight at its start, and what a restart keeps of the one before."""

from math import isfinite
from typing import Final

from attest_mav.filters.velocity_aided.aids.airspeed import unknown_wind
from attest_mav.filters.velocity_aided.aids.gnss_velocity import after_reset, initial_gnss_velocity
from attest_mav.filters.velocity_aided.aids.magnetometer import initial_magnetometer
from attest_mav.filters.velocity_aided.aids.zero_motion import Stationary
from attest_mav.filters.velocity_aided.alignment.solve import AlignmentMethod, InitialState
from attest_mav.filters.velocity_aided.control import AidingMode, Navigation
from attest_mav.filters.velocity_aided.covariance import Covariance, Measurement
from attest_mav.filters.velocity_aided.history import empty_history
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, update
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import ImuMemory, Reading, specific_force_ned
from attest_mav.matrices import add_diagonal, diagonal
from attest_mav.types import Vec3

UNKNOWN_DECLINATION: Final = 0.3
"""rad: where people fly, magnetic north is rarely further from true north."""


def initialize(
    initial: InitialState,
    before: Navigation | None,
    reading: Reading,
    t_ns: int,
    bias: Vec3,
    declination: float,
    gap_s: float,
    parameters: FlightParameters,
) -> Navigation:
    """The first moment of flight, at the reading of ``t_ns``.

    before: an earlier flight, whose knowledge of the sensors is kept. bias: of the gyro, rad/s, where there is none.
    declination: rad, NaN when it is not known. gap_s: since the earlier flight ended.
    """
    if before is None:
        declination_known = isfinite(declination)
        nav = _first_state(initial, bias, declination_known, parameters)
        known_gnss, magnetometer, wind = (
            initial_gnss_velocity(parameters),
            initial_magnetometer(parameters),
            unknown_wind(),
        )
        north = declination if declination_known else 0.0
    else:
        declination_known, north = before.declination_known, before.declination
        nav = _restarted_state(initial, before.estimate, gap_s, parameters)
        known_gnss, magnetometer, wind = before.gnss, before.magnetometer, before.wind
    gnss = after_reset(known_gnss, initial.method == AlignmentMethod.VELOCITY)
    force = specific_force_ned(nav, reading.accel)
    zero: Vec3 = (0.0, 0.0, 0.0)
    imu = ImuMemory(reading.gyro, reading.accel, zero, zero, 0.0, force, 0.0, 0.0, empty_history(t_ns))
    stationary = Stationary(reading.gyro, reading.accel, 0.0, 0.0, 0.0)
    return Navigation(nav, imu, gnss, magnetometer, stationary, wind, north, declination_known, AidingMode.COASTING)


def with_declination(navigation: Navigation, declination: float, parameters: FlightParameters) -> Navigation:
    """The flight with this declination, rad; the same flight if it is not known or no news."""
    if not isfinite(declination) or (navigation.declination_known and declination == navigation.declination):
        return navigation
    return Navigation(
        _turned_declination(
            navigation.estimate, declination - navigation.declination, not navigation.declination_known, parameters
        ),
        navigation.imu,
        navigation.gnss,
        navigation.magnetometer,
        navigation.stationary,
        navigation.wind,
        declination,
        True,
        navigation.mode,
    )


def _first_state(
    initial: InitialState, bias: Vec3, declination_known: bool, parameters: FlightParameters
) -> NavigationState:
    """A first start. bias: of the gyro, rad/s. declined: the declination is known."""
    delays = (parameters.mag_delay_s, parameters.fix_delay_s, 0.0)
    declination = parameters.declination_sigma if declination_known else UNKNOWN_DECLINATION
    dd = (
        (parameters.mag_delay_sigma**2, 0.0, 0.0),
        (0.0, parameters.fix_delay_sigma**2, 0.0),
        (0.0, 0.0, declination**2),
    )
    none = diagonal(0.0)
    zero: Vec3 = (0.0, 0.0, 0.0)
    p = Covariance(
        initial.attitude, none, none, none, none, none, none,
        diagonal(initial.velocity_sigma**2), none, none, none, none, none,
        diagonal(parameters.gyro_bias_sigma**2), none, none, none, none,
        diagonal(parameters.gyro_scale_sigma**2), none, none, none,
        diagonal(parameters.accel_bias_sigma**2), none, none,
        diagonal(parameters.hard_iron**2), none,
        dd,
    )  # fmt: skip
    return NavigationState(initial.q_nb, initial.velocity, bias, zero, zero, zero, delays, p)


def _restarted_state(
    initial: InitialState, before: NavigationState, gap_s: float, parameters: FlightParameters
) -> NavigationState:
    """A start after a gap or a failure: what the sensors' errors are known to be is kept."""
    p = before.p
    none = diagonal(0.0)
    kept = Covariance(
        initial.attitude, none, none, none, none, none, none,
        diagonal(initial.velocity_sigma**2), none, none, none, none, none,
        add_diagonal(p.bb, parameters.gyro_bias_walk**2 * gap_s), p.bs, p.ba, p.bm, p.bd, p.ss, p.sa, p.sm, p.sd,
        p.aa, p.am, p.ad, p.mm, p.md, p.dd,
    )  # fmt: skip
    return NavigationState(
        initial.q_nb,
        initial.velocity,
        before.gyro_bias,
        before.gyro_scale,
        before.accel_bias,
        before.hard_iron,
        before.delays,
        kept,
    )


def _turned_declination(
    nav: NavigationState, change: float, first: bool, parameters: FlightParameters
) -> NavigationState:
    """The motion after the declination turned out ``change`` larger, rad; ``first``: it had not been known.

    Magnetic north stays where it was estimated; the first declination is a measurement of where that is.
    """
    mag_delay, fix_delay, north = nav.delays
    nav = NavigationState(
        nav.q_nb,
        nav.velocity,
        nav.gyro_bias,
        nav.gyro_scale,
        nav.accel_bias,
        nav.hard_iron,
        (mag_delay, fix_delay, north - change),
        nav.p,
    )
    if not first:
        return nav
    measurement = Measurement(change - north, d=(0.0, 0.0, 1.0))
    return update(nav, measurement, cross_covariance_of(nav, measurement), parameters.declination_sigma**2)
