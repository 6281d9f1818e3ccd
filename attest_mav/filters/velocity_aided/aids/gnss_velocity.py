"""Velocity fixes: delayed, of unknown quality, sometimes wrong.

A fix is compared with the velocity of the instant it belongs to. Its variance follows the innovations: twice their
rms, so that errors that last (which innovations do not show) are allowed for. A fix outside the gate is not thrown
away: its variance is inflated until it lies on the gate, the equivalent covariance of paper 2 (eqs. (15), (16)). After
a gap, when the state's own variance is large, that changes nothing and the fix is believed; a hard gate would lock out.
"""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, dot, norm, unit_axis
from attest_mav.filters.velocity_aided.covariance import Measurement
from attest_mav.filters.velocity_aided.history import DeltaVelocityHistory, Lookback, look_back
from attest_mav.filters.velocity_aided.nav_state import (
    DEADBAND_ACCEL,
    NavigationState,
    cross_covariance_of,
    deadband,
    fuse,
    with_fix_delay,
)
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
class GnssVelocity:
    """What is remembered of the fixes, and the record of the last one.

    source: message of the last one used, "" before the first. t_ns: its time. lost_s: time since. power: mean square
    innovation, (m/s)^2. innovation: m/s, NED, each axis before its own correction. nis: its normalised square, mean of
    the axes, without inflation. mean_nis: its remembered mean, in which none counts for more than the gate.
    """

    def __init__(
        self,
        source: str,
        t_ns: int,
        since_fused_s: float,
        innovation_power: float,
        mean_nis: float,
        innovation: Vec3,
        nis: float,
    ) -> None:
        self.source: Final = source
        self.t_ns: Final = t_ns
        self.since_fused_s: Final = since_fused_s
        self.innovation_power: Final = innovation_power
        self.mean_nis: Final = mean_nis
        self.innovation: Final = innovation
        self.nis: Final = nis


def initial_gnss_velocity(parameters: FlightParameters) -> GnssVelocity:
    """Before the first one."""
    innovation_power = (parameters.velocity_sigma / NOISE_FACTOR) ** 2
    return GnssVelocity("", -1, LONG_AGO_S, innovation_power, 0.0, (0.0, 0.0, 0.0), 0.0)


def after_reset(gnss: GnssVelocity, aligned_by_them: bool) -> GnssVelocity:
    """The memory at a start. The fixes that an alignment was made of are recent, those from before a gap are not."""
    since_fused_s = 0.0 if aligned_by_them else LONG_AGO_S
    return GnssVelocity(gnss.source, gnss.t_ns, since_fused_s, gnss.innovation_power, 0.0, (0.0, 0.0, 0.0), 0.0)


def aged(gnss: GnssVelocity, dt_s: float) -> GnssVelocity:
    """The same memory, a step later."""
    return GnssVelocity(
        gnss.source,
        gnss.t_ns,
        gnss.since_fused_s + dt_s,
        gnss.innovation_power,
        gnss.mean_nis,
        gnss.innovation,
        gnss.nis,
    )


def time_of_validity(fix: VelocitySample, delay_s: float, parameters: FlightParameters) -> int:
    """The instant of the fix on the clock of the low-passed sensors, ns: they lag the motion too."""
    return fix.t_ns - int(1e9 * (delay_s - low_pass_delay_s(parameters)))


def nominal_delay_s(fix: VelocitySample, parameters: FlightParameters) -> float:
    """Delay of such fixes before it is estimated, s."""
    return parameters.fix_delay_s if fix.origin == VelocityOrigin.RECEIVER else parameters.own_delay_s


def nominal_delay_sigma(fix: VelocitySample, parameters: FlightParameters) -> float:
    """How well that is known, s."""
    return parameters.fix_delay_sigma if fix.origin == VelocityOrigin.RECEIVER else parameters.own_delay_sigma


def low_pass_delay_s(parameters: FlightParameters) -> float:
    """Group delay of the autopilot's second-order Butterworth low-pass, s: sqrt(2) / (2 pi f)."""
    return 0.2250790790392765 / parameters.low_pass_hz if parameters.low_pass_hz > 0.0 else 0.0


def is_velocity(fix: VelocitySample) -> bool:
    """True when its numbers can be a velocity."""
    return norm(fix.v_ned) < MAX_VELOCITY


