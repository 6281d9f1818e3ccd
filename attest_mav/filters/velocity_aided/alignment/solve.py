"""Alignment: the first attitude, solved from the collected readings once it is known well enough.

Each pair of fixes gives a direction twice: C u = dv - g dt, with u the integral of the specific force in the start's
axes. Where the vertical velocity is not measured its part follows from the length of u. The magnetic field gives
another direction, and Wahba's problem the attitude. At rest the mean specific force is gravity, and no fix is needed.
(Vector observations: Wahba, SIAM Review 7, 1965; levelling: Groves, Principles of GNSS, Inertial, and Multisensor
Integrated Navigation Systems, 2nd ed., section 5.6.)
"""

from enum import IntEnum
from math import cos, isfinite, pi, sin, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, norm, q_mul, rotate, scale, sub, unit
from attest_mav.filters.velocity_aided.alignment.collect import Alignment, AlignmentFix
from attest_mav.filters.velocity_aided.alignment.wahba import LEAST_ANGLE, AttitudeFit, VectorPair, solve_wahba, triad
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import add_diagonal
from attest_mav.record import Record
from attest_mav.types import Mat3, Quat, Vec3

MIN_BASE_S: Final = 0.45
"""Two fixes this far apart give a direction, s."""
LEAST_FORCE: Final = 1.0
"""m/s^2: a mean specific force below this (gravity's is ten) has no direction: free fall, or a dead accelerometer."""
GAIN_SIGMA: Final = 0.12
"""m/s: of the velocity gained between two fixes, in each axis."""
FIELD_SIGMA: Final = 0.03
"""rad: of the direction of the field, with the hard iron that calibration leaves."""
STILL_S: Final = 0.4
"""Still for this long, the vehicle aligns at rest, s."""
FIELD_PATIENCE_S: Final = 2.0
"""At rest the alignment waits this long for a magnetometer, s."""
STATIONARY_TILT: Final = 0.03
"""rad: of a vehicle at rest, with what the accelerometer's bias and a rocking hull do to it."""
STATIONARY_HEADING: Final = 0.35
"""rad: wide, so that the first magnetometer measurement sets it, together with the iron that it may be due to."""
STATIONARY_SPEED: Final = 0.3
"""m/s: 1-sigma of the velocity of a vehicle at rest."""
ASSUMED_GRAVITY_TILT: Final = 0.35
"""rad: of an attitude that takes acceleration for gravity, in an unknown manoeuvre."""
ASSUMED_GRAVITY_HEADING: Final = 0.7
"""rad: the same for its heading by the field."""
ASSUMED_GRAVITY_SPEED: Final = 10.0
"""m/s: the same for its velocity."""


class AlignmentMethod(IntEnum):
    """The readings that a first attitude was made of."""

    STATIONARY = 0
    """Gravity, of a vehicle at rest."""
    VELOCITY = 1
    """Velocity fixes."""
    ASSUMED_GRAVITY = 2
    """Acceleration, taken for gravity."""


@mypyc_attr(acyclic=True)
class InitialState(Record):
    """Where navigation begins."""

    def __init__(
        self, q_nb: Quat, attitude: Mat3, velocity: Vec3, velocity_sigma: float, method: AlignmentMethod
    ) -> None:
        self.q_nb: Final = q_nb
        """Body to NED, now."""
        self.attitude: Final = attitude
        """Covariance of its error as a rotation in NED, rad^2."""
        self.velocity: Final = velocity
        """NED, now, m/s."""
        self.velocity_sigma: Final = velocity_sigma
        """1-sigma of each component, m/s."""
        self.method: Final = method
        """The measurements that the attitude was solved from."""


def solve_alignment(
    alignment: Alignment, declination: float, inclination: float, parameters: FlightParameters
) -> InitialState | None:
    """Where to begin, None while that is not known well enough.

    declination, inclination: of the field, rad; inclination NaN when it is not known.
    """
    if alignment.still.duration_s >= STILL_S and (alignment.field.count > 0 or alignment.elapsed_s > FIELD_PATIENCE_S):
        return _by_gravity(alignment, alignment.still.delta_velocity, declination, AlignmentMethod.STATIONARY)
    pairs = _vector_pairs(alignment, declination, inclination, parameters)
    fit = _with_unseen_rotation(solve_wahba(pairs), alignment.rotation.unseen_variance) if pairs else None
    if fit is not None and (_is_good_enough(fit, parameters) or alignment.elapsed_s > parameters.align_patience_s):
        return _by_velocity(alignment, fit, parameters)
    force_felt = norm(alignment.history.newest.delta_velocity) > LEAST_FORCE * alignment.elapsed_s
    if force_felt and alignment.elapsed_s > parameters.align_patience_s:
        return _by_gravity(
            alignment, alignment.history.newest.delta_velocity, declination, AlignmentMethod.ASSUMED_GRAVITY
        )
    return None


