"""Alignment: the first attitude, at rest or in the middle of a turn.

In motion the readings are turned back, with the gyro, into the axes of the body at the start. There the integral of
the specific force is u, and the velocity fixes give the same vector in NED: C u = dv - g dt. Where the vertical
velocity is not measured its part follows from the length of u. The magnetic field gives the second direction.

At rest the mean specific force is gravity, and no fix is needed.
"""

from math import cos, isfinite, pi, sin, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, norm, q_exp, q_mul, q_unit, rotate, scale, sub, unit
from attest_mav.filters.flight.fixes import is_velocity, measured_at, usual_delay_s
from attest_mav.filters.flight.parameters import FlightParameters
from attest_mav.filters.flight.rest import MAX_SPEED
from attest_mav.filters.flight.strapdown import Reading
from attest_mav.filters.flight.track import Track, begun, longer, since
from attest_mav.filters.flight.wahba import LEAST_ANGLE, Fit, Pair, fitted, triad
from attest_mav.types import Mat3, Quat, Vec3, VelocitySample

MIN_BASE_S: Final = 0.45
"""Two fixes this far apart give a direction."""
LEAST_GAIN: Final = 1.0
"""m/s: an integral of the specific force shorter than this has no direction: free fall, or a dead accelerometer."""
GAIN_SIGMA: Final = 0.12
"""m/s: of the velocity gained between two fixes, in each axis."""
FIELD_SIGMA: Final = 0.03
"""Of the direction of the field, with what calibration leaves of the iron, rad."""
STILL_RATE: Final = 0.05
"""rad/s: a rate above this is motion, not bias."""
STILL_ACCEL: Final = 0.3
"""m/s^2: distance of the specific force's length from g."""
STILL_S: Final = 0.4
"""Still for this long, the vehicle aligns at rest."""
FIELD_PATIENCE_S: Final = 2.0
"""At rest it waits this long for a magnetometer."""
MAX_FIXES: Final = 32
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


@mypyc_attr(acyclic=True)
class Fix:
    """A velocity fix during alignment. gain: u at its instant, in the start's axes, m/s; v_ned: m/s."""

    def __init__(self, source_ns: int, t_ns: int, gain: Vec3, v_ned: Vec3, vertical_known: bool) -> None:
        self.source_ns: Final = source_ns
        self.t_ns: Final = t_ns
        self.gain: Final = gain
        self.v_ned: Final = v_ned
        self.vertical_known: Final = vertical_known


@mypyc_attr(acyclic=True)
class Alignment:
    """What was collected so far.

    turned: from the body's axes now to those at the start. gyro, force: the last reading (rad/s) and specific force
    in the start's axes (m/s^2). track: of the gains u. fixes: old to new. mag: the last reading as received. field:
    sum of the unit fields in the start's axes, of ``fields`` readings. force_sum: integral of the force since the
    vehicle is still, m/s. still_s: for how long it is. waited_s: since the start.
    """

    def __init__(
        self,
        turned: Quat,
        gyro: Vec3,
        force: Vec3,
        track: Track,
        fixes: tuple[Fix, ...],
        mag: Vec3 | None,
        field: Vec3,
        fields: int,
        force_sum: Vec3,
        still_s: float,
        waited_s: float,
    ) -> None:
        self.turned: Final = turned
        self.gyro: Final = gyro
        self.force: Final = force
        self.track: Final = track
        self.fixes: Final = fixes
        self.mag: Final = mag
        self.field: Final = field
        self.fields: Final = fields
        self.force_sum: Final = force_sum
        self.still_s: Final = still_s
        self.waited_s: Final = waited_s


@mypyc_attr(acyclic=True)
class Begin:
    """Where the filter begins: attitude and velocity (NED, m/s) now, and how well they are known.

    attitude: covariance of the attitude's error, rad^2. velocity_sigma: m/s. by_velocity: from fixes.
    """

    def __init__(self, q_nb: Quat, attitude: Mat3, velocity: Vec3, velocity_sigma: float, by_velocity: bool) -> None:
        self.q_nb: Final = q_nb
        self.attitude: Final = attitude
        self.velocity: Final = velocity
        self.velocity_sigma: Final = velocity_sigma
        self.by_velocity: Final = by_velocity