def fix_is_due(gnss: GnssVelocity, fix: VelocitySample | None, parameters: FlightParameters) -> bool:
    """True when the fix is one, has not been used, and is far enough from the one before."""
    if fix is None or not is_velocity(fix) or fix.t_ns == gnss.t_ns:
        return False
    # A clock that went back is a new one.
    apart = (fix.t_ns - gnss.t_ns) * 1e-9
    return fix.source != gnss.source or apart < 0.0 or apart > parameters.fix_spacing_s - 1e-3


def fuse_velocity(
    nav: NavigationState,
    history: DeltaVelocityHistory,
    gnss: GnssVelocity,
    fix: VelocitySample,
    estimates_sensors: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, GnssVelocity]:
    """Motion and memory after a fix that is due. One from before the history corrects nothing.

    teaches: it may tell something of the sensors.
    """
    if fix.source != gnss.source:
        nav = with_fix_delay(nav, nominal_delay_s(fix, parameters), nominal_delay_sigma(fix, parameters))
    past = look_back(history, time_of_validity(fix, nav.delays[1], parameters))
    if past is None:
        return nav, gnss
    sigma = clamp(NOISE_FACTOR * sqrt(gnss.innovation_power), parameters.velocity_floor, parameters.velocity_ceiling)
    accel = deadband(
        (past.specific_force[0], past.specific_force[1], past.specific_force[2] + parameters.gravity), DEADBAND_ACCEL
    )
    jitter = parameters.fix_jitter_s**2 * dot(accel, accel)
    variance = sigma * sigma + jitter
    # A wrong attitude must not excuse itself with the innovations that it makes.
    trusted = min(sigma, parameters.velocity_sigma) ** 2 + jitter
    count = 3 if fix.vertical_known else 2
    innovation = [0.0, 0.0, 0.0]
    nis = 0.0
    for axis in range(count):
        measurement = velocity_measurement(nav, past, accel, fix, axis, parameters)
        cross_cov = cross_covariance_of(nav, measurement)
        innovation[axis] = measurement.residual
        nis += measurement.residual**2 / (cross_cov.state_variance + trusted) / count
        least = (measurement.residual / parameters.velocity_gate) ** 2 - cross_cov.state_variance
        nav = fuse(nav, measurement, cross_cov, max(variance, least), estimates_sensors)
    square = (innovation[0] ** 2 + innovation[1] ** 2 + innovation[2] ** 2) / count
    innovation_power = gnss.innovation_power + POWER_SHARE * (
        min(square, POWER_STEP * gnss.innovation_power + 1e-6) - gnss.innovation_power
    )
    # However wild, one fix is one contradiction: it takes several in a row to give the attitude up.
    mean_nis = gnss.mean_nis + NIS_SHARE * (min(nis, parameters.velocity_gate**2) - gnss.mean_nis)
    return nav, GnssVelocity(
        fix.source, fix.t_ns, 0.0, innovation_power, mean_nis, (innovation[0], innovation[1], innovation[2]), nis
    )


def velocity_measurement(
    nav: NavigationState, past: Lookback, accel: Vec3, fix: VelocitySample, axis: int, parameters: FlightParameters
) -> Measurement:
    """One axis of a fix. ``accel``: of the vehicle at the time of the fix, NED, m/s^2.

    The velocity then is v - u - g age, with u the gain of specific force since; so its error is dv + [u]x theta, and
    a delay that is longer by dd moves the instant back along the acceleration.
    """
    gained = past.delta_velocity[axis] + (parameters.gravity * past.age_s if axis == 2 else 0.0)
    span_s = max(past.age_s, 0.0)
    x, y, z = deadband(
        (past.delta_velocity[0], past.delta_velocity[1], past.delta_velocity[2] + parameters.gravity * span_s),
        DEADBAND_ACCEL * span_s,
    )
    z -= parameters.gravity * span_s
    tilt: Vec3 = (0.0, -z, y) if axis == 0 else (z, 0.0, -x) if axis == 1 else (-y, x, 0.0)
    residual = fix.v_ned[axis] - (nav.velocity[axis] - gained)
    return Measurement(residual, t=tilt, v=unit_axis(axis), d=(0.0, -accel[axis], 0.0))
