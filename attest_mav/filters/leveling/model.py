"""The six-state model of the leveling filter (paper 3): body velocity and the down vector, with their covariance.

The system is linear in both: V' = -[w + W]x V + g a + f and a' = -[w - W]x a, eqs. (7) and (15), with the gyro's
rate w, the Earth's rate W, specific force f and down vector a. The covariance is kept in blocks named after the
vectors they relate: p_vv, p_vd and p_dd.
"""

from math import pi
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, cross, dot, is_finite, mat_vec, scale, sub
from attest_mav.matrices import (
    add_diagonal,
    axes_turn,
    floor_diagonal,
    mat_add,
    mat_mul,
    mat_mul_t,
    mat_scale,
    mat_t_vec,
    minus_outer,
    no_negative_variance,
    quadratic,
    symmetric,
    trace,
)
from attest_mav.record import Record
from attest_mav.types import Mat3, Vec3

MIN_VARIANCE: Final = 1e-12
"""Floor of the variances."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class LevelState(Record):
    """The estimate of velocity and down vector."""

    def __init__(self, velocity: Vec3, down: Vec3, p_vv: Mat3, p_vd: Mat3, p_dd: Mat3) -> None:
        self.velocity: Final = velocity
        """Over ground, in the body, m/s."""
        self.down: Final = down
        """Down in the body, near unit length."""
        self.p_vv: Final = p_vv
        """Covariance of the velocity, (m/s)^2."""
        self.p_vd: Final = p_vd
        """Covariance of velocity and down vector, m/s."""
        self.p_dd: Final = p_dd
        """Covariance of the down vector."""


def predicted(
    x: LevelState, gyro: Vec3, earth_rate: Vec3, accel: Vec3, gravity: float, dt_s: float, noise: tuple[float, float]
) -> LevelState:
    """x after dt_s, eqs. (21), (22) and (26), integrated in closed form while the rates are constant.

    gyro, earth: rad/s. accel: specific force, m/s^2. noise: variances that grow on each component of velocity and of
    down vector, a second.

    The transition is [a b; 0 d]. In b, the turns by w + W and by w - W of one vector average to the turn by w.
    """
    a = axes_turn(scale(add(gyro, earth_rate), dt_s))
    b = mat_scale(axes_turn(scale(gyro, dt_s)), gravity * dt_s)
    d = axes_turn(scale(sub(gyro, earth_rate), dt_s))
    velocity = add(add(mat_vec(a, x.velocity), mat_vec(b, x.down)), velocity_gain(add(gyro, earth_rate), accel, dt_s))
    m_v = mat_add(mat_mul(a, x.p_vv), mat_mul_t(b, x.p_vd))
    m_d = mat_add(mat_mul(a, x.p_vd), mat_mul(b, x.p_dd))
    return LevelState(
        velocity,
        mat_vec(d, x.down),
        add_diagonal(symmetric(mat_add(mat_mul_t(m_v, a), mat_mul_t(m_d, b))), noise[0] * dt_s),
        mat_mul_t(m_d, d),
        add_diagonal(symmetric(mat_mul_t(mat_mul(d, x.p_dd), d)), noise[1] * dt_s),
    )


def velocity_gain(rate: Vec3, accel: Vec3, dt_s: float) -> Vec3:
    """Velocity that a constant specific force adds in axes that turn at ``rate``, m/s, to third order in dt_s."""
    turned = cross(rate, accel)
    turned_twice = cross(rate, turned)
    return (
        dt_s * (accel[0] - dt_s * (0.5 * turned[0] - dt_s / 6.0 * turned_twice[0])),
        dt_s * (accel[1] - dt_s * (0.5 * turned[1] - dt_s / 6.0 * turned_twice[1])),
        dt_s * (accel[2] - dt_s * (0.5 * turned[2] - dt_s / 6.0 * turned_twice[2])),
    )


def updated(x: LevelState, h_v: Vec3, h_d: Vec3, innovation: float, r: float) -> LevelState:
    """x after one scalar measurement z = h_v.V + h_d.a + noise of variance r, eqs. (23) to (25), Joseph form.

    (The same update of one 4 x 4 matrix is ``matrices4.correction4``; that of the flight filter's blocks needs no
    Joseph form, see ``velocity_aided.measurement.updated``. They differ in the shape of the state alone, which is what
    the compiler needs written out.)

    P <- (I - k h^T) P (I - k h^T)^T + k r k^T, worked out as M + (r k - M h) k^T with M = (I - k h^T) P.
    """
    g_v = add(mat_vec(x.p_vv, h_v), mat_vec(x.p_vd, h_d))
    g_d = add(mat_t_vec(x.p_vd, h_v), mat_vec(x.p_dd, h_d))
    share = 1.0 / (dot(h_v, g_v) + dot(h_d, g_d) + r)
    k_v, k_d = scale(g_v, share), scale(g_d, share)
    m_vv, m_vd, m_dd = minus_outer(x.p_vv, k_v, g_v), minus_outer(x.p_vd, k_v, g_d), minus_outer(x.p_dd, k_d, g_d)
    w_v = sub(add(mat_vec(m_vv, h_v), mat_vec(m_vd, h_d)), scale(k_v, r))
    w_d = sub(add(mat_t_vec(m_vd, h_v), mat_vec(m_dd, h_d)), scale(k_d, r))
    return LevelState(
        add(x.velocity, scale(k_v, innovation)),
        add(x.down, scale(k_d, innovation)),
        symmetric(minus_outer(m_vv, w_v, k_v)),
        minus_outer(m_vd, w_v, k_d),
        symmetric(minus_outer(m_dd, w_d, k_d)),
    )


def tilt_variance(x: LevelState) -> float:
    """Variance of the direction of the down vector, summed over both axes across it, rad^2."""
    length_sq = dot(x.down, x.down)
    if not length_sq > 1e-12:
        return pi * pi
    along = quadratic(x.p_dd, x.down) / length_sq
    return min(max(trace(x.p_dd) - along, 0.0) / length_sq, pi * pi)


def is_sound(x: LevelState) -> bool:
    """True while everything is finite and no variance is negative."""
    return is_finite(x.velocity) and is_finite(x.down) and no_negative_variance(x.p_vv) and no_negative_variance(x.p_dd)


def with_variance_floor(x: LevelState) -> LevelState:
    """x with its variances no smaller than ``MIN_VARIANCE``."""
    return LevelState(
        x.velocity, x.down, floor_diagonal(x.p_vv, MIN_VARIANCE), x.p_vd, floor_diagonal(x.p_dd, MIN_VARIANCE)
    )
