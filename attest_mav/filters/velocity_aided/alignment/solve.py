"""The first attitude: what an alignment has collected is solved for it, once that is good enough.

Each pair of fixes gives a direction twice: C u = dv - g dt, with u the integral of the specific force in the start's
axes. Where the vertical velocity is not measured its part follows from the length of u. The magnetic field gives
another direction, and Wahba's problem the attitude. At rest the mean specific force is gravity, and no fix is needed.
"""

from enum import IntEnum
from math import cos, isfinite, pi, sin, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, norm, q_mul, rotate, scale, sub, unit
from attest_mav.filters.velocity_aided.alignment.collect import Alignment, Fix
from attest_mav.filters.velocity_aided.alignment.wahba import LEAST_ANGLE, Fit, Pair, fitted, triad
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import add_diagonal
from attest_mav.types import Mat3, Quat, Vec3

MIN_BASE_S: Final = 0.45
"""Two fixes this far apart give a direction."""
LEAST_FORCE: Final = 1.0
"""m/s^2: a mean specific force below this (gravity's is ten) has no direction: free fall, or a dead accelerometer."""
GAIN_SIGMA: Final = 0.12
"""m/s: of the velocity gained between two fixes, in each axis."""
FIELD_SIGMA: Final = 0.03
"""Of the direction of the field, with what calibration leaves of the iron, rad."""
STILL_S: Final = 0.4
"""Still for this long, the vehicle aligns at rest."""
FIELD_PATIENCE_S: Final = 2.0
"""At rest it waits this long for a magnetometer."""
REST_TILT: Final = 0.03
"""rad: of a vehicle at rest, with what the accelerometer's bias and a rocking hull do to it."""
REST_HEADING: Final = 0.35
"""rad: wide, so that the first magnetometer row sets it, together with the iron that it may be due to."""
REST_SPEED: Final = 0.3
"""m/s."""
GUESSED_TILT: Final = 0.35
"""rad: of an attitude that takes acceleration for gravity, in an unknown manoeuvre."""
GUESSED_HEADING: Final = 0.7
GUESSED_SPEED: Final = 10.0


class Basis(IntEnum):
    """What a first attitude was made of."""

    REST = 0
    """Gravity, of a vehicle at rest."""
    VELOCITY = 1
    """Velocity fixes."""
    GUESS = 2
    """Acceleration, taken for gravity."""


@mypyc_attr(acyclic=True)
class Begin:
    """Where the filter begins: attitude and velocity (NED, m/s) now, and how well they are known.

    attitude: covariance of the attitude's error, rad^2. velocity_sigma: m/s.
    """

    def __init__(self, q_nb: Quat, attitude: Mat3, velocity: Vec3, velocity_sigma: float, basis: Basis) -> None:
        self.q_nb: Final = q_nb
        self.attitude: Final = attitude
        self.velocity: Final = velocity
        self.velocity_sigma: Final = velocity_sigma
        self.basis: Final = basis


def outcome(so_far: Alignment, declination: float, dip: float, settings: FlightParameters) -> Begin | None:
    """Where to begin, None while that is not known well enough. declination, dip: rad, dip NaN when it is not known."""
    if so_far.still_s >= STILL_S and (so_far.fields > 0 or so_far.waited_s > FIELD_PATIENCE_S):
        return _by_gravity(so_far, so_far.force_sum, declination, Basis.REST)
    pairs = _pairs(so_far, declination, dip, settings)
    fit = _doubted(fitted(pairs), so_far.missed) if pairs else None
    if fit is not None and (_good(fit, settings) or so_far.waited_s > settings.align_patience_s):
        return _by_velocity(so_far, fit, settings)
    felt = norm(so_far.track.head.gain) > LEAST_FORCE * so_far.waited_s
    if felt and so_far.waited_s > settings.align_patience_s:
        return _by_gravity(so_far, so_far.track.head.gain, declination, Basis.GUESS)
    return None


