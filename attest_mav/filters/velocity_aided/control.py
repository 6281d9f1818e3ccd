"""One step of the flight filter after alignment: dead reckoning, then the rows that the moment offers.

*Control* (which rows, and what they are called) is here; *correction* (how a row is made) is in the modules below.
"""

from enum import IntEnum
from math import hypot, inf
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, scale
from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.aids.airspeed import FLYING_SPEED, Wind, estimate_wind, fuse_airspeed
from attest_mav.filters.velocity_aided.aids.gnss_velocity import (
    MAX_VELOCITY,
    GnssVelocity,
    aged,
    fix_is_due,
    fuse_velocity,
)
from attest_mav.filters.velocity_aided.aids.gravity import fuse_gravity
from attest_mav.filters.velocity_aided.aids.magnetometer import (
    Magnetometer,
    field_of,
    fuse_magnetometer,
    reading_is_due,
    skip_reading,
)
from attest_mav.filters.velocity_aided.aids.pseudo_measurement import SPACING_S
from attest_mav.filters.velocity_aided.aids.zero_mean_velocity import fuse_zero_mean_velocity
from attest_mav.filters.velocity_aided.aids.zero_motion import Stationary, detect, fuse_zero_motion
from attest_mav.filters.velocity_aided.nav_state import NavigationState, body_rate, with_variances
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import ImuMemory, Reading, predict, with_attitude
from attest_mav.types import ImuSample, Vec3, VelocitySample

LOST_S: Final = 2.0
"""Without a fix for this long the velocity counts as lost."""
REJECTED_S: Final = 5.0
"""A field that disagrees with the heading for longer makes the heading doubtful."""
REJECTED_HEADING_NOISE: Final = 0.0087
"""rad per root s: how fast."""


STANDING_SPEED: Final = 1.0
"""m/s: of a vehicle that moves faster the velocity knows the heading better than a disturbed field."""


class AidingMode(IntEnum):
    """What keeps the attitude from drifting."""

    VELOCITY = 0
    """Velocity gnss."""
    STATIONARY = 1
    """The vehicle stands still."""
    COASTING = 2
    """Nothing yet: the gnss have stopped, the velocity is carried on."""
    AIRSPEED = 3
    """The airspeed of a wing, with the wind as it was."""
    GRAVITY = 4
    """The mean specific force."""
    ZERO_MEAN_VELOCITY = 5
    """Motion that stays in place: the mean velocity is zero."""


@mypyc_attr(acyclic=True)
class Navigation:
    """Everything that a step needs of the one before. declination: rad, 0 while it is not known."""

    def __init__(
        self,
        estimate: NavigationState,
        imu: ImuMemory,
        gnss: GnssVelocity,
        magnetometer: Magnetometer,
        stationary: Stationary,
        wind: Wind,
        declination: float,
        declination_known: bool,
        mode: AidingMode,
    ) -> None:
        self.estimate: Final = estimate
        self.imu: Final = imu
        self.gnss: Final = gnss
        self.magnetometer: Final = magnetometer
        self.stationary: Final = stationary
        self.wind: Final = wind
        self.declination: Final = declination
        self.declination_known: Final = declination_known
        self.mode: Final = mode


def navigate(
    before: Navigation,
    reading: Reading,
    sample: ImuSample,
    inputs: FilterInputs,
    dt_s: float,
    parameters: FlightParameters,
) -> Navigation:
    """The flight ``dt_s`` later, at the reading taken then."""
    aided = before.gnss.since_fused_s < LOST_S
    nav, imu = predict(before.estimate, before.imu, reading, dt_s, sample.t_ns, aided, parameters)
    gnss = aged(before.gnss, dt_s)
    estimates_sensors = not before.stationary.is_settled
    fix = inputs.velocity
    if fix is not None and fix_is_due(gnss, fix, parameters):
        nav, gnss = fuse_velocity(nav, imu.history, gnss, fix, estimates_sensors, parameters)
    stationary = detect(before.stationary, reading, _speed_against_rest(fix, inputs), dt_s)
    nav, stationary = fuse_zero_motion(nav, stationary, gnss.since_fused_s < LOST_S, estimates_sensors, parameters)
    mode = _aiding_mode(gnss, stationary, inputs, parameters)
    nav, wind = _fuse_fallback(nav, before.wind, mode, imu.specific_force, inputs, dt_s, parameters)
    rate = body_rate(nav, scale(add(before.imu.gyro, reading.gyro), 0.5))
    nav, magnetometer = _fuse_heading(nav, before, sample, rate, dt_s, estimates_sensors, parameters)
    return Navigation(
        nav,
        with_attitude(imu, nav),
        gnss,
        magnetometer,
        stationary,
        wind,
        before.declination,
        before.declination_known,
        mode,
    )


