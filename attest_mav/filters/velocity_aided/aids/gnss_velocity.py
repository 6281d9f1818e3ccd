"""Velocity fixes: delayed, of unknown quality, sometimes wrong.

A fix is compared with the velocity of the instant it belongs to. Its deviation follows the innovations: 2.5 times their
rms, so that errors that last, which innovations do not show, are allowed for. A fix outside the gate is not rejected:
its variance is inflated until it lies on the gate. After a gap, when the state's own variance is large, that changes
nothing and the fix is fused in full; a hard gate would lock the filter out. (Adaptive noise and innovation filtering:
Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 3.4 and 17.3.)
"""

from math import inf, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, dot, square, unit_axis
from attest_mav.filters.robust import averaged_power, variance_on_gate
from attest_mav.filters.velocity_aided.history import Lookback, look_back
from attest_mav.filters.velocity_aided.imu_memory import ImuMemory
from attest_mav.filters.velocity_aided.lags import fix_lag_variance, nominal_fix_lag_s
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import (
    DEADBAND_ACCEL,
    NavigationState,
    cross_covariance_of,
    deadband,
    fuse,
)
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.plausible import is_velocity
from attest_mav.record import Record
from attest_mav.samples import VelocitySample
from attest_mav.types import Vec3

POWER_SHARE: Final = 0.05
"""Weight of a new innovation in the running mean square."""
POWER_STEP: Final = 4.0
"""One innovation counts for at most this many times the mean square."""
POWER_FLOOR: Final = 1e-6
"""(m/s)^2: what it may always count for."""
NOISE_FACTOR: Final = 2.5
"""The noise of a fix as a multiple of the innovations' rms: errors that last for seconds weigh more than they show."""
SHOWN_FACTOR: Final = 2.0
"""The same in the consistency test, which asks for the innovation that is to be expected."""
NIS_SHARE: Final = 0.1
"""Weight of a new fix in the mean normalised innovation squared: at 5 Hz a memory of 2 s."""


@mypyc_attr(acyclic=True, free_list_len=1)
class GnssVelocity(Record):
    """The state of velocity fusion."""

    def __init__(
        self,
        last: VelocitySample | None,
        since_fused_s: float,
        innovation_power: float,
        mean_nis: float,
        innovation: Innovation | None,
    ) -> None:
        self.last: Final = last
        """The last fix that was fused, None before the first."""
        self.since_fused_s: Final = since_fused_s
        """Time since then, s; infinite while none was, or none after a reset."""
        self.innovation_power: Final = innovation_power
        """Running mean square of the innovations, (m/s)^2 an axis."""
        self.mean_nis: Final = mean_nis
        """Running mean of the normalised innovation squared, in which no fix counts for more than the gate."""
        self.innovation: Final = innovation
        """Of the fix that this step had to offer, None where it had no new one."""

    def aged(self, dt_s: float) -> "GnssVelocity":
        """The same a step later, before its fix."""
        return GnssVelocity(self.last, self.since_fused_s + dt_s, self.innovation_power, self.mean_nis, None)

    def after_reset(self, aligned_by_fixes: bool) -> "GnssVelocity":
        """The state of fusion at a start. The fixes of an alignment are recent, those from before a gap are not."""
        return GnssVelocity(self.last, 0.0 if aligned_by_fixes else inf, self.innovation_power, 0.0, None)

    def with_innovation(self, innovation: Innovation) -> "GnssVelocity":
        """The same with the record of a fix that was not fused."""
        return GnssVelocity(self.last, self.since_fused_s, self.innovation_power, self.mean_nis, innovation)


def initial_gnss_velocity(parameters: FlightParameters) -> GnssVelocity:
    """The state of fusion before the first fix."""
    return GnssVelocity(None, inf, (parameters.velocity_sigma / NOISE_FACTOR) ** 2, 0.0, None)


def time_of_validity(fix: VelocitySample, lag_s: float) -> int:
    """The instant of the fix on the clock of the low-passed sensors, ns."""
    return fix.t_ns - int(1e9 * lag_s)


def fix_is_due(gnss: GnssVelocity, fix: VelocitySample, parameters: FlightParameters) -> bool:
    """True when the fix has not been fused, and is far enough from the last one that was."""
    last = gnss.last
    if last is None:
        return True
    if fix.t_ns == last.t_ns:
        return False
    # A clock that went back is a new one.
    apart_s = (fix.t_ns - last.t_ns) * 1e-9
    return fix.source != last.source or apart_s < 0.0 or apart_s > parameters.fix_spacing_s - 1e-3


def fuse_velocity(
    nav: NavigationState,
    imu: ImuMemory,
    gnss: GnssVelocity,
    fix: VelocitySample,
    estimates_sensors: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, GnssVelocity]:
    """State and memory after a fix that is due; its record says whether it was fused.

    imu: the memory of dead reckoning. estimates_sensors: whether the fix may estimate the sensor errors, or only
    considers them.
    """
    if not is_velocity(fix.v_ned):
        return nav, gnss.with_innovation(Innovation(Aid.VELOCITY, Fusion.IMPLAUSIBLE, fix.t_ns))
    if gnss.last is None or fix.source != gnss.last.source:
        nav = nav.with_fix_lag(nominal_fix_lag_s(fix.origin, parameters), fix_lag_variance(fix.origin, parameters))
    past = look_back(imu.history, time_of_validity(fix, nav.fix_lag_s))
    if past is None:
        return nav, gnss.with_innovation(Innovation(Aid.VELOCITY, Fusion.TOO_OLD, fix.t_ns, fix.v_ned))
    nav, innovation = _fuse_axes(
        nav, past, _fix_noise(past, imu, gnss, fix, parameters), fix, estimates_sensors, parameters
    )
    return nav, _after_fix(gnss, fix, innovation, parameters)


