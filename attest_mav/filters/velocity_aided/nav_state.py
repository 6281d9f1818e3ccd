"""What the filter estimates, and the one way in which a measurement row changes it."""

from math import sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, clamp, dot, q_exp, q_mul, q_norm, q_unit, scale
from attest_mav.filters.velocity_aided.covariance import (
    Covariance,
    CrossCovariance,
    Measurement,
    ProcessNoise,
    cross_covariance,
    propagated,
    updated_covariance,
    with_sensor_blocks_of,
)
from attest_mav.matrices import floor_diagonal, no_negative_variance
from attest_mav.types import Mat3, Quat, Vec3

LONGEST_DELAY_S: Final = 0.4
"""Of a magnetometer or of velocity fixes: with the age of the message it lies within the history."""


@mypyc_attr(acyclic=True)
class NavigationState:
    """The estimate at the time of an inertial sample.

    q_nb: body to NED. It is the attitude that the low-passed sensors see, which lags the true one by the low-pass.
    velocity: NED, m/s. gyro_bias: rad/s, accel_bias: m/s^2, hard_iron: gauss; all in the body, all to be subtracted.
    gyro_scale: share of each rate that is too much.
    delays: (of the magnetometer, s; of the velocity fixes, s; magnetic north from where it is believed to be, rad).
    p: covariance of the errors, see ``covariance``.
    """

    def __init__(
        self,
        q_nb: Quat,
        velocity: Vec3,
        gyro_bias: Vec3,
        gyro_scale: Vec3,
        accel_bias: Vec3,
        hard_iron: Vec3,
        delays: Vec3,
        p: Covariance,
    ) -> None:
        self.q_nb: Final = q_nb
        self.velocity: Final = velocity
        self.gyro_bias: Final = gyro_bias
        self.gyro_scale: Final = gyro_scale
        self.accel_bias: Final = accel_bias
        self.hard_iron: Final = hard_iron
        self.delays: Final = delays
        self.p: Final = p

    @property
    def tilt_sigma(self) -> float:
        """Of the angle between true and estimated vertical, rad."""
        return sqrt(max(0.0, self.p.tt[0][0] + self.p.tt[1][1]))

    @property
    def heading_sigma(self) -> float:
        """Of the turn about the vertical, rad."""
        return sqrt(max(0.0, self.p.tt[2][2]))


DEADBAND_RATE: Final = 0.05
"""rad/s: of a turn slower than this no more is seen than noise."""
DEADBAND_ACCEL: Final = 0.5
"""m/s^2: the same of an acceleration."""


def deadband(v: Vec3, least: float) -> Vec3:
    """v, or zero where it is too small to be more than noise.

    What multiplies an error in a row or a step must be motion: noise would explain itself by it, and in hours at rest
    the filter would believe in scales and delays that nothing has shown.
    """
    return v if dot(v, v) > least * least else (0.0, 0.0, 0.0)


def body_rate(nav: NavigationState, gyro: Vec3) -> Vec3:
    """The body's rate at this gyro reading, rad/s: without bias and scale error."""
    x, y, z = gyro
    b, s = nav.gyro_bias, nav.gyro_scale
    return (x - b[0] - s[0] * x, y - b[1] - s[1] * y, z - b[2] - s[2] * z)


def is_sound(nav: NavigationState) -> bool:
    """True while the numbers mean something: variances that are not negative, and a quaternion of unit length."""
    p = nav.p
    return (
        no_negative_variance(p.tt)
        and no_negative_variance(p.vv)
        and no_negative_variance(p.bb)
        and no_negative_variance(p.ss)
        and no_negative_variance(p.aa)
        and no_negative_variance(p.mm)
        and no_negative_variance(p.dd)
        and 0.5 < q_norm(nav.q_nb) < 2.0
    )


def predicted(
    nav: NavigationState,
    q_nb: Quat,
    velocity: Vec3,
    rotation_dt: Mat3,
    delta_velocity: Vec3,
    rate: Vec3,
    noise: ProcessNoise,
) -> NavigationState:
    """The motion after a step that led to this attitude and velocity; the rest as in ``propagated``."""
    return NavigationState(
        q_nb,
        velocity,
        nav.gyro_bias,
        nav.gyro_scale,
        nav.accel_bias,
        nav.hard_iron,
        nav.delays,
        propagated(nav.p, rotation_dt, delta_velocity, rate, noise),
    )


def cross_covariance_of(nav: NavigationState, measurement: Measurement) -> CrossCovariance:
    """What the state contributes to the row's residual."""
    return cross_covariance(nav.p, measurement)


def update(
    nav: NavigationState, measurement: Measurement, cross_cov: CrossCovariance, variance: float
) -> NavigationState:
    """The motion after one scalar measurement with this noise variance; ``seen`` is ``reach_of`` it."""
    k = 1.0 / (cross_cov.state_variance + variance)
    return _corrected(nav, cross_cov, k * measurement.residual, updated_covariance(nav.p, cross_cov, k))


