"""The navigation state: the nominal state with the covariance of its errors, and its correction by a measurement.

An error-state Kalman filter in closed loop: each correction goes into the nominal state at once, and the error is zero
in the mean again (Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., chapter
3; Sola, Quaternion kinematics for the error-state Kalman filter, sections 6 and 7).
"""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, clamp, dot, q_exp, q_heading, q_mul, q_norm, q_to_matrix, q_unit, rotate, scale
from attest_mav.filters.velocity_aided.covariance import Covariance
from attest_mav.filters.velocity_aided.covariance_blocks import (
    FIX_LAG,
    MAG_LAG,
    ErrorBlock,
    decoupled,
    turned,
    with_added_variance,
    with_component_restarted,
    with_gyro_bias_floor,
)
from attest_mav.filters.velocity_aided.measurement import (
    CrossCovariance,
    Measurement,
    consider_updated,
    cross_covariance,
    updated,
)
from attest_mav.matrices import diagonal
from attest_mav.record import Record
from attest_mav.types import Mat3, Quat, Vec3

LONGEST_LAG_S: Final = 0.4
"""Largest lag that is estimated, s: with the age of the message it lies within the history."""
LONGEST_LEAD_S: Final = 0.15
"""Largest lead, s: behind a low-pass of 2 Hz the inertial readings are 0.11 s late, and may be the latest of all."""


