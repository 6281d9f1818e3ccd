"""The covariance of the flight filter as named blocks, and how a step propagates it.

The error state is eight vectors of three, each the true value minus the estimate:

    t  attitude, as a rotation in NED: C_true = exp([t]x) C           rad
    v  velocity in NED                                                m/s
    b  gyro bias in the body                                          rad/s
    s  gyro scale error, per axis                                     1
    a  accelerometer bias in the body                                 m/s^2
    m  hard iron, the magnetometer's bias in the body                 gauss
    d  delay of the magnetometer, delay of the velocity fixes,        s, s, rad
       declination
    r  drift rate of the gyro bias in the body                        rad/s^2

``tv`` is the block E[t v^T]; the lower half is the transpose of the upper one and not kept. Only t, v, b and r change
with time, so a step touches their rows and leaves the rest alone. Gyro bias and scale error act through one vector, the
rate error e = b + diag(rate) s. The drift rate is a first-order Gauss-Markov process. The attitude error is global, as
in Sola, Quaternion kinematics for the error-state Kalman filter (2017), section 7; the propagation is that of Groves,
Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems (2nd ed.), section 14.2, for some seconds
over a flat Earth that does not turn.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.matrices import (
    add_diagonal,
    mat_add,
    mat_scale,
    minus_cross,
    minus_mul,
    minus_mul_t,
    no_negative_variance,
    plus_scaled,
    plus_scaled_rows,
    symmetric,
    transpose,
)
from attest_mav.record import Record
from attest_mav.types import Mat3, Vec3


@mypyc_attr(acyclic=True, free_list_len=1)
class Covariance(Record):
    """The upper blocks, three rows each, in the order of the rows of P."""

    def __init__(
        self,
        tt: Mat3,
        tv: Mat3,
        tb: Mat3,
        ts: Mat3,
        ta: Mat3,
        tm: Mat3,
        td: Mat3,
        tr: Mat3,
        vv: Mat3,
        vb: Mat3,
        vs: Mat3,
        va: Mat3,
        vm: Mat3,
        vd: Mat3,
        vr: Mat3,
        bb: Mat3,
        bs: Mat3,
        ba: Mat3,
        bm: Mat3,
        bd: Mat3,
        br: Mat3,
        ss: Mat3,
        sa: Mat3,
        sm: Mat3,
        sd: Mat3,
        sr: Mat3,
        aa: Mat3,
        am: Mat3,
        ad: Mat3,
        ar: Mat3,
        mm: Mat3,
        md: Mat3,
        mr: Mat3,
        dd: Mat3,
        dr: Mat3,
        rr: Mat3,
    ) -> None:
        self.tt: Final = tt
        self.tv: Final = tv
        self.tb: Final = tb
        self.ts: Final = ts
        self.ta: Final = ta
        self.tm: Final = tm
        self.td: Final = td
        self.tr: Final = tr
        self.vv: Final = vv
        self.vb: Final = vb
        self.vs: Final = vs
        self.va: Final = va
        self.vm: Final = vm
        self.vd: Final = vd
        self.vr: Final = vr
        self.bb: Final = bb
        self.bs: Final = bs
        self.ba: Final = ba
        self.bm: Final = bm
        self.bd: Final = bd
        self.br: Final = br
        self.ss: Final = ss
        self.sa: Final = sa
        self.sm: Final = sm
        self.sd: Final = sd
        self.sr: Final = sr
        self.aa: Final = aa
        self.am: Final = am
        self.ad: Final = ad
        self.ar: Final = ar
        self.mm: Final = mm
        self.md: Final = md
        self.mr: Final = mr
        self.dd: Final = dd
        self.dr: Final = dr
        self.rr: Final = rr

    def blocks(self) -> list[Mat3]:
        """All blocks in the constructor's order, for edits that are too rare to be written out."""
        return [
            self.tt, self.tv, self.tb, self.ts, self.ta, self.tm, self.td, self.tr,
            self.vv, self.vb, self.vs, self.va, self.vm, self.vd, self.vr,
            self.bb, self.bs, self.ba, self.bm, self.bd, self.br,
            self.ss, self.sa, self.sm, self.sd, self.sr,
            self.aa, self.am, self.ad, self.ar,
            self.mm, self.md, self.mr,
            self.dd, self.dr,
            self.rr,
        ]  # fmt: skip

    @property
    def tilt_variance(self) -> float:
        """Variance of the angle between true and estimated vertical, rad^2."""
        return max(0.0, self.tt[0][0] + self.tt[1][1])

    @property
    def heading_variance(self) -> float:
        """Variance of the rotation about the vertical, rad^2."""
        return max(0.0, self.tt[2][2])

    @property
    def is_valid(self) -> bool:
        """False once a variance is negative or not a number."""
        return (
            no_negative_variance(self.tt)
            and no_negative_variance(self.vv)
            and no_negative_variance(self.bb)
            and no_negative_variance(self.ss)
            and no_negative_variance(self.aa)
            and no_negative_variance(self.mm)
            and no_negative_variance(self.dd)
            and no_negative_variance(self.rr)
        )


