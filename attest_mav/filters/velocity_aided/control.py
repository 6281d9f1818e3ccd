"""One step of the flight filter after alignment: prediction, then the aids that the moment offers.

*Control* is here: which aid starts, continues and stops, and by which conditions. *Correction*, how a measurement is
made and fused, is in ``aids``.
"""

from math import inf
from typing import Final

from attest_mav.algebra import add, hypotenuse, norm, scale
from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.aids.airspeed import (
    airspeed_ahead,
    estimate_wind,
    fuse_airspeed,
    has_airspeed_of_flight,
)
from attest_mav.filters.velocity_aided.aids.fallback import SPACING_S, Fallback
from attest_mav.filters.velocity_aided.aids.field import levelled_field
from attest_mav.filters.velocity_aided.aids.gnss_velocity import GnssVelocity, fix_is_due, fuse_velocity
from attest_mav.filters.velocity_aided.aids.gravity import fuse_gravity
from attest_mav.filters.velocity_aided.aids.iron import IronFit, watch_iron
from attest_mav.filters.velocity_aided.aids.magnetometer import Magnetometer, fuse_magnetometer, reading_is_due
from attest_mav.filters.velocity_aided.aids.zero_mean_velocity import fuse_zero_mean_velocity
from attest_mav.filters.velocity_aided.aids.zero_motion import Stationary, detect, fuse_zero_motion
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock
from attest_mav.filters.velocity_aided.imu_memory import ImuMemory
from attest_mav.filters.velocity_aided.nav_state import NavigationState, body_rate
from attest_mav.filters.velocity_aided.navigation import AidingMode, Navigation
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import predict
from attest_mav.filters.velocity_aided.reading import Reading, field_of
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.samples import ImuSample, VelocitySample

LOST_S: Final = 2.0
"""Without a fix for this long the velocity counts as lost, s."""
REJECTED_S: Final = 5.0
"""A field that disagrees with the heading for longer makes the heading less certain, s."""
REJECTED_HEADING_NOISE: Final = 0.0087
"""rad per root s: how fast."""
STANDING_SPEED: Final = 1.0
"""m/s: of a faster vehicle the velocity knows the heading better than a disturbed field."""
NO_FALLBACK: Final = Fallback(0.0, None)
"""While fixes arrive the fallback timer is reset, because no fallback is needed."""


def navigate(
    before: Navigation,
    reading: Reading,
    sample: ImuSample,
    inputs: FilterInputs,
    dt_s: float,
    parameters: FlightParameters,
) -> Navigation:
    """The navigation ``dt_s`` later, at the reading taken then."""
    has_north = before.gnss.since_fused_s < LOST_S
    nav, imu = predict(before.estimate, before.imu, reading, dt_s, sample.t_ns, has_north, parameters)
    gnss = before.gnss.aged(dt_s)
    estimates_sensors = not before.stationary.is_settled
    fix = inputs.velocity
    if fix is not None and fix_is_due(gnss, fix, parameters):
        nav, gnss = fuse_velocity(nav, imu, gnss, fix, estimates_sensors, parameters)
    stationary = detect(before.stationary, reading, _speed_against_rest(fix, inputs), dt_s)
    nav, stationary = fuse_zero_motion(
        nav, stationary, gnss.since_fused_s < LOST_S, estimates_sensors, sample.t_ns, parameters
    )
    mode = _aiding_mode(gnss, stationary, inputs, parameters)
    wind, fallback = before.wind, NO_FALLBACK
    if mode == AidingMode.VELOCITY:
        wind = estimate_wind(wind, nav, airspeed_ahead(inputs), dt_s)
    else:
        nav, fallback = _fuse_fallback(nav, before, mode, imu, inputs, dt_s, parameters)
    in_place = gnss.last is None and inputs.zero_mean_velocity
    nav, magnetometer, iron = _fuse_field(nav, before, reading, sample, dt_s, in_place, parameters)
    imu, declination, begun_with = imu.with_attitude(nav), before.declination, before.begun_with
    return Navigation(
        nav, imu, gnss, magnetometer, iron, stationary, wind, fallback, declination, mode, begun_with, has_stepped=True
    )