def started(reading: Reading, t_ns: int) -> Alignment:
    """The alignment that begins at this sample; its axes are the body's."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    return Alignment((1.0, 0.0, 0.0, 0.0), reading.gyro, reading.accel, begun(t_ns), (), None, zero, 0, zero, 0.0, 0.0)


def continued(
    so_far: Alignment,
    reading: Reading,
    mag: Vec3 | None,
    field: Vec3 | None,
    fix: VelocitySample | None,
    bias: Vec3,
    dt_s: float,
    t_ns: int,
    settings: FlightParameters,
) -> Alignment:
    """The alignment after one more sample.

    mag: as received, gauss; field: as used, None unless it is new. bias: of the gyro, as far as it is known, rad/s.
    """
    rate = sub(scale(add(so_far.gyro, reading.gyro), 0.5), bias)
    turned = q_unit(q_mul(so_far.turned, q_exp(scale(rate, 0.5 * dt_s))))
    force = rotate(turned, reading.accel)
    push = scale(add(so_far.force, force), 0.5 * dt_s)
    track = longer(so_far.track, t_ns, push)
    field_sum, fields = so_far.field, so_far.fields
    if field is not None:
        then = q_mul(turned, q_exp(scale(rate, -0.5 * settings.mag_delay_s)))
        field_sum, fields = add(field_sum, rotate(then, unit(field))), fields + 1
    still = norm(sub(reading.gyro, bias)) < STILL_RATE and abs(norm(reading.accel) - settings.gravity) < STILL_ACCEL
    if fix is not None and norm(fix.v_ned) > MAX_SPEED:
        still = False
    return Alignment(
        turned,
        reading.gyro,
        force,
        track,
        _with_fix(so_far.fixes, fix, track, settings),
        so_far.mag if mag is None else mag,
        field_sum,
        fields,
        add(so_far.force_sum, push) if still else (0.0, 0.0, 0.0),
        so_far.still_s + dt_s if still else 0.0,
        so_far.waited_s + dt_s,
    )


def _with_fix(
    fixes: tuple[Fix, ...], fix: VelocitySample | None, track: Track, settings: FlightParameters
) -> tuple[Fix, ...]:
    """The fixes with a new one, if it is new and from after the start."""
    if fix is None or not is_velocity(fix):
        return fixes
    if fixes and fix.t_ns - fixes[-1].source_ns < int(1e9 * settings.fix_spacing_s) - 1_000_000:
        return fixes
    t_ns = measured_at(fix, usual_delay_s(fix, settings), settings)
    past = since(track, t_ns)
    if past is None:
        return fixes
    new = Fix(fix.t_ns, t_ns, sub(track.head.gain, past.gain), fix.v_ned, fix.vertical_known)
    return (*fixes[-MAX_FIXES:], new)


def outcome(so_far: Alignment, declination: float, dip: float, settings: FlightParameters) -> Begin | None:
    """Where to begin, None while that is not known well enough. declination, dip: rad, dip NaN when it is not known."""
    if so_far.still_s >= STILL_S and (so_far.fields > 0 or so_far.waited_s > FIELD_PATIENCE_S):
        return _by_gravity(so_far, so_far.force_sum, declination, REST_TILT, REST_HEADING)
    pairs = _pairs(so_far, declination, dip, settings)
    fit = fitted(pairs) if pairs else None
    if fit is not None and (_good(fit, settings) or so_far.waited_s > settings.align_patience_s):
        return _by_velocity(so_far, fit, settings)
    if so_far.waited_s > settings.align_patience_s:
        return _by_gravity(so_far, so_far.track.head.gain, declination, GUESSED_TILT, GUESSED_HEADING)
    return None


def _by_gravity(so_far: Alignment, gain: Vec3, declination: float, tilt: float, heading: float) -> Begin | None:
    """Begin as if ``gain`` pointed up, None if it points nowhere. tilt, heading: sigmas, rad."""
    if not norm(gain) > LEAST_GAIN:
        return None
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
    sigma = REST_SPEED if tilt == REST_TILT else GUESSED_SPEED
    return Begin(q_mul(q_nb, so_far.turned), attitude, velocity, sigma, by_velocity=False)


def _by_velocity(so_far: Alignment, fit: Fit, settings: FlightParameters) -> Begin:
    """Begin with the fitted attitude and the last fix, carried on to now."""
    last = so_far.fixes[-1]
    head = so_far.track.head
    x, y, z = add(last.v_ned, rotate(fit.q_nb, sub(head.gain, last.gain)))
    velocity = (x, y, z + settings.gravity * (head.t_ns - last.t_ns) * 1e-9)
    return Begin(q_mul(fit.q_nb, so_far.turned), fit.covariance, velocity, settings.velocity_sigma, by_velocity=True)


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
    gained = [_gained(fixes[0], fixes[-1], settings)]
    link = fixes[0]
    for fix in fixes[1:]:
        if fix.t_ns - link.t_ns >= base_ns:
            gained.append(_gained(link, fix, settings))
            link = fix
    pairs = [pair for pair in gained if pair is not None]
    if so_far.fields > 0 and isfinite(dip) and norm(so_far.field) > 0.0:
        world = (cos(dip) * cos(declination), cos(dip) * sin(declination), sin(dip))
        pairs.append(Pair(unit(so_far.field), world, FIELD_SIGMA**2))
    return pairs


def _gained(first: Fix, last: Fix, settings: FlightParameters) -> Pair | None:
    """The velocity gained between two fixes, less gravity's share; None where that is too little for a direction.

    An unknown vertical part points up.
    """
    u = sub(last.gain, first.gain)
    x, y, z = sub(last.v_ned, first.v_ned)
    z -= settings.gravity * (last.t_ns - first.t_ns) * 1e-9
    length = norm(u)
    if not (first.vertical_known and last.vertical_known):
        z = -sqrt(max(0.0, length * length - x * x - y * y))
    if not (length > LEAST_GAIN and norm((x, y, z)) > LEAST_GAIN):
        return None
    return Pair(unit(u), unit((x, y, z)), 2.0 * (GAIN_SIGMA / length) ** 2)
