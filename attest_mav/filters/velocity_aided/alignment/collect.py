"""Alignment: collection of the readings for the first attitude, at rest or in the middle of a turn.

The readings are turned back, with the gyro, into the axes of the body at the start: there the specific force is
integrated, and the fields are summed. ``solve`` makes an attitude of them. (In-motion alignment against the velocity:
Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 5.6 and 15.2; the
frame that stays with the start is that of optimisation-based alignment, Wu and Pan, IEEE Trans. AES 49, 2013.)
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, q_exp, q_mul, q_unit, rotate, scale, sub, unit
from attest_mav.filters.base import FilterInputs
from attest_mav.filters.stationary import StillnessLimits, is_unaccelerated
from attest_mav.filters.velocity_aided.aids.airspeed import has_airspeed_of_flight
from attest_mav.filters.velocity_aided.aids.gnss_velocity import time_of_validity
from attest_mav.filters.velocity_aided.aids.zero_motion import MAX_SPEED
from attest_mav.filters.velocity_aided.history import DeltaVelocityHistory, appended, empty_history, look_back
from attest_mav.filters.velocity_aided.lags import nominal_fix_lag_s, nominal_mag_lag_s
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import Reading, field_of
from attest_mav.low_pass import aliased_share
from attest_mav.plausible import is_velocity
from attest_mav.record import Record
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import Quat, Vec3

LIMITS: Final = StillnessLimits(rate=0.05, accel=0.3)
"""A vehicle at rest shows no more than this: there are no means yet to compare with."""
MAX_FIXES: Final = 32
"""Fixes that are kept, the newest."""


@mypyc_attr(acyclic=True)
class AlignmentFix(Record):
    """A velocity fix during alignment."""

    def __init__(
        self,
        message_ns: int,
        t_ns: int,
        delta_velocity: Vec3,
        v_ned: Vec3,
        vertical_known: bool,
        unseen_variance: float,
    ) -> None:
        self.message_ns: Final = message_ns
        """Time that its message names, ns."""
        self.t_ns: Final = t_ns
        """Time that it belongs to, ns."""
        self.delta_velocity: Final = delta_velocity
        """Integral of the specific force up to then, in the start's axes, m/s."""
        self.v_ned: Final = v_ned
        """m/s."""
        self.vertical_known: Final = vertical_known
        """False where the vertical velocity was not measured."""
        self.unseen_variance: Final = unseen_variance
        """Variance of the velocity that hid between samples since the start, (m/s)^2 in each axis."""


@mypyc_attr(acyclic=True)
class RotationSinceStart(Record):
    """The integrated gyro."""

    def __init__(self, q_start_body: Quat, gyro: Vec3, gyro_change: Vec3, unseen_variance: float) -> None:
        self.q_start_body: Final = q_start_body
        """From the body's axes now to those at the start."""
        self.gyro: Final = gyro
        """The last reading, rad/s."""
        self.gyro_change: Final = gyro_change
        """That minus the one before, rad/s."""
        self.unseen_variance: Final = unseen_variance
        """Variance of the rotations that hid between samples, rad^2, by the second differences as in ``prediction``."""


@mypyc_attr(acyclic=True)
class ForceSinceStart(Record):
    """The accelerometer's last reading, and how far its samples can be trusted."""

    def __init__(self, force: Vec3, accel: Vec3, accel_change: Vec3, unseen_variance: float) -> None:
        self.force: Final = force
        """The last reading in the start's axes, m/s^2."""
        self.accel: Final = accel
        """The same in the body's axes."""
        self.accel_change: Final = accel_change
        """That minus the one before, m/s^2."""
        self.unseen_variance: Final = unseen_variance
        """Variance of the velocity that hid between samples, (m/s)^2, by the second differences as in ``prediction``:
        in turbulence and vibration it is most of the error."""


@mypyc_attr(acyclic=True)
class FieldSum(Record):
    """The magnetometer's readings."""

    def __init__(self, last_reading: Vec3 | None, total: Vec3, count: int) -> None:
        self.last_reading: Final = last_reading
        """As received, gauss; None before the first."""
        self.total: Final = total
        """Sum of the unit fields in the start's axes."""
        self.count: Final = count
        """How many they are."""


@mypyc_attr(acyclic=True)
class StillPeriod(Record):
    """The time without motion up to now."""

    def __init__(self, delta_velocity: Vec3, duration_s: float) -> None:
        self.delta_velocity: Final = delta_velocity
        """Integral of the specific force in it, in the start's axes, m/s."""
        self.duration_s: Final = duration_s
        """s; 0 while the vehicle moves."""


@mypyc_attr(acyclic=True)
class Alignment(Record):
    """Everything collected so far."""

    def __init__(
        self,
        rotation: RotationSinceStart,
        force: ForceSinceStart,
        history: DeltaVelocityHistory,
        fixes: tuple[AlignmentFix, ...],
        field: FieldSum,
        still: StillPeriod,
        elapsed_s: float,
        began_saturated: bool,
    ) -> None:
        self.rotation: Final = rotation
        """Of the body since the start."""
        self.force: Final = force
        """Of the accelerometer since the start."""
        self.history: Final = history
        """Of the integrated specific force, in the start's axes."""
        self.fixes: Final = fixes
        """Velocity fixes, old to new."""
        self.field: Final = field
        """Magnetometer readings."""
        self.still: Final = still
        """The time without motion up to now."""
        self.elapsed_s: Final = elapsed_s
        """Time since the start, s."""
        self.began_saturated: Final = began_saturated
        """The first reading shows nothing, so the next one starts anew."""