def _speed_against_rest(fix: VelocitySample | None, inputs: FilterInputs) -> float:
    """What speaks against rest, m/s. Under way and without a fix nothing is known: cruise is as quiet as a desk."""
    if fix is not None:
        return norm(fix.v_ned)
    return 0.0 if inputs.zero_mean_velocity else inf


def has_wing_airspeed(inputs: FilterInputs) -> bool:
    """True when the air speed is that of a wing in flight."""
    return _wing_speed(inputs) > FLYING_SPEED


def _aiding_mode(
    gnss: GnssVelocity, stationary: Stationary, inputs: FilterInputs, parameters: FlightParameters
) -> AidingMode:
    """What the attitude rests on now."""
    if gnss.since_fused_s < LOST_S:
        return AidingMode.VELOCITY
    if stationary.is_stationary:
        return AidingMode.STATIONARY
    if has_wing_airspeed(inputs):
        return AidingMode.AIRSPEED
    if not gnss.source and inputs.zero_mean_velocity:
        return AidingMode.ZERO_MEAN_VELOCITY
    return AidingMode.COASTING if gnss.source and gnss.since_fused_s < parameters.coast_s else AidingMode.GRAVITY


def _wing_speed(inputs: FilterInputs) -> float:
    """Airspeed of a vehicle that goes where it points, m/s; 0 where there is none that can be used."""
    airspeed = inputs.airspeed
    if airspeed is None or not inputs.goes_where_it_points:
        return 0.0
    return airspeed.speed if 0.0 < airspeed.speed < MAX_VELOCITY else 0.0


def _fuse_fallback(
    nav: NavigationState,
    wind: Wind,
    mode: AidingMode,
    specific_force: Vec3,
    inputs: FilterInputs,
    dt_s: float,
    parameters: FlightParameters,
) -> tuple[NavigationState, Wind]:
    """Motion and wind after what takes the place of gnss."""
    speed = _wing_speed(inputs)
    if mode == AidingMode.VELOCITY:
        return nav, estimate_wind(wind, nav, speed, dt_s)
    since_update_s = wind.since_update_s + dt_s
    if since_update_s < SPACING_S:
        return nav, Wind(wind.velocity, wind.averaged_s, since_update_s)
    if mode == AidingMode.AIRSPEED:
        nav = fuse_airspeed(nav, Wind(wind.velocity, wind.averaged_s, since_update_s), speed, parameters)
    elif mode == AidingMode.GRAVITY:
        nav = fuse_gravity(nav, specific_force, since_update_s, parameters)
    elif mode == AidingMode.ZERO_MEAN_VELOCITY:
        nav = fuse_zero_mean_velocity(nav, since_update_s, parameters)
    return nav, Wind(wind.velocity, wind.averaged_s, 0.0)


def _fuse_heading(
    nav: NavigationState,
    before: Navigation,
    sample: ImuSample,
    rate: Vec3,
    dt_s: float,
    estimates_sensors: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, Magnetometer]:
    """Motion and compass after the magnetometer's reading, if it is a new one."""
    field = field_of(sample)
    if field is None or not reading_is_due(before.magnetometer, sample, dt_s, parameters):
        return nav, skip_reading(before.magnetometer, sample, dt_s)
    nav, magnetometer = fuse_magnetometer(
        nav, before.magnetometer, sample, field, rate, dt_s, before.declination, estimates_sensors, parameters
    )
    # The vertical velocity is not always measured, and then drifts.
    moving = before.gnss.since_fused_s < LOST_S and hypot(nav.velocity[0], nav.velocity[1]) > STANDING_SPEED
    if magnetometer.since_accepted_s > REJECTED_S and not moving:
        nav = with_variances(nav, 0.0, REJECTED_HEADING_NOISE**2 * (before.magnetometer.since_reading_s + dt_s))
    return nav, magnetometer