def _by_gravity(so_far: Alignment, gain: Vec3, declination: float, basis: Basis) -> Begin:
    """Begin as if ``gain`` pointed up, at rest or as a guess."""
    rests = basis == Basis.REST
    tilt, heading = (REST_TILT, REST_HEADING) if rests else (GUESSED_TILT, GUESSED_HEADING)
    down = scale(gain, -1.0 / norm(gain))
    east = cross(down, so_far.field)
    known = so_far.fields > 0 and norm(east) > LEAST_ANGLE * so_far.fields
    first = Pair(down, (0.0, 0.0, 1.0), 1.0)
    if known:
        q_nb = triad(first, Pair(unit(east), (-sin(declination), cos(declination), 0.0), 1.0))
    else:
        # Any level direction will do for north: the nose, or the right wing when the nose is up or down.
        nose: Vec3 = (1.0, 0.0, 0.0) if abs(down[0]) < 0.9 else (0.0, 1.0, 0.0)
        q_nb = triad(first, Pair(nose, (1.0, 0.0, 0.0), 1.0))
    variance = (heading if known else pi) ** 2
    attitude = ((tilt * tilt, 0.0, 0.0), (0.0, tilt * tilt, 0.0), (0.0, 0.0, variance))
    velocity = so_far.fixes[-1].v_ned if so_far.fixes else (0.0, 0.0, 0.0)
    sigma = REST_SPEED if rests else GUESSED_SPEED
    return Begin(q_mul(q_nb, so_far.turned), attitude, velocity, sigma, basis)


def _by_velocity(so_far: Alignment, fit: Fit, settings: FlightParameters) -> Begin:
    """Begin with the fitted attitude and the last fix, carried on to now."""
    last = so_far.fixes[-1]
    head = so_far.track.head
    x, y, z = add(last.v_ned, rotate(fit.q_nb, sub(head.gain, last.gain)))
    velocity = (x, y, z + settings.gravity * (head.t_ns - last.t_ns) * 1e-9)
    return Begin(q_mul(fit.q_nb, so_far.turned), fit.covariance, velocity, settings.velocity_sigma, Basis.VELOCITY)


def _doubted(fit: Fit | None, missed: float) -> Fit | None:
    """The fit, its covariance with what the gyro may have missed since the start."""
    return None if fit is None else Fit(fit.q_nb, add_diagonal(fit.covariance, missed))


def _good(fit: Fit, settings: FlightParameters) -> bool:
    """True when the attitude is known well enough to begin."""
    p = fit.covariance
    return p[0][0] + p[1][1] < settings.align_tilt**2 and p[2][2] < settings.align_heading**2


def _pairs(so_far: Alignment, declination: float, dip: float, settings: FlightParameters) -> list[Pair]:
    """The directions collected: of the velocity gained between fixes, and of the field. None before two fixes.

    The gain between the first fix and the last is the most certain; the links of a chain between them differ in
    direction when the vehicle turns, and so show what the first and the field leave open where they are parallel.
    """
    fixes = so_far.fixes
    base_ns = int(1e9 * MIN_BASE_S)
    if len(fixes) < 2 or fixes[-1].t_ns - fixes[0].t_ns < base_ns:
        return []
    pairs = _gained(fixes[0], fixes[-1], settings)
    link = fixes[0]
    for fix in fixes[1:]:
        if fix.t_ns - link.t_ns >= base_ns:
            pairs += _gained(link, fix, settings)
            link = fix
    if so_far.fields > 0 and isfinite(dip) and norm(so_far.field) > 0.0:
        world = (cos(dip) * cos(declination), cos(dip) * sin(declination), sin(dip))
        pairs.append(Pair(unit(so_far.field), world, FIELD_SIGMA**2))
    return pairs


def _gained(first: Fix, last: Fix, settings: FlightParameters) -> list[Pair]:
    """The velocity gained between two fixes, less gravity's share; none in free fall. An unknown vertical is up."""
    u = sub(last.gain, first.gain)
    x, y, z = sub(last.v_ned, first.v_ned)
    z -= settings.gravity * (last.t_ns - first.t_ns) * 1e-9
    length = norm(u)
    if not (first.vertical_known and last.vertical_known):
        z = -sqrt(max(0.0, length * length - x * x - y * y))
    if min(length, norm((x, y, z))) < LEAST_FORCE * (last.t_ns - first.t_ns) * 1e-9:
        return []
    return [Pair(unit(u), unit((x, y, z)), 2.0 * (GAIN_SIGMA / length) ** 2)]