def new_alignment(reading: Reading, t_ns: int) -> Alignment:
    """The alignment that starts at this sample; its axes are the body's."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    rotation = RotationSinceStart((1.0, 0.0, 0.0, 0.0), reading.gyro, zero, 0.0)
    still = StillPeriod(zero, 0.0)
    history = empty_history(t_ns)
    force = ForceSinceStart(reading.accel, reading.accel, zero, 0.0)
    return Alignment(rotation, force, history, (), FieldSum(None, zero, 0), still, 0.0, reading.saturated)


def accumulate(
    alignment: Alignment,
    reading: Reading,
    sample: ImuSample,
    inputs: FilterInputs,
    bias: Vec3,
    dt_s: float,
    parameters: FlightParameters,
) -> Alignment:
    """The alignment after one more sample. bias: of the gyro, as far as it is known, rad/s."""
    rate = sub(scale(add(alignment.rotation.gyro, reading.gyro), 0.5), bias)
    rotation = _rotated(alignment.rotation, reading, rate, dt_s, parameters)
    force = _felt(alignment.force, reading, rotation.q_start_body, dt_s, parameters)
    delta_velocity = scale(add(alignment.force.force, force.force), 0.5 * dt_s)
    history = appended(alignment.history, sample.t_ns, delta_velocity)
    is_still = not _moves(inputs) and is_unaccelerated(
        sub(reading.gyro, bias), reading.accel, parameters.gravity, LIMITS
    )
    still = alignment.still
    return Alignment(
        rotation,
        force,
        history,
        _with_fix(alignment, inputs.velocity, history, parameters),
        _with_field(alignment.field, sample, rotation.q_start_body, scale(rate, -0.5 * nominal_mag_lag_s(parameters))),
        StillPeriod(add(still.delta_velocity, delta_velocity), still.duration_s + dt_s)
        if is_still
        else StillPeriod((0.0, 0.0, 0.0), 0.0),
        alignment.elapsed_s + dt_s,
        began_saturated=False,
    )


def _rotated(
    before: RotationSinceStart, reading: Reading, rate: Vec3, dt_s: float, parameters: FlightParameters
) -> RotationSinceStart:
    """The rotation after a step at this mean rate, rad/s."""
    gyro_change = sub(reading.gyro, before.gyro)
    second_difference = norm(sub(gyro_change, before.gyro_change))
    aliasing = parameters.gyro_aliasing * aliased_share(parameters.low_pass_hz, dt_s)
    return RotationSinceStart(
        q_unit(q_mul(before.q_start_body, q_exp(scale(rate, 0.5 * dt_s)))),
        reading.gyro,
        gyro_change,
        before.unseen_variance + (aliasing * second_difference * dt_s) ** 2,
    )


def _felt(
    before: ForceSinceStart, reading: Reading, q_start_body: Quat, dt_s: float, parameters: FlightParameters
) -> ForceSinceStart:
    """The specific force after a step."""
    accel_change = sub(reading.accel, before.accel)
    second_difference = norm(sub(accel_change, before.accel_change))
    return ForceSinceStart(
        rotate(q_start_body, reading.accel),
        reading.accel,
        accel_change,
        before.unseen_variance + (parameters.accel_aliasing * second_difference * dt_s) ** 2,
    )


def _moves(inputs: FilterInputs) -> bool:
    """True when the vehicle is known to move: by a fix, or by an airspeed, for a climb is as quiet as standing."""
    fix = inputs.velocity
    if fix is None:
        return not inputs.zero_mean_velocity and has_airspeed_of_flight(inputs)
    return norm(fix.v_ned) > MAX_SPEED


def _with_field(before: FieldSum, sample: ImuSample, q_start_body: Quat, back: Vec3) -> FieldSum:
    """The fields with the sample's, if it is a new one. back: half the rotation vector back to its time, rad."""
    if sample.mag is None or sample.mag == before.last_reading:
        return before
    field = field_of(sample)
    if field is None:
        return FieldSum(sample.mag, before.total, before.count)
    direction = rotate(q_mul(q_start_body, q_exp(back)), unit(field))
    return FieldSum(sample.mag, add(before.total, direction), before.count + 1)


def _with_fix(
    before: Alignment, fix: VelocitySample | None, history: DeltaVelocityHistory, parameters: FlightParameters
) -> tuple[AlignmentFix, ...]:
    """The fixes with a new one, if it is new and from after the start."""
    fixes = before.fixes
    if fix is None or not is_velocity(fix.v_ned):
        return fixes
    if fixes and fix.t_ns - fixes[-1].message_ns < int(1e9 * parameters.fix_spacing_s) - 1_000_000:
        return fixes
    t_ns = time_of_validity(fix, nominal_fix_lag_s(fix.origin, parameters))
    past = look_back(history, t_ns)
    if past is None:
        return fixes
    gained = sub(history.newest.delta_velocity, past.delta_velocity)
    unseen = before.force.unseen_variance
    return (*fixes[-MAX_FIXES:], AlignmentFix(fix.t_ns, t_ns, gained, fix.v_ned, fix.vertical_known, unseen))
