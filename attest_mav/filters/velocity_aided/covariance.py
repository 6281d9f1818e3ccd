"""The covariance of the flight filter as named blocks: how it grows with time, and how a measurement shrinks it.

The error is seven vectors of three,

    t  attitude, as a rotation in NED: C_true = exp([t]x) C           rad
    v  velocity in NED                                                m/s
    b  gyro bias in the body                                          rad/s
    s  gyro scale, per axis                                           1
    a  accelerometer bias in the body                                 m/s^2
    m  hard iron, the magnetometer's bias in the body                 gauss
    d  delays and declination: of the magnetometer, of the velocity   s, s, rad
       fixes, and of magnetic north from where it is believed to be

each the true value minus the estimate. ``tv`` is the block E[t v^T]; the lower half is the transpose of the upper.
Only t and v change with time, so a step touches their rows and leaves the rest alone. What the gyro is wrong by,
e = b + W s with W the rates on a diagonal, takes part as one vector.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, dot, mat_vec, scale
from attest_mav.matrices import (
    add_diagonal,
    mat_t_vec,
    minus_cross,
    minus_mul,
    minus_mul_t,
    minus_outer,
    plus_scaled_rows,
    symmetric,
    transpose,
)
from attest_mav.types import Mat3, Vec3


@mypyc_attr(acyclic=True)
class Covariance:
    """The upper blocks, each three rows."""

    def __init__(
        self,
        tt: Mat3,
        tv: Mat3,
        tb: Mat3,
        ts: Mat3,
        ta: Mat3,
        tm: Mat3,
        td: Mat3,
        vv: Mat3,
        vb: Mat3,
        vs: Mat3,
        va: Mat3,
        vm: Mat3,
        vd: Mat3,
        bb: Mat3,
        bs: Mat3,
        ba: Mat3,
        bm: Mat3,
        bd: Mat3,
        ss: Mat3,
        sa: Mat3,
        sm: Mat3,
        sd: Mat3,
        aa: Mat3,
        am: Mat3,
        ad: Mat3,
        mm: Mat3,
        md: Mat3,
        dd: Mat3,
    ) -> None:
        self.tt: Final = tt
        self.tv: Final = tv
        self.tb: Final = tb
        self.ts: Final = ts
        self.ta: Final = ta
        self.tm: Final = tm
        self.td: Final = td
        self.vv: Final = vv
        self.vb: Final = vb
        self.vs: Final = vs
        self.va: Final = va
        self.vm: Final = vm
        self.vd: Final = vd
        self.bb: Final = bb
        self.bs: Final = bs
        self.ba: Final = ba
        self.bm: Final = bm
        self.bd: Final = bd
        self.ss: Final = ss
        self.sa: Final = sa
        self.sm: Final = sm
        self.sd: Final = sd
        self.aa: Final = aa
        self.am: Final = am
        self.ad: Final = ad
        self.mm: Final = mm
        self.md: Final = md
        self.dd: Final = dd


@mypyc_attr(acyclic=True)
class ProcessNoise:
    """What one step adds to the diagonal blocks: variances per axis. The delays are constant."""

    def __init__(self, t: float, v: float, b: float, a: float, m: float) -> None:
        self.t: Final = t
        self.v: Final = v
        self.b: Final = b
        self.a: Final = a
        self.m: Final = m


@mypyc_attr(acyclic=True)
class Measurement:
    """One scalar measurement, linear in the error: residual = t.theta + v.dv + b.db + m.dm + d.dd + noise.

    No measurement sees the accelerometer's bias directly.
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
        self.t: Final = t
        self.v: Final = v
        self.b: Final = b
        self.m: Final = m
        self.d: Final = d


@mypyc_attr(acyclic=True)
class CrossCovariance:
    """P h for one row, and ``variance`` = h^T P h: the part of the residual's variance that is the state's own."""

    def __init__(self, t: Vec3, v: Vec3, b: Vec3, s: Vec3, a: Vec3, m: Vec3, d: Vec3, state_variance: float) -> None:
        self.t: Final = t
        self.v: Final = v
        self.b: Final = b
        self.s: Final = s
        self.a: Final = a
        self.m: Final = m
        self.d: Final = d
        self.state_variance: Final = state_variance


def propagated(p: Covariance, rotation_dt: Mat3, delta_velocity: Vec3, rate: Vec3, noise: ProcessNoise) -> Covariance:
    """P after a step: t' = t - turn e, v' = v - [push]x t' - turn a; turn = C dt, push = C f dt, e = b + W s.

    rate: rad/s, the diagonal of W. Written row by row: first the rows of t, then those of v, then what t' and v' have
    with themselves.
    """
    bs_t = transpose(p.bs)
    tb = minus_mul(p.tb, rotation_dt, plus_scaled_rows(p.bb, rate, bs_t))
    ts = minus_mul(p.ts, rotation_dt, plus_scaled_rows(p.bs, rate, p.ss))
    ta = minus_mul(p.ta, rotation_dt, plus_scaled_rows(p.ba, rate, p.sa))
    tm = minus_mul(p.tm, rotation_dt, plus_scaled_rows(p.bm, rate, p.sm))
    td = minus_mul(p.td, rotation_dt, plus_scaled_rows(p.bd, rate, p.sd))
    t_old_v = minus_mul(p.tv, rotation_dt, plus_scaled_rows(transpose(p.vb), rate, transpose(p.vs)))
    t_old_t = minus_mul(p.tt, rotation_dt, plus_scaled_rows(transpose(p.tb), rate, transpose(p.ts)))
    te = transpose(plus_scaled_rows(transpose(tb), rate, transpose(ts)))
    tt = minus_mul_t(t_old_t, te, rotation_dt)
    vb = minus_mul_t(minus_cross(p.vb, delta_velocity, tb), rotation_dt, p.ba)
    vs = minus_mul_t(minus_cross(p.vs, delta_velocity, ts), rotation_dt, p.sa)
    va = minus_mul(minus_cross(p.va, delta_velocity, ta), rotation_dt, p.aa)
    vm = minus_mul(minus_cross(p.vm, delta_velocity, tm), rotation_dt, p.am)
    vd = minus_mul(minus_cross(p.vd, delta_velocity, td), rotation_dt, p.ad)
    vt = minus_mul_t(minus_cross(transpose(t_old_v), delta_velocity, tt), rotation_dt, ta)
    v_old_v = minus_mul_t(minus_cross(p.vv, delta_velocity, t_old_v), rotation_dt, p.va)
    tv = transpose(vt)
    vv = minus_mul_t(transpose(minus_cross(transpose(v_old_v), delta_velocity, tv)), va, rotation_dt)
    return Covariance(
        add_diagonal(symmetric(tt), noise.t), tv, tb, ts, ta, tm, td,
        add_diagonal(symmetric(vv), noise.v), vb, vs, va, vm, vd,
        add_diagonal(p.bb, noise.b), p.bs, p.ba, p.bm, p.bd,
        p.ss, p.sa, p.sm, p.sd,
        add_diagonal(p.aa, noise.a), p.am, p.ad,
        add_diagonal(p.mm, noise.m), p.md,
        p.dd,
    )  # fmt: skip