@mypyc_attr(acyclic=True, free_list_len=1)
class NavigationState(Record):
    """The estimate at the time of an inertial sample."""

    def __init__(
        self,
        q_nb: Quat,
        velocity: Vec3,
        gyro_bias: Vec3,
        gyro_drift: Vec3,
        gyro_scale: Vec3,
        accel_bias: Vec3,
        hard_iron: Vec3,
        mag_lag_s: float,
        fix_lag_s: float,
        declination_error: float,
        covariance: Covariance,
    ) -> None:
        self.q_nb: Final = q_nb
        """Body to NED, as the low-passed sensors see it: behind the true attitude by the low-pass's group delay."""
        self.velocity: Final = velocity
        """NED, m/s."""
        self.gyro_bias: Final = gyro_bias
        """Body, rad/s; to be subtracted from the gyro."""
        self.gyro_drift: Final = gyro_drift
        """Body, rad/s^2: rate at which that bias changes."""
        self.gyro_scale: Final = gyro_scale
        """Per axis of the body, 1: share of each rate that the gyro shows too much."""
        self.accel_bias: Final = accel_bias
        """Body, m/s^2; to be subtracted from the accelerometer."""
        self.hard_iron: Final = hard_iron
        """Body, gauss; to be subtracted from the magnetometer."""
        self.mag_lag_s: Final = mag_lag_s
        """How much older a magnetometer reading is than the low-passed inertial reading beside it, s; negative for one
        that is less late."""
        self.fix_lag_s: Final = fix_lag_s
        """How much older a velocity fix is than a low-passed inertial reading of the time that its message names, s."""
        self.declination_error: Final = declination_error
        """True minus assumed declination, rad."""
        self.covariance: Final = covariance
        """Of the errors, see ``covariance``."""

    @property
    def tilt_sigma(self) -> float:
        """1-sigma of the angle between true and estimated vertical, rad."""
        return sqrt(self.covariance.tilt_variance)

    @property
    def heading_sigma(self) -> float:
        """1-sigma of the rotation about the vertical, rad."""
        return sqrt(self.covariance.heading_variance)

    @property
    def is_valid(self) -> bool:
        """False once a variance is negative or not a number, or the quaternion has no unit length."""
        return self.covariance.is_valid and 0.5 < q_norm(self.q_nb) < 2.0

    def propagated(
        self, q_nb: Quat, velocity: Vec3, dt_s: float, drift_kept: float, covariance: Covariance
    ) -> "NavigationState":
        """The state after a step of ``dt_s``: the gyro bias drifts, the other sensor errors stay.

        drift_kept: share of the drift rate that outlasts the step, 1.
        """
        return NavigationState(
            q_nb,
            velocity,
            add(self.gyro_bias, scale(self.gyro_drift, dt_s)),
            scale(self.gyro_drift, drift_kept),
            self.gyro_scale,
            self.accel_bias,
            self.hard_iron,
            self.mag_lag_s,
            self.fix_lag_s,
            self.declination_error,
            covariance,
        )

    def with_motion(self, q_nb: Quat, velocity: Vec3, covariance: Covariance) -> "NavigationState":
        """The state with another attitude and velocity; the sensor errors stay."""
        return self.propagated(q_nb, velocity, 0.0, 1.0, covariance)

    def restarted(self, q_nb: Quat, attitude: Mat3, velocity: Vec3, velocity_variance: float) -> "NavigationState":
        """The state with a new attitude and velocity, independent of the sensor errors, which stay as they are known.

        attitude: covariance of the attitude error, rad^2. velocity_variance: (m/s)^2 an axis.
        """
        p = decoupled(self.covariance, ErrorBlock.ATTITUDE, attitude)
        return self.with_motion(q_nb, velocity, decoupled(p, ErrorBlock.VELOCITY, diagonal(velocity_variance)))

    def corrected(self, cross_cov: CrossCovariance, gain: float, covariance: Covariance) -> "NavigationState":
        """The state after the correction ``gain`` times P h, which an error-state filter takes into the state at once.

        The lags stay possible ones: a fix from the future, or from before the history, would match no measurement.
        """
        d = cross_cov.d
        return NavigationState(
            q_unit(q_mul(q_exp(scale(cross_cov.t, 0.5 * gain)), self.q_nb)),
            add(self.velocity, scale(cross_cov.v, gain)),
            add(self.gyro_bias, scale(cross_cov.b, gain)),
            add(self.gyro_drift, scale(cross_cov.r, gain)),
            add(self.gyro_scale, scale(cross_cov.s, gain)),
            add(self.accel_bias, scale(cross_cov.a, gain)),
            add(self.hard_iron, scale(cross_cov.m, gain)),
            clamp(self.mag_lag_s + gain * d[0], -LONGEST_LEAD_S, LONGEST_LAG_S),
            clamp(self.fix_lag_s + gain * d[1], -LONGEST_LEAD_S, LONGEST_LAG_S),
            self.declination_error + gain * d[2],
            covariance,
        )

    def with_lags(
        self, mag_lag_s: float, fix_lag_s: float, declination_error: float, covariance: Covariance
    ) -> "NavigationState":
        """The state with other lags (s) and another declination error (rad)."""
        return NavigationState(
            self.q_nb,
            self.velocity,
            self.gyro_bias,
            self.gyro_drift,
            self.gyro_scale,
            self.accel_bias,
            self.hard_iron,
            mag_lag_s,
            fix_lag_s,
            declination_error,
            covariance,
        )

    def with_sensor_errors(self, accel_bias: Vec3, hard_iron: Vec3, covariance: Covariance) -> "NavigationState":
        """The state with another bias of the accelerometer (m/s^2) and hard iron of the magnetometer (gauss)."""
        return NavigationState(
            self.q_nb,
            self.velocity,
            self.gyro_bias,
            self.gyro_drift,
            self.gyro_scale,
            accel_bias,
            hard_iron,
            self.mag_lag_s,
            self.fix_lag_s,
            self.declination_error,
            covariance,
        )

    def turned(self, heading: float) -> "NavigationState":
        """The state turned about the vertical by this angle, rad."""
        q = q_heading(heading)
        return self.with_motion(q_mul(q, self.q_nb), rotate(q, self.velocity), turned(self.covariance, q_to_matrix(q)))

    def with_covariance(self, covariance: Covariance) -> "NavigationState":
        """The same estimate with another covariance."""
        return self.with_motion(self.q_nb, self.velocity, covariance)

    def with_added_variance(self, error: ErrorBlock, variance: Vec3) -> "NavigationState":
        """The same estimate, one of its errors less certain by these variances."""
        return self.with_covariance(with_added_variance(self.covariance, error, variance))

    def with_gyro_bias_floor(self, least: float) -> "NavigationState":
        """The same estimate, its gyro bias known no better than this variance, (rad/s)^2."""
        return self.with_covariance(with_gyro_bias_floor(self.covariance, least))

    def decoupled(self, error: ErrorBlock, variance: float) -> "NavigationState":
        """The same estimate, one of its errors independent of all others and of this variance in each axis."""
        return self.with_covariance(decoupled(self.covariance, error, diagonal(variance)))

    def with_fix_lag(self, lag_s: float, variance: float) -> "NavigationState":
        """The state for fixes from another source: their lag is new, and no other error depends on it."""
        p = with_component_restarted(self.covariance, ErrorBlock.DELAYS, FIX_LAG, variance)
        return self.with_lags(self.mag_lag_s, lag_s, self.declination_error, p)

    def with_mag_lag(self, lag_s: float, variance: float) -> "NavigationState":
        """The state with another lag of the magnetometer, on which no other error depends."""
        p = with_component_restarted(self.covariance, ErrorBlock.DELAYS, MAG_LAG, variance)
        return self.with_lags(lag_s, self.fix_lag_s, self.declination_error, p)


