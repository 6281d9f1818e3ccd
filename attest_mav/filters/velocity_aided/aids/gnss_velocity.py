"""Velocity fixes: delayed, of unknown quality, sometimes wrong.

A fix is compared with the velocity of the instant it belongs to. Its variance follows the innovations: twice their
rms, so that errors that last (which innovations do not show) are allowed for. A fix outside the gate is not thrown
away: its variance is inflated until it lies on the gate, the equivalent covariance of paper 2 (eqs. (15), (16)). After
a gap, when the state's own variance is large, that changes nothing and the fix is believed; a hard gate would lock out.
"""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, dot, norm
from attest_mav.filters.velocity_aided.covariance import Row
from attest_mav.filters.velocity_aided.history import Since, Track, since
from attest_mav.filters.velocity_aided.nav_state import STILL_ACCEL, Motion, reach_of, shown, taken, with_fix_delay
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.types import Vec3, VelocityOrigin, VelocitySample

POWER_SHARE: Final = 0.05
"""Share of a new innovation in their remembered mean square."""
POWER_STEP: Final = 4.0
"""One innovation counts for at most this many times the mean square."""
NOISE_FACTOR: Final = 2.0
"""The noise of a fix as a multiple of the innovations' rms."""
LONG_AGO_S: Final = 1e9
MAX_VELOCITY: Final = 1e4
"""m/s: a fix that reports this much is not read (NaN and infinity fail the same test)."""
NIS_SHARE: Final = 0.1
"""Share of a new fix in the mean normalised innovation squared: at 5 Hz a memory of 2 s."""


@mypyc_attr(acyclic=True)
class Fixes:
    """What is remembered of the fixes, and the record of the last one.

    source: message of the last one used, "" before the first. t_ns: its time. lost_s: time since. power: mean square
    innovation, (m/s)^2. innovation: m/s, NED, each axis before its own correction. nis: its normalised square, mean of
    the axes, without inflation. mean_nis: its remembered mean, in which none counts for more than the gate.
    """

    def __init__(
        self, source: str, t_ns: int, lost_s: float, power: float, mean_nis: float, innovation: Vec3, nis: float
    ) -> None:
        self.source: Final = source
        self.t_ns: Final = t_ns
        self.lost_s: Final = lost_s
        self.power: Final = power
        self.mean_nis: Final = mean_nis
        self.innovation: Final = innovation
        self.nis: Final = nis


def unit_axis(axis: int) -> Vec3:
    """The unit vector along axis 0, 1 or 2."""
    return (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)


def no_fixes(settings: FlightParameters) -> Fixes:
    """Before the first one."""
    power = (settings.velocity_sigma / NOISE_FACTOR) ** 2
    return Fixes("", -1, LONG_AGO_S, power, 0.0, (0.0, 0.0, 0.0), 0.0)


def resumed(fixes: Fixes, aligned_by_them: bool) -> Fixes:
    """The memory at a start. The fixes that an alignment was made of are recent, those from before a gap are not."""
    lost_s = 0.0 if aligned_by_them else LONG_AGO_S
    return Fixes(fixes.source, fixes.t_ns, lost_s, fixes.power, 0.0, (0.0, 0.0, 0.0), 0.0)


def waited(fixes: Fixes, dt_s: float) -> Fixes:
    """The same memory, a step later."""
    return Fixes(
        fixes.source, fixes.t_ns, fixes.lost_s + dt_s, fixes.power, fixes.mean_nis, fixes.innovation, fixes.nis
    )


def measured_at(fix: VelocitySample, delay_s: float, settings: FlightParameters) -> int:
    """The instant of the fix on the clock of the low-passed sensors, ns: they lag the motion too."""
    return fix.t_ns - int(1e9 * (delay_s - low_pass_delay_s(settings)))


def usual_delay_s(fix: VelocitySample, settings: FlightParameters) -> float:
    """Delay of such fixes before it is estimated, s."""
    return settings.fix_delay_s if fix.origin == VelocityOrigin.RECEIVER else settings.own_delay_s


def usual_delay_sigma(fix: VelocitySample, settings: FlightParameters) -> float:
    """How well that is known, s."""
    return settings.fix_delay_sigma if fix.origin == VelocityOrigin.RECEIVER else settings.own_delay_sigma


