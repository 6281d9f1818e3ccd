"""Our attitude at the time of the autopilot's: estimates are interpolated, or carried on a little way.

Streams are paired by their own intervals. An attitude that lies between two estimates is met by turning the nearer one
with the rates of both; one that is newer than the last estimate waits for the next one, unless that is so near that the
rates carry it there. The part of the turn that rates at the ends cannot show is ``slack``.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, q_exp, q_mul, scale, sub
from attest_mav.estimate import Estimate
from attest_mav.estimation.timebase import wrapped_difference_ns
from attest_mav.record import Record
from attest_mav.ring_buffer import RingBuffer
from attest_mav.samples import AttitudeSample
from attest_mav.types import Quat, Vec3

CARRY_S: Final = 0.1
"""An attitude newer than the last estimate by at most this does not wait for the next one, s."""
CARRY_BACK_S: Final = 0.3
"""An attitude older than all estimates kept is met by their rates over at most this time, s."""
KEPT_NS: Final = 1_000_000_000
"""Estimates are kept for this long, and at least two of them."""
MAX_KEPT: Final = 64
MAX_WAITING: Final = 32
"""Attitudes that wait for an estimate; the oldest is given up."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Carried(Record):
    """Our attitude at the time of one of the autopilot's.

    estimate: the nearest one. q_nb: carried to the instant. slack: rad, error that the carrying may have made.
    """

    def __init__(self, estimate: Estimate, q_nb: Quat, slack: float) -> None:
        self.estimate: Final = estimate
        self.q_nb: Final = q_nb
        self.slack: Final = slack


class Pairing:
    """Keeps the newest estimates, and the autopilot's attitudes that wait for the next one."""

    def __init__(self) -> None:
        self._estimates: Final[RingBuffer[Estimate]] = RingBuffer()
        self._waiting: list[AttitudeSample] = []

    @property
    def newest(self) -> Estimate | None:
        """The newest estimate, None while there is none."""
        return self._estimates.newest if self._estimates.count > 0 else None

    def take(self, estimate: Estimate) -> tuple[AttitudeSample, ...]:
        """Keep the newest estimate; the attitudes that waited for it, in order."""
        kept = self._estimates
        kept.append(estimate)
        while kept.count > 2 and (kept.count > MAX_KEPT or estimate.t_ns - kept.at(1).t_ns > KEPT_NS):
            kept.pop_oldest()
        if not self._waiting:
            return ()
        ready = tuple([one for one in self._waiting if not self._is_ahead(one, estimate)])
        self._waiting = [one for one in self._waiting if self._is_ahead(one, estimate)]
        return ready

    def forget(self) -> None:
        """There is no valid estimate any more."""
        self._estimates.clear()
        self._waiting.clear()

    def forget_waiting(self) -> None:
        """No attitude comes any more: those that still wait lead their own stream, and are given up."""
        self._waiting.clear()

    def waits(self, reference: AttitudeSample) -> bool:
        """True when the attitude is to wait for the next estimate; it is then kept until ``take``."""
        newest = self.newest
        if newest is None or not self._is_ahead(reference, newest):
            return False
        if len(self._waiting) >= MAX_WAITING:
            del self._waiting[0]
        self._waiting.append(reference)
        return True

    def at(self, t_ns: int) -> Carried | None:
        """Our attitude then, None where no estimate is near enough."""
        after: Estimate | None = None
        for index in range(self._estimates.count - 1, -1, -1):
            estimate = self._estimates.at(index)
            apart_s = wrapped_difference_ns(t_ns, estimate.t_ns) * 1e-9
            if apart_s >= 0.0:
                return _ahead(estimate, apart_s) if after is None else _between(estimate, after, apart_s)
            after = estimate
        if after is None:
            return None
        apart_s = wrapped_difference_ns(t_ns, after.t_ns) * 1e-9
        return _turned(after, after.rates, apart_s, 0.0) if apart_s >= -CARRY_BACK_S else None

    @staticmethod
    def _is_ahead(reference: AttitudeSample, estimate: Estimate) -> bool:
        return wrapped_difference_ns(reference.t_ns, estimate.t_ns) * 1e-9 > CARRY_S


def _ahead(estimate: Estimate, apart_s: float) -> Carried | None:
    """Carried on from the newest estimate."""
    return _turned(estimate, estimate.rates, apart_s, 0.0) if apart_s <= CARRY_BACK_S else None


def _between(before: Estimate, after: Estimate, since_s: float) -> Carried:
    """Between two estimates, from the nearer one; the rates change evenly from one to the other."""
    span_s = wrapped_difference_ns(after.t_ns, before.t_ns) * 1e-9
    change = sub(after.rates, before.rates)
    then = add(before.rates, scale(change, since_s / span_s))
    near, apart_s = (before, since_s) if since_s < 0.5 * span_s else (after, since_s - span_s)
    return _turned(near, scale(add(near.rates, then), 0.5), apart_s, 0.125 * norm(change) * span_s)


def _turned(estimate: Estimate, rates: Vec3, apart_s: float, slack: float) -> Carried:
    return Carried(estimate, q_mul(estimate.q_nb, q_exp(scale(rates, 0.5 * apart_s))), slack)
