"""Alignment: what is collected for the first attitude, at rest or in the middle of a turn.

The readings are turned back, with the gyro, into the axes of the body at the start: there the specific force is
integrated, and the fields are summed. ``first_attitude`` makes an attitude of it.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, q_exp, q_mul, q_unit, rotate, scale, sub, unit
from attest_mav.filters.velocity_aided.aids.gnss_velocity import is_velocity, measured_at, usual_delay_s
from attest_mav.filters.velocity_aided.aids.zero_motion import MAX_SPEED
from attest_mav.filters.velocity_aided.history import Track, begun, longer, since
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import Reading
from attest_mav.types import Quat, Vec3, VelocitySample

STILL_RATE: Final = 0.05
"""rad/s: a rate above this is motion, not bias."""
STILL_ACCEL: Final = 0.3
"""m/s^2: distance of the specific force's length from g."""
MAX_FIXES: Final = 32


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
    vehicle is still, m/s. still_s: for how long it is. waited_s: since the start. change: of the gyro between the last
    two samples, rad/s. missed: variance of the turns that hid between samples, rad^2 (``strapdown`` has the reason).
    saturated: it began with a reading that shows nothing.
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
        change: Vec3,
        missed: float,
        saturated: bool,
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
        self.change: Final = change
        self.missed: Final = missed
        self.saturated: Final = saturated


def started(reading: Reading, t_ns: int) -> Alignment:
    """The alignment that begins at this sample; its axes are the body's."""
    zero, upright = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    return Alignment(
        upright,
        reading.gyro,
        reading.accel,
        begun(t_ns),
        (),
        None,
        zero,
        0,
        zero,
        0.0,
        0.0,
        zero,
        0.0,
        reading.saturated,
    )


def continued(
    so_far: Alignment,
    reading: Reading,
    mag: Vec3 | None,
    field: Vec3 | None,
    fix: VelocitySample | None,
    under_way: bool,
    bias: Vec3,
    dt_s: float,
    t_ns: int,
    settings: FlightParameters,
) -> Alignment:
    """The alignment after one more sample.

    mag: as received, gauss; field: as used, None unless it is new. under_way: known without a fix, by an air speed:
    a wing in a climb is as quiet as one at rest. bias: of the gyro, as far as it is known, rad/s.
    """
    rate = sub(scale(add(so_far.gyro, reading.gyro), 0.5), bias)
    turned = q_unit(q_mul(so_far.turned, q_exp(scale(rate, 0.5 * dt_s))))
    force = rotate(turned, reading.accel)
    push = scale(add(so_far.force, force), 0.5 * dt_s)
    track = longer(so_far.track, t_ns, push)
    field_sum = so_far.field
    if field is not None:
        then = q_mul(turned, q_exp(scale(rate, -0.5 * settings.mag_delay_s)))
        field_sum = add(field_sum, rotate(then, unit(field)))
    moves = under_way if fix is None else norm(fix.v_ned) > MAX_SPEED
    still = not moves and _is_quiet(reading, bias, settings)
    change = sub(reading.gyro, so_far.gyro)
    missed = (settings.gyro_aliasing * norm(sub(change, so_far.change)) * dt_s) ** 2
    return Alignment(
        turned,
        reading.gyro,
        force,
        track,
        _with_fix(so_far.fixes, fix, track, settings),
        so_far.mag if mag is None else mag,
        field_sum,
        so_far.fields + (0 if field is None else 1),
        add(so_far.force_sum, push) if still else (0.0, 0.0, 0.0),
        so_far.still_s + dt_s if still else 0.0,
        so_far.waited_s + dt_s,
        change,
        so_far.missed + missed,
        False,
    )


def _is_quiet(reading: Reading, bias: Vec3, settings: FlightParameters) -> bool:
    """True for a reading as at rest."""
    return norm(sub(reading.gyro, bias)) < STILL_RATE and abs(norm(reading.accel) - settings.gravity) < STILL_ACCEL


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