@mypyc_attr(acyclic=True, free_list_len=1)
class ProcessNoise(Record):
    """Variances that one step adds, per axis but for the velocity. Scale error, delays and declination are constant."""

    def __init__(self, t: float, v: Mat3, b: float, a: float, m: float, r: float) -> None:
        self.t: Final = t
        """Attitude, rad^2."""
        self.v: Final = v
        """Velocity, NED, (m/s)^2: vibration has an axis."""
        self.b: Final = b
        """Gyro bias, (rad/s)^2."""
        self.a: Final = a
        """Accelerometer bias, (m/s^2)^2."""
        self.m: Final = m
        """Hard iron, gauss^2."""
        self.r: Final = r
        """Drift rate of the gyro bias, (rad/s^2)^2."""


def propagated(p: Covariance, rotation_dt: Mat3, delta_velocity: Vec3, rate: Vec3, noise: ProcessNoise) -> Covariance:
    """P after a step: t' = t - D e, v' = v - [u]x t' - D a, with the rate error e = b + W s. For b, r: ``drifted``.

    rotation_dt: D = C dt. delta_velocity: u = C f dt, m/s. rate: rad/s, the diagonal of W. Written row by row: first
    the rows of t, then those of v, then the blocks of t' and v' with themselves.
    """
    bs_t = transpose(p.bs)
    tb = minus_mul(p.tb, rotation_dt, plus_scaled_rows(p.bb, rate, bs_t))
    ts = minus_mul(p.ts, rotation_dt, plus_scaled_rows(p.bs, rate, p.ss))
    ta = minus_mul(p.ta, rotation_dt, plus_scaled_rows(p.ba, rate, p.sa))
    tm = minus_mul(p.tm, rotation_dt, plus_scaled_rows(p.bm, rate, p.sm))
    td = minus_mul(p.td, rotation_dt, plus_scaled_rows(p.bd, rate, p.sd))
    tr = minus_mul(p.tr, rotation_dt, plus_scaled_rows(p.br, rate, p.sr))
    t_old_v = minus_mul(p.tv, rotation_dt, plus_scaled_rows(transpose(p.vb), rate, transpose(p.vs)))
    t_old_t = minus_mul(p.tt, rotation_dt, plus_scaled_rows(transpose(p.tb), rate, transpose(p.ts)))
    te = transpose(plus_scaled_rows(transpose(tb), rate, transpose(ts)))
    tt = minus_mul_t(t_old_t, te, rotation_dt)
    vb = minus_mul_t(minus_cross(p.vb, delta_velocity, tb), rotation_dt, p.ba)
    vs = minus_mul_t(minus_cross(p.vs, delta_velocity, ts), rotation_dt, p.sa)
    va = minus_mul(minus_cross(p.va, delta_velocity, ta), rotation_dt, p.aa)
    vm = minus_mul(minus_cross(p.vm, delta_velocity, tm), rotation_dt, p.am)
    vd = minus_mul(minus_cross(p.vd, delta_velocity, td), rotation_dt, p.ad)
    vr = minus_mul(minus_cross(p.vr, delta_velocity, tr), rotation_dt, p.ar)
    vt = minus_mul_t(minus_cross(transpose(t_old_v), delta_velocity, tt), rotation_dt, ta)
    v_old_v = minus_mul_t(minus_cross(p.vv, delta_velocity, t_old_v), rotation_dt, p.va)
    tv = transpose(vt)
    vv = minus_mul_t(transpose(minus_cross(transpose(v_old_v), delta_velocity, tv)), va, rotation_dt)
    return Covariance(
        add_diagonal(symmetric(tt), noise.t), tv, tb, ts, ta, tm, td, tr,
        mat_add(symmetric(vv), noise.v), vb, vs, va, vm, vd, vr,
        add_diagonal(p.bb, noise.b), p.bs, p.ba, p.bm, p.bd, p.br,
        p.ss, p.sa, p.sm, p.sd, p.sr,
        add_diagonal(p.aa, noise.a), p.am, p.ad, p.ar,
        add_diagonal(p.mm, noise.m), p.md, p.mr,
        p.dd, p.dr,
        add_diagonal(p.rr, noise.r),
    )  # fmt: skip


def drifted(p: Covariance, dt_s: float, kept: float) -> Covariance:
    """P after b' = b + r dt and r' = c r. kept: c, the share of the drift rate that outlasts the step."""
    br = plus_scaled(p.br, dt_s, p.rr)
    bb = plus_scaled(plus_scaled(p.bb, dt_s, br), dt_s, transpose(p.br))
    bs, ba = plus_scaled(p.bs, dt_s, transpose(p.sr)), plus_scaled(p.ba, dt_s, transpose(p.ar))
    bm, bd = plus_scaled(p.bm, dt_s, transpose(p.mr)), plus_scaled(p.bd, dt_s, transpose(p.dr))
    return Covariance(
        p.tt, p.tv, plus_scaled(p.tb, dt_s, p.tr), p.ts, p.ta, p.tm, p.td, mat_scale(p.tr, kept),
        p.vv, plus_scaled(p.vb, dt_s, p.vr), p.vs, p.va, p.vm, p.vd, mat_scale(p.vr, kept),
        bb, bs, ba, bm, bd, mat_scale(br, kept),
        p.ss, p.sa, p.sm, p.sd, mat_scale(p.sr, kept),
        p.aa, p.am, p.ad, mat_scale(p.ar, kept),
        p.mm, p.md, mat_scale(p.mr, kept),
        p.dd, mat_scale(p.dr, kept),
        mat_scale(p.rr, kept * kept),
    )  # fmt: skip