def _speed_against_rest(fix: VelocitySample | None, inputs: FilterInputs) -> float:
    """Speed used by the stationary detector, m/s.

    Infinite when under way without a fix, because steady cruise is as quiet as standing.
    """
    if fix is not None:
        return norm(fix.v_ned)
    return 0.0 if inputs.zero_mean_velocity else inf


def _aiding_mode(
    gnss: GnssVelocity, stationary: Stationary, inputs: FilterInputs, parameters: FlightParameters
) -> AidingMode:
    """Which aid holds the attitude now, by starting conditions in the order of worth."""
    if gnss.since_fused_s < LOST_S:
        return AidingMode.VELOCITY
    if stationary.is_stationary:
        return AidingMode.STATIONARY
    if has_airspeed_of_flight(inputs):
        return AidingMode.AIRSPEED
    never_had_velocity = gnss.last is None
    if never_had_velocity and inputs.zero_mean_velocity:
        return AidingMode.ZERO_MEAN_VELOCITY
    carries_velocity_on = not never_had_velocity and gnss.since_fused_s < parameters.coast_s
    return AidingMode.COASTING if carries_velocity_on else AidingMode.GRAVITY


def _fuse_fallback(
    nav: NavigationState,
    before: Navigation,
    mode: AidingMode,
    imu: ImuMemory,
    inputs: FilterInputs,
    dt_s: float,
    parameters: FlightParameters,
) -> tuple[NavigationState, Fallback]:
    """State and timer after the aid that takes the place of velocity fixes, if it is due."""
    since_s = before.fallback.since_update_s + dt_s
    if since_s < SPACING_S:
        return nav, Fallback(since_s, None)
    t_ns = imu.history.newest.t_ns
    innovation: Innovation | None = None
    if mode == AidingMode.AIRSPEED:
        wind, airspeed = before.wind.velocity, airspeed_ahead(inputs)
        nav, innovation = fuse_airspeed(nav, wind, airspeed, since_s, t_ns, parameters)
    elif mode == AidingMode.GRAVITY:
        nav, innovation = fuse_gravity(nav, imu.specific_force, since_s, t_ns, parameters)
    elif mode == AidingMode.ZERO_MEAN_VELOCITY:
        nav, innovation = fuse_zero_mean_velocity(nav, since_s, t_ns, parameters)
    return nav, Fallback(0.0, innovation)


def _fuse_field(
    nav: NavigationState,
    before: Navigation,
    reading: Reading,
    sample: ImuSample,
    dt_s: float,
    in_place: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, Magnetometer, IronFit | None]:
    """State, magnetometer memory and fit of the iron after the sample's field, if it is a new one."""
    memory = before.magnetometer
    iron = before.iron if in_place else None
    field = field_of(sample)
    if field is None:
        is_new = memory.is_new(sample)
        unusable = Innovation(Aid.MAGNETOMETER, Fusion.IMPLAUSIBLE, sample.t_ns) if is_new else None
        return nav, memory.skipped(sample, dt_s, unusable), iron
    if not reading_is_due(memory, sample, dt_s, parameters):
        return nav, memory.skipped(sample, dt_s, None), iron
    rate = body_rate(nav, scale(add(before.imu.gyro, reading.gyro), 0.5))
    levelled = levelled_field(nav, field, rate, before.assumed_declination)
    estimates_sensors, q_before = not before.stationary.is_settled, nav.q_nb
    nav, magnetometer = fuse_magnetometer(nav, memory, sample, levelled, dt_s, estimates_sensors, parameters)
    # The vertical velocity is not always measured, and then drifts.
    horizontal_speed = hypotenuse(nav.velocity[0], nav.velocity[1])
    velocity_shows_heading = before.gnss.since_fused_s < LOST_S and horizontal_speed > STANDING_SPEED
    since_s = memory.since_reading_s + dt_s
    if magnetometer.since_accepted_s > REJECTED_S and not velocity_shows_heading:
        nav = nav.with_added_variance(ErrorBlock.ATTITUDE, (0.0, 0.0, REJECTED_HEADING_NOISE**2 * since_s))
    if in_place:
        nav, magnetometer, iron = watch_iron(nav, magnetometer, iron, levelled, q_before, since_s, parameters)
    return nav, magnetometer, iron