@mypyc_attr(acyclic=True)
class FixNoise(Record):
    """Variances of one fix, per axis, (m/s)^2, and the acceleration of the vehicle at its time."""

    def __init__(self, variance: float, trusted: float, acceleration: Vec3) -> None:
        self.variance: Final = variance
        """In the update."""
        self.trusted: Final = trusted
        """In the consistency test, where the noise may not adapt upwards: a wrong attitude would inflate its limit."""
        self.acceleration: Final = acceleration
        """NED, m/s^2."""


def _fix_noise(
    past: Lookback, imu: ImuMemory, gnss: GnssVelocity, fix: VelocitySample, parameters: FlightParameters
) -> FixNoise:
    """The noise of a fix: by the innovations, by what the receiver reports, and by the jitter of its time."""
    usual, floor = sqrt(gnss.innovation_power), parameters.velocity_floor
    sigma = clamp(NOISE_FACTOR * usual, floor, parameters.velocity_ceiling)
    force = past.specific_force
    accel = deadband((force[0], force[1], force[2] + parameters.gravity), DEADBAND_ACCEL)
    jitter = square(parameters.fix_jitter_s) * dot(accel, accel)
    # An acceleration between the samples belongs to the vehicle and not to the receiver: it is no contradiction.
    hidden = square(parameters.fix_jitter_s * imu.hidden_acceleration)
    # The receiver knows of some of its errors; it must not count as a contradiction where it says that it is poor.
    reported = 0.0 if fix.sigma is None else fix.sigma * fix.sigma
    trusted = square(clamp(SHOWN_FACTOR * usual, floor, parameters.velocity_sigma))
    return FixNoise(max(sigma * sigma, reported) + jitter, max(trusted, reported) + jitter + hidden, accel)


def _fuse_axes(
    nav: NavigationState,
    past: Lookback,
    noise: FixNoise,
    fix: VelocitySample,
    estimates_sensors: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, Innovation]:
    """The state after the axes of a fix, one after the other, and their record."""
    residuals: list[float] = []
    variances: list[float] = []
    fusion = Fusion.USED
    for axis in range(3 if fix.vertical_known else 2):
        measurement = velocity_measurement(nav, past, noise.acceleration, fix, axis, parameters)
        cross_cov = cross_covariance_of(nav, measurement)
        residuals.append(measurement.residual)
        variances.append(cross_cov.state_variance + noise.trusted)
        on_gate = variance_on_gate(measurement.residual, cross_cov.state_variance, parameters.velocity_gate)
        if on_gate > noise.variance:
            fusion = Fusion.INFLATED
        nav = fuse(nav, measurement, cross_cov, max(noise.variance, on_gate), estimates_sensors)
    observation = fix.v_ned if fix.vertical_known else (fix.v_ned[0], fix.v_ned[1])
    return nav, Innovation(Aid.VELOCITY, fusion, fix.t_ns, observation, tuple(residuals), tuple(variances))


def _after_fix(
    gnss: GnssVelocity, fix: VelocitySample, innovation: Innovation, parameters: FlightParameters
) -> GnssVelocity:
    """The memory after a fix that was fused."""
    mean_square = 0.0
    for residual in innovation.residual:
        mean_square += square(residual)
    mean_square /= len(innovation.residual)
    power = averaged_power(gnss.innovation_power, mean_square, POWER_SHARE, POWER_STEP, POWER_FLOOR)
    # However wild, one fix is one contradiction: it takes several in a row to give the attitude up.
    nis = min(innovation.nis, square(parameters.velocity_gate))
    return GnssVelocity(fix, 0.0, power, gnss.mean_nis + NIS_SHARE * (nis - gnss.mean_nis), innovation)


def velocity_measurement(
    nav: NavigationState, past: Lookback, accel: Vec3, fix: VelocitySample, axis: int, parameters: FlightParameters
) -> Measurement:
    """One axis of a fix. ``accel``: of the vehicle at the time of the fix, NED, m/s^2.

    The velocity then is v - u - g age, with u the gain of specific force since; so its error is dv + [u]x dt, and a
    lag that is longer by dd moves the instant back along the acceleration.
    """
    u = past.delta_velocity
    gained = u[axis] + (parameters.gravity * past.age_s if axis == 2 else 0.0)
    span_s = max(past.age_s, 0.0)
    x, y, z = deadband((u[0], u[1], u[2] + parameters.gravity * span_s), DEADBAND_ACCEL * span_s)
    z -= parameters.gravity * span_s
    tilt: Vec3 = (0.0, -z, y) if axis == 0 else (z, 0.0, -x) if axis == 1 else (-y, x, 0.0)
    residual = fix.v_ned[axis] - (nav.velocity[axis] - gained)
    return Measurement(residual, t=tilt, v=unit_axis(axis), d=(0.0, -accel[axis], 0.0))