def cross_covariance(p: Covariance, h: Measurement) -> CrossCovariance:
    """P h, block by block."""
    t = _sum5(mat_vec(p.tt, h.t), mat_vec(p.tv, h.v), mat_vec(p.tb, h.b), mat_vec(p.tm, h.m), mat_vec(p.td, h.d))
    v = _sum5(mat_t_vec(p.tv, h.t), mat_vec(p.vv, h.v), mat_vec(p.vb, h.b), mat_vec(p.vm, h.m), mat_vec(p.vd, h.d))
    b = _sum5(mat_t_vec(p.tb, h.t), mat_t_vec(p.vb, h.v), mat_vec(p.bb, h.b), mat_vec(p.bm, h.m), mat_vec(p.bd, h.d))
    s = _sum5(mat_t_vec(p.ts, h.t), mat_t_vec(p.vs, h.v), mat_t_vec(p.bs, h.b), mat_vec(p.sm, h.m), mat_vec(p.sd, h.d))
    a = _sum5(mat_t_vec(p.ta, h.t), mat_t_vec(p.va, h.v), mat_t_vec(p.ba, h.b), mat_vec(p.am, h.m), mat_vec(p.ad, h.d))
    m = _sum5(mat_t_vec(p.tm, h.t), mat_t_vec(p.vm, h.v), mat_t_vec(p.bm, h.b), mat_vec(p.mm, h.m), mat_vec(p.md, h.d))
    d = _sum5(
        mat_t_vec(p.td, h.t), mat_t_vec(p.vd, h.v), mat_t_vec(p.bd, h.b), mat_t_vec(p.md, h.m), mat_vec(p.dd, h.d)
    )
    return CrossCovariance(t, v, b, s, a, m, d, dot(h.t, t) + dot(h.v, v) + dot(h.b, b) + dot(h.m, m) + dot(h.d, d))


def updated_covariance(p: Covariance, g: CrossCovariance, k: float) -> Covariance:
    """P - (P h)(P h)^T k, with k = 1/(h^T P h + r): the covariance after a row of noise variance r."""
    t, v, b, s, a, m = scale(g.t, k), scale(g.v, k), scale(g.b, k), scale(g.s, k), scale(g.a, k), scale(g.m, k)
    return Covariance(
        minus_outer(p.tt, t, g.t), minus_outer(p.tv, t, g.v), minus_outer(p.tb, t, g.b), minus_outer(p.ts, t, g.s),
        minus_outer(p.ta, t, g.a), minus_outer(p.tm, t, g.m), minus_outer(p.td, t, g.d),
        minus_outer(p.vv, v, g.v), minus_outer(p.vb, v, g.b), minus_outer(p.vs, v, g.s), minus_outer(p.va, v, g.a),
        minus_outer(p.vm, v, g.m), minus_outer(p.vd, v, g.d),
        minus_outer(p.bb, b, g.b), minus_outer(p.bs, b, g.s), minus_outer(p.ba, b, g.a), minus_outer(p.bm, b, g.m),
        minus_outer(p.bd, b, g.d),
        minus_outer(p.ss, s, g.s), minus_outer(p.sa, s, g.a), minus_outer(p.sm, s, g.m), minus_outer(p.sd, s, g.d),
        minus_outer(p.aa, a, g.a), minus_outer(p.am, a, g.m), minus_outer(p.ad, a, g.d),
        minus_outer(p.mm, m, g.m), minus_outer(p.md, m, g.d),
        minus_outer(p.dd, scale(g.d, k), g.d),
    )  # fmt: skip


def with_sensor_blocks_of(before: Covariance, p: Covariance) -> Covariance:
    """p with what all errors of the sensors but the gyro's bias have among themselves as it was before."""
    return Covariance(
        p.tt, p.tv, p.tb, p.ts, p.ta, p.tm, p.td,
        p.vv, p.vb, p.vs, p.va, p.vm, p.vd,
        p.bb, p.bs, p.ba, p.bm, p.bd,
        before.ss, before.sa, before.sm, before.sd,
        before.aa, before.am, before.ad,
        before.mm, before.md,
        before.dd,
    )  # fmt: skip


def _sum5(a: Vec3, b: Vec3, c: Vec3, d: Vec3, e: Vec3) -> Vec3:
    return add(add(add(a, b), add(c, d)), e)
