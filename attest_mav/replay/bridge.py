"""Bridges between two samples of the reference, and the error that a bridge may have.

The bound was measured on the simulator's flights (a copter's corners, a plane in turbulence), thinned to 0.6 to 10 Hz:
the largest error inside a bridge stays below ``ERROR_SHARE`` times (change of the rates times time, plus twice the turn
that the rates miss) on more than nine of ten bridges, whatever their length.
"""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from math import atan2, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, q_conj, q_continuous, q_exp, q_mul, scale, sub
from attest_mav.record import Record
from attest_mav.types import Quat, Vec3

ERROR_SHARE: Final = 0.15
"""Error over the measure above, in the middle of a bridge."""
EVEN_SHARE: Final = 0.25
"""Error over turn for a bridge without rates: an even turn in the place of one that begins at rest."""


@mypyc_attr(acyclic=True)  # as Sample
class Knot(Record):
    """One sample of the reference."""

    def __init__(self, t_ns: int, q_nb: Quat, rates: Vec3 | None) -> None:
        self.t_ns: Final = t_ns
        self.q_nb: Final = q_nb
        self.rates: Final = rates
        """Body angular rate, rad/s; None if not known."""


@mypyc_attr(acyclic=True)  # as Sample
class RateReading(Record):
    """One reading of the gyro."""

    def __init__(self, t_ns: int, rates: Vec3) -> None:
        self.t_ns: Final = t_ns
        self.rates: Final = rates
        """Body angular rate, rad/s."""


class RatePath:
    """The attitude from one sample to the next by the rates between them; ``readings`` are in order and inside."""

    def __init__(self, a: Knot, b: Knot, readings: Sequence[RateReading]) -> None:
        first = readings[0].rates if a.rates is None else a.rates
        last = readings[-1].rates if b.rates is None else b.rates
        nodes = [RateReading(a.t_ns, first), *readings, RateReading(b.t_ns, last)]
        self.a: Final = a
        self.b: Final = b
        self._nodes: Final = nodes
        self._times: Final = [node.t_ns for node in nodes]
        attitudes = [a.q_nb]
        square = 0.0
        for before, after in pairwise(nodes):
            dt_s = (after.t_ns - before.t_ns) * 1e-9
            attitudes.append(q_mul(attitudes[-1], q_exp(scale(add(before.rates, after.rates), 0.25 * dt_s))))
            square += (dt_s * norm(sub(after.rates, before.rates))) ** 2
        self._attitudes: Final = attitudes
        self._missed: Final = half_rotation_vector(q_mul(q_conj(attitudes[-1]), b.q_nb))
        self._measure: Final = sqrt(square) + 4.0 * norm(self._missed)

    def error_bound(self, t_ns: int) -> float:
        """The error that the attitude then may have, rad."""
        return ERROR_SHARE * self._measure * _shape(self.a, self.b, t_ns)

    def at(self, t_ns: int) -> Quat:
        """The attitude then; what the rates miss is spread over the whole so that the rates at both ends stay."""
        place = min(bisect_right(self._times, t_ns), len(self._nodes) - 1) - 1
        before, after = self._nodes[place], self._nodes[place + 1]
        dt_s = (t_ns - before.t_ns) * 1e-9
        change = scale(sub(after.rates, before.rates), (t_ns - before.t_ns) / (after.t_ns - before.t_ns))
        turned = q_mul(self._attitudes[place], q_exp(scale(add(scale(before.rates, 2.0), change), 0.25 * dt_s)))
        s = (t_ns - self.a.t_ns) / (self.b.t_ns - self.a.t_ns)
        return q_mul(turned, q_exp(scale(self._missed, s * s * (3.0 - 2.0 * s))))


def error_bound(a: Knot, b: Knot, t_ns: int) -> float:
    """The error that ``interpolate`` may have then, rad."""
    turn = scale(half_rotation_vector(q_mul(q_conj(a.q_nb), b.q_nb)), 2.0)
    if a.rates is None or b.rates is None:
        s = (t_ns - a.t_ns) / (b.t_ns - a.t_ns)
        return EVEN_SHARE * norm(turn) * 4.0 * s * (1.0 - s)
    duration_s = (b.t_ns - a.t_ns) * 1e-9
    missed = sub(scale(add(a.rates, b.rates), 0.5 * duration_s), turn)
    return ERROR_SHARE * (duration_s * norm(sub(b.rates, a.rates)) + 2.0 * norm(missed)) * _shape(a, b, t_ns)


def _shape(a: Knot, b: Knot, t_ns: int) -> float:
    """The error of a cubic between two samples over its error in the middle."""
    s = (t_ns - a.t_ns) / (b.t_ns - a.t_ns)
    return 16.0 * s * s * (1.0 - s) * (1.0 - s)


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
