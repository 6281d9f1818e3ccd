"""The flight at its start, and what a restart keeps of the one before."""

from math import isfinite
from typing import Final

from attest_mav.filters.velocity_aided.aids.fallback import still_air
from attest_mav.filters.velocity_aided.aids.gnss_velocity import no_fixes, resumed
from attest_mav.filters.velocity_aided.aids.magnetometer import no_field
from attest_mav.filters.velocity_aided.aids.zero_motion import Rest
from attest_mav.filters.velocity_aided.alignment.solve import Basis, Begin
from attest_mav.filters.velocity_aided.control import Aid, Flying
from attest_mav.filters.velocity_aided.covariance import Covariance, Row
from attest_mav.filters.velocity_aided.history import begun
from attest_mav.filters.velocity_aided.nav_state import Motion, reach_of, updated
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import Reading, Strapdown, specific_force
from attest_mav.matrices import add_diagonal, diagonal
from attest_mav.types import Vec3

UNKNOWN_DECLINATION: Final = 0.3
"""rad: where people fly, magnetic north is rarely further from true north."""


def beginning(
    begin: Begin,
    before: Flying | None,
    reading: Reading,
    t_ns: int,
    bias: Vec3,
    declination: float,
    gap_s: float,
    settings: FlightParameters,
) -> Flying:
    """The first moment of flight, at the reading of ``t_ns``.

    before: an earlier flight, whose knowledge of the sensors is kept. bias: of the gyro, rad/s, where there is none.
    declination: rad, NaN when it is not known. gap_s: since the earlier flight ended.
    """
    if before is None:
        declined = isfinite(declination)
        motion = _first_motion(begin, bias, declined, settings)
        known_fixes, compass, air = no_fixes(settings), no_field(settings), still_air()
        north = declination if declined else 0.0
    else:
        declined, north = before.declined, before.declination
        motion = _kept_motion(begin, before.motion, gap_s, settings)
        known_fixes, compass, air = before.fixes, before.compass, before.air
    fixes = resumed(known_fixes, begin.basis == Basis.VELOCITY)
    force = specific_force(motion, reading.accel)
    zero: Vec3 = (0.0, 0.0, 0.0)
    strapdown = Strapdown(reading.gyro, reading.accel, zero, zero, 0.0, force, 0.0, 0.0, begun(t_ns))
    rest = Rest(reading.gyro, reading.accel, 0.0, 0.0, 0.0)
    return Flying(motion, strapdown, fixes, compass, rest, air, north, declined, Aid.COASTING)


def redeclined(flying: Flying, declination: float, settings: FlightParameters) -> Flying:
    """The flight with this declination, rad; the same flight if it is not known or no news."""
    if not isfinite(declination) or (flying.declined and declination == flying.declination):
        return flying
    return Flying(
        _with_declination(flying.motion, declination - flying.declination, not flying.declined, settings),
        flying.strapdown,
        flying.fixes,
        flying.compass,
        flying.rest,
        flying.air,
        declination,
        True,
        flying.aid,
    )


def _first_motion(begin: Begin, bias: Vec3, declined: bool, settings: FlightParameters) -> Motion:
    """A first start. bias: of the gyro, rad/s. declined: the declination is known."""
    delays = (settings.mag_delay_s, settings.fix_delay_s, 0.0)
    declination = settings.declination_sigma if declined else UNKNOWN_DECLINATION
    dd = (
        (settings.mag_delay_sigma**2, 0.0, 0.0),
        (0.0, settings.fix_delay_sigma**2, 0.0),
        (0.0, 0.0, declination**2),
    )
    none = diagonal(0.0)
    zero: Vec3 = (0.0, 0.0, 0.0)
    p = Covariance(
        begin.attitude, none, none, none, none, none, none,
        diagonal(begin.velocity_sigma**2), none, none, none, none, none,
        diagonal(settings.gyro_bias_sigma**2), none, none, none, none,
        diagonal(settings.gyro_scale_sigma**2), none, none, none,
        diagonal(settings.accel_bias_sigma**2), none, none,
        diagonal(settings.hard_iron**2), none,
        dd,
    )  # fmt: skip
    return Motion(begin.q_nb, begin.velocity, bias, zero, zero, zero, delays, p)


def _kept_motion(begin: Begin, before: Motion, gap_s: float, settings: FlightParameters) -> Motion:
    """A start after a gap or a failure: what the sensors' errors are known to be is kept."""
    p = before.p
    none = diagonal(0.0)
    kept = Covariance(
        begin.attitude, none, none, none, none, none, none,
        diagonal(begin.velocity_sigma**2), none, none, none, none, none,
        add_diagonal(p.bb, settings.gyro_bias_walk**2 * gap_s), p.bs, p.ba, p.bm, p.bd, p.ss, p.sa, p.sm, p.sd,
        p.aa, p.am, p.ad, p.mm, p.md, p.dd,
    )  # fmt: skip
    return Motion(
        begin.q_nb,
        begin.velocity,
        before.gyro_bias,
        before.gyro_scale,
        before.accel_bias,
        before.hard_iron,
        before.delays,
        kept,
    )


def _with_declination(motion: Motion, change: float, first: bool, settings: FlightParameters) -> Motion:
    """The motion after the declination turned out ``change`` larger, rad; ``first``: it had not been known.

    Magnetic north stays where it was estimated; the first declination is a measurement of where that is.
    """
    mag_delay, fix_delay, north = motion.delays
    motion = Motion(
        motion.q_nb,
        motion.velocity,
        motion.gyro_bias,
        motion.gyro_scale,
        motion.accel_bias,
        motion.hard_iron,
        (mag_delay, fix_delay, north - change),
        motion.p,
    )
    if not first:
        return motion
    row = Row(change - north, d=(0.0, 0.0, 1.0))
    return updated(motion, row, reach_of(motion, row), settings.declination_sigma**2)