def _by_gravity(
    alignment: Alignment, delta_velocity: Vec3, declination: float, method: AlignmentMethod
) -> InitialState:
    """Begin as if ``delta_velocity`` (start's axes, m/s) pointed up: at rest, or as a guess."""
    stationary = method == AlignmentMethod.STATIONARY
    tilt, heading = (
        (STATIONARY_TILT, STATIONARY_HEADING) if stationary else (ASSUMED_GRAVITY_TILT, ASSUMED_GRAVITY_HEADING)
    )
    down = scale(delta_velocity, -1.0 / norm(delta_velocity))
    east = cross(down, alignment.field.total)
    known = alignment.field.count > 0 and norm(east) > LEAST_ANGLE * alignment.field.count
    first = VectorPair(down, (0.0, 0.0, 1.0), 1.0)
    if known:
        q_nb = triad(first, VectorPair(unit(east), (-sin(declination), cos(declination), 0.0), 1.0))
    else:
        # Any level direction will do for north: the nose, or the right wing when the nose is up or down.
        nose: Vec3 = (1.0, 0.0, 0.0) if abs(down[0]) < 0.9 else (0.0, 1.0, 0.0)
        q_nb = triad(first, VectorPair(nose, (1.0, 0.0, 0.0), 1.0))
    variance = (heading if known else pi) ** 2
    attitude = ((tilt * tilt, 0.0, 0.0), (0.0, tilt * tilt, 0.0), (0.0, 0.0, variance))
    velocity = alignment.fixes[-1].v_ned if alignment.fixes else (0.0, 0.0, 0.0)
    sigma = STATIONARY_SPEED if stationary else ASSUMED_GRAVITY_SPEED
    return InitialState(q_mul(q_nb, alignment.rotation.q_start_body), attitude, velocity, sigma, method)


def _by_velocity(alignment: Alignment, fit: AttitudeFit, parameters: FlightParameters) -> InitialState:
    """Begin with the fitted attitude and the last fix, carried on to now."""
    last = alignment.fixes[-1]
    newest = alignment.history.newest
    x, y, z = add(last.v_ned, rotate(fit.q_nb, sub(newest.delta_velocity, last.delta_velocity)))
    velocity = (x, y, z + parameters.gravity * (newest.t_ns - last.t_ns) * 1e-9)
    return InitialState(
        q_mul(fit.q_nb, alignment.rotation.q_start_body),
        fit.covariance,
        velocity,
        parameters.velocity_sigma,
        AlignmentMethod.VELOCITY,
    )


def _with_unseen_rotation(fit: AttitudeFit | None, unseen_rotation_variance: float) -> AttitudeFit | None:
    """The fit, its covariance with the rotation that the gyro may have missed since the start, rad^2."""
    return None if fit is None else AttitudeFit(fit.q_nb, add_diagonal(fit.covariance, unseen_rotation_variance))


def _is_good_enough(fit: AttitudeFit, parameters: FlightParameters) -> bool:
    """True when the attitude is known well enough to begin."""
    p = fit.covariance
    return p[0][0] + p[1][1] < parameters.align_tilt**2 and p[2][2] < parameters.align_heading**2


def _vector_pairs(
    alignment: Alignment, declination: float, inclination: float, parameters: FlightParameters
) -> list[VectorPair]:
    """The directions collected: of the velocity gained between fixes, and of the field. None before two fixes.

    The gain between the first fix and the last is the most certain; the links of a chain between them differ in
    direction when the vehicle turns, and so show what the first and the field leave open where they are parallel.
    """
    fixes = alignment.fixes
    base_ns = int(1e9 * MIN_BASE_S)
    if len(fixes) < 2 or fixes[-1].t_ns - fixes[0].t_ns < base_ns:
        return []
    pairs = _delta_velocity_pairs(fixes[0], fixes[-1], parameters)
    link = fixes[0]
    for fix in fixes[1:]:
        if fix.t_ns - link.t_ns >= base_ns:
            pairs += _delta_velocity_pairs(link, fix, parameters)
            link = fix
    if alignment.field.count > 0 and isfinite(inclination) and norm(alignment.field.total) > 0.0:
        world = (cos(inclination) * cos(declination), cos(inclination) * sin(declination), sin(inclination))
        pairs.append(VectorPair(unit(alignment.field.total), world, FIELD_SIGMA**2))
    return pairs


def _delta_velocity_pairs(first: AlignmentFix, last: AlignmentFix, parameters: FlightParameters) -> list[VectorPair]:
    """The velocity gained between two fixes, less gravity's share; none in free fall. An unknown vertical is up."""
    u = sub(last.delta_velocity, first.delta_velocity)
    x, y, z = sub(last.v_ned, first.v_ned)
    z -= parameters.gravity * (last.t_ns - first.t_ns) * 1e-9
    length = norm(u)
    if not (first.vertical_known and last.vertical_known):
        z = -sqrt(max(0.0, length * length - x * x - y * y))
    if min(length, norm((x, y, z))) < LEAST_FORCE * (last.t_ns - first.t_ns) * 1e-9:
        return []
    variance = 2.0 * GAIN_SIGMA**2 + last.unseen_variance - first.unseen_variance
    return [VectorPair(unit(u), unit((x, y, z)), variance / (length * length))]
