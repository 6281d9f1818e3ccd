"""The reference attitude as a function of time, over the last few seconds of a log."""

from bisect import bisect_right
from math import atan2, sqrt
from typing import Final

from attest_mav.algebra import q_conj, q_continuous, q_exp, q_mul
from attest_mav.types import Quat, Vec3

MAX_GAP_NS: Final = 350_000_000
"""No interpolation over a longer gap of the reference: at flight rates it would err by degrees."""
STAMP_NS: Final = 1_000_000
"""References have stamps of whole milliseconds, cut off: a stamp stands for any instant of its millisecond."""
MEMORY_NS: Final = 4_000_000_000
"""Older samples are forgotten. No attitude to be compared is further away from the newest sample."""
CLOCK_BACK_NS: Final = 1_000_000_000
"""A stamp further back than this is a restarted clock; one less far back is out of order."""


class Knot:
    """One sample of the reference."""

    def __init__(self, t_ns: int, q_nb: Quat, rates: Vec3 | None) -> None:
        self.t_ns: Final = t_ns
        self.q_nb: Final = q_nb
        self.rates: Final = rates
        """Body angular rate, rad/s; None if not known."""


class ReferenceTrack:
    """Takes the samples of the reference in order, and gives its attitude at times near the newest one."""

    def __init__(self) -> None:
        self._knots: list[Knot] = []
        self._times: list[int] = []

    def add(self, t_ns: int, q_nb: Quat, rates: Vec3 | None) -> None:
        """Take the next sample. One out of order is dropped; after a restart of the clock all earlier ones are."""
        if self._times and t_ns <= self._times[-1]:
            if t_ns >= self._times[-1] - CLOCK_BACK_NS:
                return
            self._forget(len(self._times))
        self._times.append(t_ns)
        self._knots.append(Knot(t_ns, q_nb, rates))
        if t_ns - self._times[0] > 2 * MEMORY_NS:
            self._forget(bisect_right(self._times, t_ns - MEMORY_NS))

    def _forget(self, count: int) -> None:
        """Drop the oldest samples: seldom and many at once, so that the cost per sample is small."""
        del self._times[:count]
        del self._knots[:count]

    def reaches(self, t_ns: int) -> bool:
        """True if further samples cannot change ``at`` for this time."""
        return bool(self._times) and t_ns < self._times[-1] + STAMP_NS

    def at(self, t_ns: int) -> Quat | None:
        """The reference's attitude then; None before its first sample, after its last, and inside a gap."""
        above = bisect_right(self._times, t_ns)
        if above == 0:
            return None
        before = self._knots[above - 1]
        if t_ns < before.t_ns + STAMP_NS:
            return before.q_nb
        if above == len(self._times):
            return None
        after = self._knots[above]
        if after.t_ns - before.t_ns > MAX_GAP_NS:
            return None
        return interpolate(before, after, t_ns)


def interpolate(a: Knot, b: Knot, t_ns: int) -> Quat:
    """The attitude between two samples: the turn between them as a cubic that also keeps the rates at both ends.

    With u(s) half the rotation vector from a, s in [0, 1]: u(0) = 0, u(1) = log(conj(q_a) q_b), and u' = w T/2 at
    both ends (exact at a; at b for a small turn). Without rates the turn is even. At 4 Hz in flight the rates bring
    the error of the interpolated truth from 0.6 down to 0.2 deg and less.
    """
    duration_ns = b.t_ns - a.t_ns
    s = (t_ns - a.t_ns) / duration_ns
    u = half_rotation_vector(q_mul(q_conj(a.q_nb), b.q_nb))
    if a.rates is None or b.rates is None:
        return q_mul(a.q_nb, q_exp((s * u[0], s * u[1], s * u[2])))
    half_s = 0.5e-9 * duration_ns
    at_a = half_s * s * (1.0 - s) * (1.0 - s)
    at_b = half_s * s * s * (s - 1.0)
    share = s * s * (3.0 - 2.0 * s)
    return q_mul(
        a.q_nb,
        q_exp(
            (
                share * u[0] + at_a * a.rates[0] + at_b * b.rates[0],
                share * u[1] + at_a * a.rates[1] + at_b * b.rates[1],
                share * u[2] + at_a * a.rates[2] + at_b * b.rates[2],
            )
        ),
    )


def half_rotation_vector(q: Quat) -> Vec3:
    """The u with q = exp(u) of ``algebra.q_exp``, the short way round: half the rotation vector, rad."""
    w, x, y, z = q_continuous(q, (1.0, 0.0, 0.0, 0.0))
    length = sqrt(x * x + y * y + z * z)
    scale = atan2(length, w) / length if length > 0.0 else 1.0
    return (scale * x, scale * y, scale * z)
