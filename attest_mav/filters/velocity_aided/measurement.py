"""One scalar measurement, and the Kalman update of the covariance by it.

A vector is fused as scalar measurements one after the other, which needs no matrix inverse and gives the same while
their noises are independent (Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems,
2nd ed., chapter 3; Maybeck, Stochastic Models, Estimation, and Control, vol. 1, chapter 5).
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, dot, mat_vec, scale
from attest_mav.filters.velocity_aided.covariance import Covariance
from attest_mav.matrices import mat_t_vec, minus_outer
from attest_mav.record import Record
from attest_mav.types import Vec3


@mypyc_attr(acyclic=True, free_list_len=1)
class Measurement(Record):
    """One scalar measurement, linear in the error: residual = t.dt + v.dv + b.db + m.dm + d.dd + noise.

    There are no parts for the scale error s, the accelerometer bias a and the drift rate r. Of today's residuals only
    those of the gravity aid contain the bias (by C a), and a pseudo-measurement considers it instead of estimating it.
    A measurement that is to estimate it needs a part ``a`` here and its two terms in ``cross_covariance``.
    """

    def __init__(
        self,
        residual: float,
        t: Vec3 = (0.0, 0.0, 0.0),
        v: Vec3 = (0.0, 0.0, 0.0),
        b: Vec3 = (0.0, 0.0, 0.0),
        m: Vec3 = (0.0, 0.0, 0.0),
        d: Vec3 = (0.0, 0.0, 0.0),
    ) -> None:
        self.residual: Final = residual
        """The innovation: measured minus predicted, in the measurement's unit."""
        self.t: Final = t
        """Jacobian by the attitude error, a rad."""
        self.v: Final = v
        """Jacobian by the velocity error, a m/s."""
        self.b: Final = b
        """Jacobian by the gyro bias, a rad/s."""
        self.m: Final = m
        """Jacobian by the hard iron, a gauss."""
        self.d: Final = d
        """Jacobian by the lags of magnetometer and fixes (a s) and the declination error (a rad)."""


@mypyc_attr(acyclic=True, free_list_len=1)
class CrossCovariance(Record):
    """P h of one measurement: the covariance of each error vector with the predicted measurement."""

    def __init__(
        self, t: Vec3, v: Vec3, b: Vec3, s: Vec3, a: Vec3, m: Vec3, d: Vec3, r: Vec3, state_variance: float
    ) -> None:
        self.t: Final = t
        self.v: Final = v
        self.b: Final = b
        self.s: Final = s
        self.a: Final = a
        self.m: Final = m
        self.d: Final = d
        self.r: Final = r
        self.state_variance: Final = state_variance
        """h^T P h: the part of the innovation variance that is the state's own."""

    def without_sensors(self) -> "CrossCovariance":
        """The same with a zero gain for all sensor errors but the gyro bias, as a consider update has it."""
        zero: Vec3 = (0.0, 0.0, 0.0)
        return CrossCovariance(self.t, self.v, self.b, zero, zero, zero, zero, zero, self.state_variance)


def cross_covariance(p: Covariance, h: Measurement) -> CrossCovariance:
    """P h, block by block; those parts of h are zero that a ``Measurement`` does not have."""
    t = _sum5(mat_vec(p.tt, h.t), mat_vec(p.tv, h.v), mat_vec(p.tb, h.b), mat_vec(p.tm, h.m), mat_vec(p.td, h.d))
    v = _sum5(mat_t_vec(p.tv, h.t), mat_vec(p.vv, h.v), mat_vec(p.vb, h.b), mat_vec(p.vm, h.m), mat_vec(p.vd, h.d))
    b = _sum5(mat_t_vec(p.tb, h.t), mat_t_vec(p.vb, h.v), mat_vec(p.bb, h.b), mat_vec(p.bm, h.m), mat_vec(p.bd, h.d))
    s = _sum5(mat_t_vec(p.ts, h.t), mat_t_vec(p.vs, h.v), mat_t_vec(p.bs, h.b), mat_vec(p.sm, h.m), mat_vec(p.sd, h.d))
    a = _sum5(mat_t_vec(p.ta, h.t), mat_t_vec(p.va, h.v), mat_t_vec(p.ba, h.b), mat_vec(p.am, h.m), mat_vec(p.ad, h.d))
    m = _sum5(mat_t_vec(p.tm, h.t), mat_t_vec(p.vm, h.v), mat_t_vec(p.bm, h.b), mat_vec(p.mm, h.m), mat_vec(p.md, h.d))
    d = _sum5(
        mat_t_vec(p.td, h.t), mat_t_vec(p.vd, h.v), mat_t_vec(p.bd, h.b), mat_t_vec(p.md, h.m), mat_vec(p.dd, h.d)
    )
    r = _sum5(
        mat_t_vec(p.tr, h.t), mat_t_vec(p.vr, h.v), mat_t_vec(p.br, h.b), mat_t_vec(p.mr, h.m), mat_t_vec(p.dr, h.d)
    )
    return CrossCovariance(t, v, b, s, a, m, d, r, dot(h.t, t) + dot(h.v, v) + dot(h.b, b) + dot(h.m, m) + dot(h.d, d))