def low_pass_delay_s(settings: FlightParameters) -> float:
    """Group delay of the autopilot's second-order Butterworth low-pass, s: sqrt(2) / (2 pi f)."""
    return 0.2250790790392765 / settings.low_pass_hz if settings.low_pass_hz > 0.0 else 0.0


def is_velocity(fix: VelocitySample) -> bool:
    """True when its numbers can be a velocity."""
    return norm(fix.v_ned) < MAX_VELOCITY


def due(fixes: Fixes, fix: VelocitySample | None, settings: FlightParameters) -> bool:
    """True when the fix is one, has not been used, and is far enough from the one before."""
    if fix is None or not is_velocity(fix) or fix.t_ns == fixes.t_ns:
        return False
    # A clock that went back is a new one.
    apart = (fix.t_ns - fixes.t_ns) * 1e-9
    return fix.source != fixes.source or apart < 0.0 or apart > settings.fix_spacing_s - 1e-3


def fixed(
    motion: Motion, track: Track, fixes: Fixes, fix: VelocitySample, teaches: bool, settings: FlightParameters
) -> tuple[Motion, Fixes]:
    """Motion and memory after a fix that is due. One from before the history corrects nothing.

    teaches: it may tell something of the sensors.
    """
    if fix.source != fixes.source:
        motion = with_fix_delay(motion, usual_delay_s(fix, settings), usual_delay_sigma(fix, settings))
    past = since(track, measured_at(fix, motion.delays[1], settings))
    if past is None:
        return motion, fixes
    sigma = clamp(NOISE_FACTOR * sqrt(fixes.power), settings.velocity_floor, settings.velocity_ceiling)
    accel = shown((past.force[0], past.force[1], past.force[2] + settings.gravity), STILL_ACCEL)
    jitter = settings.fix_jitter_s**2 * dot(accel, accel)
    variance = sigma * sigma + jitter
    # A wrong attitude must not excuse itself with the innovations that it makes.
    trusted = min(sigma, settings.velocity_sigma) ** 2 + jitter
    count = 3 if fix.vertical_known else 2
    innovation = [0.0, 0.0, 0.0]
    nis = 0.0
    for axis in range(count):
        row = velocity_row(motion, past, accel, fix, axis, settings)
        seen = reach_of(motion, row)
        innovation[axis] = row.residual
        nis += row.residual**2 / (seen.variance + trusted) / count
        least = (row.residual / settings.velocity_gate) ** 2 - seen.variance
        motion = taken(motion, row, seen, max(variance, least), teaches)
    square = (innovation[0] ** 2 + innovation[1] ** 2 + innovation[2] ** 2) / count
    power = fixes.power + POWER_SHARE * (min(square, POWER_STEP * fixes.power + 1e-6) - fixes.power)
    # However wild, one fix is one contradiction: it takes several in a row to give the attitude up.
    mean_nis = fixes.mean_nis + NIS_SHARE * (min(nis, settings.velocity_gate**2) - fixes.mean_nis)
    return motion, Fixes(fix.source, fix.t_ns, 0.0, power, mean_nis, (innovation[0], innovation[1], innovation[2]), nis)


def velocity_row(
    motion: Motion, past: Since, accel: Vec3, fix: VelocitySample, axis: int, settings: FlightParameters
) -> Row:
    """One axis of a fix. ``accel``: of the vehicle at the time of the fix, NED, m/s^2.

    The velocity then is v - u - g age, with u the gain of specific force since; so its error is dv + [u]x theta, and
    a delay that is longer by dd moves the instant back along the acceleration.
    """
    gained = past.gain[axis] + (settings.gravity * past.age_s if axis == 2 else 0.0)
    span_s = max(past.age_s, 0.0)
    x, y, z = shown((past.gain[0], past.gain[1], past.gain[2] + settings.gravity * span_s), STILL_ACCEL * span_s)
    z -= settings.gravity * span_s
    tilt: Vec3 = (0.0, -z, y) if axis == 0 else (z, 0.0, -x) if axis == 1 else (-y, x, 0.0)
    residual = fix.v_ned[axis] - (motion.velocity[axis] - gained)
    return Row(residual, t=tilt, v=unit_axis(axis), d=(0.0, -accel[axis], 0.0))