def consider_update(
    nav: NavigationState, measurement: Measurement, cross_cov: CrossCovariance, variance: float
) -> NavigationState:
    """The motion after a row that teaches nothing of the sensors but the gyro's bias.

    That is for one which is only supposed to be true, because what it is wrong by lasts and would be taken for
    theirs; and for any during a long rest, which shows the same again and again. They stay as they are and as
    doubtful, and the rest allows for that (Schmidt's filter).
    """
    k = 1.0 / (cross_cov.state_variance + variance)
    zero: Vec3 = (0.0, 0.0, 0.0)
    without_sensors = CrossCovariance(
        cross_cov.t, cross_cov.v, cross_cov.b, zero, zero, zero, zero, cross_cov.state_variance
    )
    return _corrected(
        nav,
        without_sensors,
        k * measurement.residual,
        with_sensor_blocks_of(nav.p, updated_covariance(nav.p, cross_cov, k)),
    )


def fuse(
    nav: NavigationState, measurement: Measurement, cross_cov: CrossCovariance, variance: float, estimates_sensors: bool
) -> NavigationState:
    """The motion after a measurement, which teaches something of the sensors or not."""
    return (
        update(nav, measurement, cross_cov, variance)
        if estimates_sensors
        else consider_update(nav, measurement, cross_cov, variance)
    )


def _corrected(nav: NavigationState, cross_cov: CrossCovariance, gain: float, p: Covariance) -> NavigationState:
    return NavigationState(
        q_unit(q_mul(q_exp(scale(cross_cov.t, 0.5 * gain)), nav.q_nb)),
        add(nav.velocity, scale(cross_cov.v, gain)),
        add(nav.gyro_bias, scale(cross_cov.b, gain)),
        add(nav.gyro_scale, scale(cross_cov.s, gain)),
        add(nav.accel_bias, scale(cross_cov.a, gain)),
        add(nav.hard_iron, scale(cross_cov.m, gain)),
        _clamped(add(nav.delays, scale(cross_cov.d, gain))),
        p,
    )


def _clamped(delays: Vec3) -> Vec3:
    """The delays as they can be: what is not measured yet, or long forgotten, would match no row ever again."""
    return (clamp(delays[0], 0.0, LONGEST_DELAY_S), clamp(delays[1], 0.0, LONGEST_DELAY_S), delays[2])


def with_variances(nav: NavigationState, bias_floor: float, heading_growth: float) -> NavigationState:
    """The same motion, its gyro bias known no better than ``bias_floor`` and its heading less by ``heading_growth``.

    Both are variances, (rad/s)^2 and rad^2.
    """
    p = nav.p
    (a, b, c), (d, e, f), (g, h, i) = p.tt
    return NavigationState(
        nav.q_nb,
        nav.velocity,
        nav.gyro_bias,
        nav.gyro_scale,
        nav.accel_bias,
        nav.hard_iron,
        nav.delays,
        Covariance(
            ((a, b, c), (d, e, f), (g, h, i + heading_growth)), p.tv, p.tb, p.ts, p.ta, p.tm, p.td,
            p.vv, p.vb, p.vs, p.va, p.vm, p.vd,
            floor_diagonal(p.bb, bias_floor), p.bs, p.ba, p.bm, p.bd,
            p.ss, p.sa, p.sm, p.sd, p.aa, p.am, p.ad, p.mm, p.md, p.dd,
        ),
    )  # fmt: skip


def with_fix_delay(nav: NavigationState, delay_s: float, sigma_s: float) -> NavigationState:
    """The same motion with fixes from another source: their delay is new, and nothing is known to depend on it."""
    p = nav.p
    mag, _, north = nav.delays
    (d1, _, d3), _, (d7, _, d9) = p.dd
    return NavigationState(
        nav.q_nb,
        nav.velocity,
        nav.gyro_bias,
        nav.gyro_scale,
        nav.accel_bias,
        nav.hard_iron,
        (mag, delay_s, north),
        Covariance(
            p.tt, p.tv, p.tb, p.ts, p.ta, p.tm, _without_middle(p.td),
            p.vv, p.vb, p.vs, p.va, p.vm, _without_middle(p.vd),
            p.bb, p.bs, p.ba, p.bm, _without_middle(p.bd),
            p.ss, p.sa, p.sm, _without_middle(p.sd),
            p.aa, p.am, _without_middle(p.ad),
            p.mm, _without_middle(p.md),
            ((d1, 0.0, d3), (0.0, sigma_s * sigma_s, 0.0), (d7, 0.0, d9)),
        ),
    )  # fmt: skip


def _without_middle(m: Mat3) -> Mat3:
    """m with its middle column zero."""
    (a, _, c), (d, _, f), (g, _, i) = m
    return ((a, 0.0, c), (d, 0.0, f), (g, 0.0, i))
