"""One step of the flight filter after alignment: dead reckoning, then the rows that the moment offers.

*Control* (which rows, and what they are called) is here; *correction* (how a row is made) is in the modules below.
"""

from enum import IntEnum
from math import hypot, inf
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, scale
from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.aids.fallback import (
    FLYING_SPEED,
    SPACING_S,
    Air,
    held_by_air,
    held_by_gravity,
    held_in_place,
    learned,
)
from attest_mav.filters.velocity_aided.aids.gnss_velocity import MAX_VELOCITY, Fixes, due, fixed, waited
from attest_mav.filters.velocity_aided.aids.magnetometer import Compass, field_of, is_due, steered, unread
from attest_mav.filters.velocity_aided.aids.zero_motion import Rest, rested, watched
from attest_mav.filters.velocity_aided.nav_state import Motion, rate_of, with_variances
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import Reading, Strapdown, advanced, turned_memory
from attest_mav.types import ImuSample, Vec3, VelocitySample

LOST_S: Final = 2.0
"""Without a fix for this long the velocity counts as lost."""
REJECTED_S: Final = 5.0
"""A field that disagrees with the heading for longer makes the heading doubtful."""
REJECTED_DOUBT: Final = 0.0087
"""rad per root s: how fast."""


STANDING_SPEED: Final = 1.0
"""m/s: of a vehicle that moves faster the velocity knows the heading better than a disturbed field."""


class Aid(IntEnum):
    """What keeps the attitude from drifting."""

    VELOCITY = 0
    """Velocity fixes."""
    REST = 1
    """The vehicle stands still."""
    COASTING = 2
    """Nothing yet: the fixes have stopped, the velocity is carried on."""
    AIRSPEED = 3
    """The airspeed of a wing, with the wind as it was."""
    GRAVITY = 4
    """The mean specific force."""
    PLACE = 5
    """Motion that stays in place: the mean velocity is zero."""


@mypyc_attr(acyclic=True)
class Flying:
    """Everything that a step needs of the one before. declination: rad, 0 while it is not known."""

    def __init__(
        self,
        motion: Motion,
        strapdown: Strapdown,
        fixes: Fixes,
        compass: Compass,
        rest: Rest,
        air: Air,
        declination: float,
        declined: bool,
        aid: Aid,
    ) -> None:
        self.motion: Final = motion
        self.strapdown: Final = strapdown
        self.fixes: Final = fixes
        self.compass: Final = compass
        self.rest: Final = rest
        self.air: Final = air
        self.declination: Final = declination
        self.declined: Final = declined
        self.aid: Final = aid


def flown(
    before: Flying, reading: Reading, sample: ImuSample, aids: FilterInputs, dt_s: float, settings: FlightParameters
) -> Flying:
    """The flight ``dt_s`` later, at the reading taken then."""
    aided = before.fixes.lost_s < LOST_S
    motion, strapdown = advanced(before.motion, before.strapdown, reading, dt_s, sample.t_ns, aided, settings)
    fixes = waited(before.fixes, dt_s)
    teaches = not before.rest.settled
    fix = aids.velocity
    if fix is not None and due(fixes, fix, settings):
        motion, fixes = fixed(motion, strapdown.track, fixes, fix, teaches, settings)
    rest = watched(before.rest, reading, _speed(fix, aids), dt_s)
    motion, rest = rested(motion, rest, fixes.lost_s < LOST_S, teaches, settings)
    aid = _aid(fixes, rest, aids, settings)
    motion, air = _substituted(motion, before.air, aid, strapdown.force, aids, dt_s, settings)
    rate = rate_of(motion, scale(add(before.strapdown.gyro, reading.gyro), 0.5))
    motion, compass = _steered(motion, before, sample, rate, dt_s, teaches, settings)
    return Flying(
        motion,
        turned_memory(strapdown, motion),
        fixes,
        compass,
        rest,
        air,
        before.declination,
        before.declined,
        aid,
    )


def _speed(fix: VelocitySample | None, aids: FilterInputs) -> float:
    """What speaks against rest, m/s. Under way and without a fix nothing is known: cruise is as quiet as a desk."""
    if fix is not None:
        return norm(fix.v_ned)
    return 0.0 if aids.zero_mean_velocity else inf


def is_wing_flying(aids: FilterInputs) -> bool:
    """True when the air speed is that of a wing in flight."""
    return _wing_speed(aids) > FLYING_SPEED


def _aid(fixes: Fixes, rest: Rest, aids: FilterInputs, settings: FlightParameters) -> Aid:
    """What the attitude rests on now."""
    if fixes.lost_s < LOST_S:
        return Aid.VELOCITY
    if rest.resting:
        return Aid.REST
    if is_wing_flying(aids):
        return Aid.AIRSPEED
    if not fixes.source and aids.zero_mean_velocity:
        return Aid.PLACE
    return Aid.COASTING if fixes.source and fixes.lost_s < settings.coast_s else Aid.GRAVITY


def _wing_speed(aids: FilterInputs) -> float:
    """Airspeed of a vehicle that goes where it points, m/s; 0 where there is none that can be used."""
    airspeed = aids.airspeed
    if airspeed is None or not aids.goes_where_it_points:
        return 0.0
    return airspeed.speed if 0.0 < airspeed.speed < MAX_VELOCITY else 0.0


def _substituted(
    motion: Motion, air: Air, aid: Aid, force: Vec3, aids: FilterInputs, dt_s: float, settings: FlightParameters
) -> tuple[Motion, Air]:
    """Motion and wind after what takes the place of fixes."""
    speed = _wing_speed(aids)
    if aid == Aid.VELOCITY:
        return motion, learned(air, motion, speed, dt_s)
    waited_s = air.waited_s + dt_s
    if waited_s < SPACING_S:
        return motion, Air(air.wind, air.learned_s, waited_s)
    if aid == Aid.AIRSPEED:
        motion = held_by_air(motion, Air(air.wind, air.learned_s, waited_s), speed, settings)
    elif aid == Aid.GRAVITY:
        motion = held_by_gravity(motion, force, waited_s, settings)
    elif aid == Aid.PLACE:
        motion = held_in_place(motion, waited_s, settings)
    return motion, Air(air.wind, air.learned_s, 0.0)


def _steered(
    motion: Motion,
    before: Flying,
    sample: ImuSample,
    rate: Vec3,
    dt_s: float,
    teaches: bool,
    settings: FlightParameters,
) -> tuple[Motion, Compass]:
    """Motion and compass after the magnetometer's reading, if it is a new one."""
    field = field_of(sample)
    if field is None or not is_due(before.compass, sample, dt_s, settings):
        return motion, unread(before.compass, sample, dt_s)
    motion, compass = steered(motion, before.compass, sample, field, rate, dt_s, before.declination, teaches, settings)
    # The vertical velocity is not always measured, and then drifts.
    moving = before.fixes.lost_s < LOST_S and hypot(motion.velocity[0], motion.velocity[1]) > STANDING_SPEED
    if compass.lost_s > REJECTED_S and not moving:
        motion = with_variances(motion, 0.0, REJECTED_DOUBT**2 * (before.compass.held_s + dt_s))
    return motion, compass