def updated(p: Covariance, g: CrossCovariance, k: float) -> Covariance:
    """P - (P h)(P h)^T k, with k = 1 / (h^T P h + r): the covariance after a measurement of variance r.

    The Joseph form has the same value for the optimal gain, at twice the cost, and pays where rounding can make
    a variance negative: with measurements far more accurate than the state, or a gain that is not the optimal one. Here
    the smallest measurement variances (0.05 m/s, half a per cent of the field) are of the size of the state's own, a
    consider update uses the full gain for the covariance too, every step adds process noise and makes the diagonal
    blocks of attitude and velocity symmetric, and only upper blocks are kept. A negative variance would fail
    ``Covariance.is_valid``, and the filter would align again.
    """
    t, v, b, s, a, m, d = (
        scale(g.t, k), scale(g.v, k), scale(g.b, k), scale(g.s, k), scale(g.a, k), scale(g.m, k), scale(g.d, k)
    )  # fmt: skip
    return Covariance(
        minus_outer(p.tt, t, g.t), minus_outer(p.tv, t, g.v), minus_outer(p.tb, t, g.b), minus_outer(p.ts, t, g.s),
        minus_outer(p.ta, t, g.a), minus_outer(p.tm, t, g.m), minus_outer(p.td, t, g.d), minus_outer(p.tr, t, g.r),
        minus_outer(p.vv, v, g.v), minus_outer(p.vb, v, g.b), minus_outer(p.vs, v, g.s), minus_outer(p.va, v, g.a),
        minus_outer(p.vm, v, g.m), minus_outer(p.vd, v, g.d), minus_outer(p.vr, v, g.r),
        minus_outer(p.bb, b, g.b), minus_outer(p.bs, b, g.s), minus_outer(p.ba, b, g.a), minus_outer(p.bm, b, g.m),
        minus_outer(p.bd, b, g.d), minus_outer(p.br, b, g.r),
        minus_outer(p.ss, s, g.s), minus_outer(p.sa, s, g.a), minus_outer(p.sm, s, g.m), minus_outer(p.sd, s, g.d),
        minus_outer(p.sr, s, g.r),
        minus_outer(p.aa, a, g.a), minus_outer(p.am, a, g.m), minus_outer(p.ad, a, g.d), minus_outer(p.ar, a, g.r),
        minus_outer(p.mm, m, g.m), minus_outer(p.md, m, g.d), minus_outer(p.mr, m, g.r),
        minus_outer(p.dd, d, g.d), minus_outer(p.dr, d, g.r),
        minus_outer(p.rr, scale(g.r, k), g.r),
    )  # fmt: skip


def consider_updated(p: Covariance, g: CrossCovariance, k: float) -> Covariance:
    """P after a measurement that leaves the sensor errors but the gyro bias as they are (Schmidt-Kalman filter).

    Their blocks among themselves stay; those with attitude, velocity and gyro bias are those of the full update.
    """
    q = updated(p, g, k)
    return Covariance(
        q.tt, q.tv, q.tb, q.ts, q.ta, q.tm, q.td, q.tr,
        q.vv, q.vb, q.vs, q.va, q.vm, q.vd, q.vr,
        q.bb, q.bs, q.ba, q.bm, q.bd, q.br,
        p.ss, p.sa, p.sm, p.sd, p.sr,
        p.aa, p.am, p.ad, p.ar,
        p.mm, p.md, p.mr,
        p.dd, p.dr,
        p.rr,
    )  # fmt: skip


def _sum5(a: Vec3, b: Vec3, c: Vec3, d: Vec3, e: Vec3) -> Vec3:
    return add(add(add(a, b), add(c, d)), e)
