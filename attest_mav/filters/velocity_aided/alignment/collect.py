"""Alignment: what is collected for the first attitude, at rest or in the middle of a turn.

The readings are turned back, with the gyro, into the axes of the body at the start: there the specific force is
integrated, and the fields are summed. ``first_attitude`` makes an attitude of it.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, q_exp, q_mul, q_unit, rotate, scale, sub, unit
from attest_mav.filters.velocity_aided.aids.gnss_velocity import is_velocity, nominal_delay_s, time_of_validity
from attest_mav.filters.velocity_aided.aids.zero_motion import MAX_SPEED
from attest_mav.filters.velocity_aided.history import DeltaVelocityHistory, appended, empty_history, look_back
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import Reading
from attest_mav.types import Quat, Vec3, VelocitySample

STILL_RATE: Final = 0.05
"""rad/s: a rate above this is motion, not bias."""
STILL_ACCEL: Final = 0.3
"""m/s^2: distance of the specific force's length from g."""
MAX_FIXES: Final = 32


@mypyc_attr(acyclic=True)
class AlignmentFix:
    """A velocity fix during alignment. gain: u at its instant, in the start's axes, m/s; v_ned: m/s."""

    def __init__(self, source_ns: int, t_ns: int, delta_velocity: Vec3, v_ned: Vec3, vertical_known: bool) -> None:
        self.source_ns: Final = source_ns
        self.t_ns: Final = t_ns
        self.delta_velocity: Final = delta_velocity
        self.v_ned: Final = v_ned
        self.vertical_known: Final = vertical_known


@mypyc_attr(acyclic=True)
class Alignment:
    """What was collected so far.

    turned: from the body's axes now to those at the start. gyro, force: the last reading (rad/s) and specific force
    in the start's axes (m/s^2). track: of the gains u. fixes: old to new. mag: the last reading as received. field:
    sum of the unit fields in the start's axes, of ``fields`` readings. force_sum: integral of the force since the
    vehicle is still, m/s. still_s: for how long it is. waited_s: since the start. change: of the gyro between the last
    two samples, rad/s. missed: variance of the turns that hid between samples, rad^2 (``prediction`` has the reason).
    saturated: it began with a reading that shows nothing.
    """

    def __init__(
        self,
        q_start_body: Quat,
        gyro: Vec3,
        specific_force: Vec3,
        history: DeltaVelocityHistory,
        fixes: tuple[AlignmentFix, ...],
        last_mag: Vec3 | None,
        field_sum: Vec3,
        field_count: int,
        still_delta_velocity: Vec3,
        still_s: float,
        elapsed_s: float,
        gyro_change: Vec3,
        unseen_rotation_variance: float,
        began_saturated: bool,
    ) -> None:
        self.q_start_body: Final = q_start_body
        self.gyro: Final = gyro
        self.specific_force: Final = specific_force
        self.history: Final = history
        self.fixes: Final = fixes
        self.last_mag: Final = last_mag
        self.field_sum: Final = field_sum
        self.field_count: Final = field_count
        self.still_delta_velocity: Final = still_delta_velocity
        self.still_s: Final = still_s
        self.elapsed_s: Final = elapsed_s
        self.gyro_change: Final = gyro_change
        self.unseen_rotation_variance: Final = unseen_rotation_variance
        self.began_saturated: Final = began_saturated


def new_alignment(reading: Reading, t_ns: int) -> Alignment:
    """The alignment that begins at this sample; its axes are the body's."""
    zero, upright = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    return Alignment(
        upright,
        reading.gyro,
        reading.accel,
        empty_history(t_ns),
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


def accumulate(
    alignment: Alignment,
    reading: Reading,
    mag: Vec3 | None,
    field: Vec3 | None,
    fix: VelocitySample | None,
    under_way: bool,
    bias: Vec3,
    dt_s: float,
    t_ns: int,
    parameters: FlightParameters,
) -> Alignment:
    """The alignment after one more sample.

    mag: as received, gauss; field: as used, None unless it is new. under_way: known without a fix, by an air speed:
    a wing in a climb is as quiet as one at rest. bias: of the gyro, as far as it is known, rad/s.
    """
    rate = sub(scale(add(alignment.gyro, reading.gyro), 0.5), bias)
    q_start_body = q_unit(q_mul(alignment.q_start_body, q_exp(scale(rate, 0.5 * dt_s))))
    specific_force = rotate(q_start_body, reading.accel)
    delta_velocity = scale(add(alignment.specific_force, specific_force), 0.5 * dt_s)
    history = appended(alignment.history, t_ns, delta_velocity)
    field_sum = alignment.field_sum
    if field is not None:
        then = q_mul(q_start_body, q_exp(scale(rate, -0.5 * parameters.mag_delay_s)))
        field_sum = add(field_sum, rotate(then, unit(field)))
    moves = under_way if fix is None else norm(fix.v_ned) > MAX_SPEED
    still = not moves and _is_quiet(reading, bias, parameters)
    gyro_change = sub(reading.gyro, alignment.gyro)
    unseen_rotation_variance = (parameters.gyro_aliasing * norm(sub(gyro_change, alignment.gyro_change)) * dt_s) ** 2
    return Alignment(
        q_start_body,
        reading.gyro,
        specific_force,
        history,
        _with_fix(alignment.fixes, fix, history, parameters),
        alignment.last_mag if mag is None else mag,
        field_sum,
        alignment.field_count + (0 if field is None else 1),
        add(alignment.still_delta_velocity, delta_velocity) if still else (0.0, 0.0, 0.0),
        alignment.still_s + dt_s if still else 0.0,
        alignment.elapsed_s + dt_s,
        gyro_change,
        alignment.unseen_rotation_variance + unseen_rotation_variance,
        False,
    )


def _is_quiet(reading: Reading, bias: Vec3, parameters: FlightParameters) -> bool:
    """True for a reading as at rest."""
    return norm(sub(reading.gyro, bias)) < STILL_RATE and abs(norm(reading.accel) - parameters.gravity) < STILL_ACCEL


def _with_fix(
    fixes: tuple[AlignmentFix, ...],
    fix: VelocitySample | None,
    history: DeltaVelocityHistory,
    parameters: FlightParameters,
) -> tuple[AlignmentFix, ...]:
    """The fixes with a new one, if it is new and from after the start."""
    if fix is None or not is_velocity(fix):
        return fixes
    if fixes and fix.t_ns - fixes[-1].source_ns < int(1e9 * parameters.fix_spacing_s) - 1_000_000:
        return fixes
    t_ns = time_of_validity(fix, nominal_delay_s(fix, parameters), parameters)
    past = look_back(history, t_ns)
    if past is None:
        return fixes
    new = AlignmentFix(
        fix.t_ns, t_ns, sub(history.newest.delta_velocity, past.delta_velocity), fix.v_ned, fix.vertical_known
    )
    return (*fixes[-MAX_FIXES:], new)