def cross_covariance_of(nav: NavigationState, measurement: Measurement) -> CrossCovariance:
    """P h of the measurement."""
    return cross_covariance(nav.covariance, measurement)


def update(
    nav: NavigationState, measurement: Measurement, cross_cov: CrossCovariance, variance: float
) -> NavigationState:
    """The state after one measurement with this noise variance; ``cross_cov``: that of the measurement."""
    k = 1.0 / (cross_cov.state_variance + variance)
    return nav.corrected(cross_cov, k * measurement.residual, updated(nav.covariance, cross_cov, k))


def consider_update(
    nav: NavigationState, measurement: Measurement, cross_cov: CrossCovariance, variance: float
) -> NavigationState:
    """The state after a measurement that considers the sensor errors instead of estimating them (Schmidt-Kalman).

    Gyro bias is estimated all the same. The update serves pseudo-measurements, whose error lasts and would be explained
    by the sensors, and every measurement during a long rest, which carries no new information about them.
    """
    k = 1.0 / (cross_cov.state_variance + variance)
    covariance = consider_updated(nav.covariance, cross_cov, k)
    return nav.corrected(cross_cov.without_sensors(), k * measurement.residual, covariance)


def fuse(
    nav: NavigationState, measurement: Measurement, cross_cov: CrossCovariance, variance: float, estimates_sensors: bool
) -> NavigationState:
    """The state after a measurement that estimates the sensor errors, or considers them."""
    if estimates_sensors:
        return update(nav, measurement, cross_cov, variance)
    return consider_update(nav, measurement, cross_cov, variance)


DEADBAND_RATE: Final = 0.05
"""rad/s: a slower rate is noise as a factor in a Jacobian."""
DEADBAND_ACCEL: Final = 0.5
"""m/s^2: the same for an acceleration."""


def deadband(v: Vec3, least: float) -> Vec3:
    """v, or zero where it is shorter than ``least``.

    Below this magnitude the factor is noise, which must not enter a Jacobian, or during hours at rest scale factor and
    delay would be "estimated" from noise.
    """
    return v if dot(v, v) > least * least else (0.0, 0.0, 0.0)


def body_rate(nav: NavigationState, gyro: Vec3) -> Vec3:
    """The body's angular rate at this gyro reading, rad/s: without bias and scale error."""
    x, y, z = gyro
    b, s = nav.gyro_bias, nav.gyro_scale
    return (x - b[0] - s[0] * x, y - b[1] - s[1] * y, z - b[2] - s[2] * z)
