"""Time steps from the timestamps that the messages carry: gaps, repeats, reordering, wraps, reboots and stray stamps.

A stamp that does not follow from those before it is not believed at once. It begins a pending jump, which the stamps
that come next confirm, by continuing from it, or refute, by continuing from where the time was.
"""

from enum import IntEnum
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.estimation.arrivals import ArrivalPace, Arrivals
from attest_mav.estimation.pending_jump import PendingJump
from attest_mav.record import Record

GAP_S: Final = 0.1
GAP_PERIODS: Final = 2.5
"""A step longer than both, the second in usual steps, is a gap: the filter goes on, and the gap is counted. A stream
of 4 Hz has no gaps in it; it is slow."""
USUAL_SHARE: Final = 0.1
"""Share of a new step in the running mean that is the usual one."""
RESTART_S: Final = 1.0
"""After a longer gap the motion in between is lost: the filter starts again. A stream of 1 Hz has no gaps in it."""
LONGEST_STEP_S: Final = 3.0
"""After a longer step it is lost whatever the stream's interval is."""

EARLY_PERIODS: Final = 5.0
"""A step forward by more usual steps (or more than ``RESTART_S``), with a stamp that is early by more of them too, does
not follow: no sample can come before it was taken. After a true gap the arrival is as far ahead as the stamp."""
LATE_NS: Final = 1_000_000_000
"""A stamp further back than this is stray, a nearer one late: out of order."""
LEAD_NS: Final = 100_000_000
"""On a live link a stamp ahead of its arrival by more does not follow either, however small its step: a burst of
stored messages that goes on from the newest stamp would run ahead in ordinary steps."""

WRAP_NS: Final = (1 << 32) * 1_000_000
"""Millisecond clocks of 32 bits wrap after 49.7 days."""
WRAP_WINDOW_NS: Final = 60_000_000_000
"""A jump is a wrap only if the clock, continued past the wrap, would have moved by at most this."""


class StepKind(IntEnum):
    """Meaning of a timestamp after the one before it."""

    FIRST = 0
    STEP = 1
    """An ordinary step."""
    GAP = 2
    """A step much longer than usual: samples are missing."""
    RESTART = 3
    """A longer one."""
    REBOOT = 4
    """The clock went back, as the stamps after it have confirmed."""
    REPEAT = 5
    """The same timestamp again: the same sample again."""
    LATE = 6
    """Up to a second back: out of order, to be dropped."""
    STRAY = 7
    """Further back, or ahead of its own arrival: to be dropped, unless the next stamps continue from it."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class TimeStep(Record):
    """One classified step. ``dt_s`` is positive for STEP, GAP and RESTART and 0 otherwise.

    ``t_ns`` is the timestamp unwrapped: it grows as long as the autopilot runs.
    """

    def __init__(self, kind: StepKind, dt_s: float, t_ns: int) -> None:
        self.kind: Final = kind
        self.dt_s: Final = dt_s
        self.t_ns: Final = t_ns


def wrapped_difference_ns(a_ns: int, b_ns: int) -> int:
    """a - b for two instants of one autopilot, of which one may have wrapped and the other not."""
    return (a_ns - b_ns + WRAP_NS // 2) % WRAP_NS - WRAP_NS // 2


class TimeBase:
    """Classifies the timestamps of one lane, in order of arrival. arrivals: the clock that tells it."""

    def __init__(self, arrivals: Arrivals = Arrivals.RECORDED) -> None:
        self._last_ns = -1
        self._wrapped_ns = 0
        self.usual_s = 0.0
        """The usual step, s; 0 while it is not known."""
        self.difference_ns = 0
        """Arrival minus stamp of the newest stamp that is believed, ns."""
        self.strayed_rx_ns = -1
        """Arrival of the newest stamp, where that is a stray; -1 where it follows."""
        self._arrivals: Final = arrivals
        self._pace: Final = None if arrivals == Arrivals.RECORDED else ArrivalPace()
        self._jump: PendingJump | None = None

    @property
    def is_jumping(self) -> bool:
        """Whether a jump is pending: the newest stamp did not follow."""
        return self._jump is not None

    def advance(self, t_ns: int, rx_ns: int, least_ns: int) -> TimeStep:
        """Classify the next timestamp (ns, as the message carries it). REPEAT, LATE and STRAY leave the time as it was.

        rx_ns: its arrival, host clock. least_ns: the smallest recent arrival minus stamp; no meaning before the first
        step.
        """
        now_ns = self._unwrapped(t_ns)
        delta_ns = now_ns - self._last_ns
        begins = self._last_ns < 0
        if begins:
            kind = StepKind.FIRST
        elif delta_ns == 0:
            return TimeStep(StepKind.REPEAT, 0.0, now_ns)
        elif delta_ns > 0 and not self._is_early(now_ns, rx_ns, least_ns):
            kind = self._kind(delta_ns * 1e-9)
        elif not self._is_confirmed(now_ns, rx_ns):
            if -LATE_NS <= delta_ns < 0:
                return TimeStep(StepKind.LATE, 0.0, now_ns)
            self.strayed_rx_ns = rx_ns
            return TimeStep(StepKind.STRAY, 0.0, now_ns)
        elif delta_ns < 0:
            kind, now_ns, begins = StepKind.REBOOT, t_ns, True
        else:
            kind, begins = self._kind(delta_ns * 1e-9), True
        self._believe(now_ns, rx_ns, begins)
        self._wrapped_ns = now_ns - t_ns
        is_step = kind in (StepKind.STEP, StepKind.GAP, StepKind.RESTART)
        return TimeStep(kind, delta_ns * 1e-9 if is_step else 0.0, now_ns)

    def _unwrapped(self, t_ns: int) -> int:
        """The timestamp on the clock that does not wrap, beside the newest one."""
        now_ns = t_ns + self._wrapped_ns
        delta_ns = now_ns - self._last_ns
        if self._last_ns >= 0 and 0 < delta_ns + WRAP_NS <= WRAP_WINDOW_NS:
            return now_ns + WRAP_NS
        if self._wrapped_ns > 0 and -WRAP_WINDOW_NS <= delta_ns - WRAP_NS < 0:
            return now_ns - WRAP_NS
        return now_ns

    def _is_early(self, now_ns: int, rx_ns: int, least_ns: int) -> bool:
        """Whether a step forward to this stamp does not follow: it comes before the quickest arrival."""
        if self._pace is not None and self._pace.lead_ns(now_ns, rx_ns, least_ns) > LEAD_NS:
            return True
        limit_s = min(EARLY_PERIODS * self.usual_s, RESTART_S) if self.usual_s > 0.0 else RESTART_S
        limit_ns = 1e9 * limit_s
        return now_ns - self._last_ns > limit_ns and least_ns - (rx_ns - now_ns) > limit_ns

    def _is_confirmed(self, now_ns: int, rx_ns: int) -> bool:
        """Take a stamp that does not follow: whether it confirms the pending jump. It begins one otherwise."""
        jump = self._jump
        since_ns = 0 if jump is None else now_ns - jump.last_ns
        if jump is None or not -LATE_NS <= since_ns <= int(1e9 * max(RESTART_S, GAP_PERIODS * self.usual_s)):
            self._jump = PendingJump(now_ns, rx_ns, self._arrivals)
            return False
        if since_ns <= 0:
            return False  # out of order, or repeated, within what follows from the jump
        return jump.is_confirmed_by(now_ns, rx_ns)

    def _believe(self, now_ns: int, rx_ns: int, begins: bool) -> None:
        """Go on to this stamp. begins: it is the first one, or the one that confirms the pending jump."""
        if self._pace is not None:
            if begins:
                self._pace.begin(now_ns, rx_ns, 1.0 if self._jump is None else self._jump.pace(rx_ns))
            else:
                self._pace.take(now_ns, rx_ns)
        self._jump = None
        self.strayed_rx_ns = -1
        self.difference_ns = rx_ns - now_ns
        self._last_ns = now_ns

    def _kind(self, dt_s: float) -> StepKind:
        """STEP, GAP or RESTART, by the length of a forward step; updates the usual one."""
        if dt_s > LONGEST_STEP_S:
            return StepKind.RESTART
        usual_s = self.usual_s if self.usual_s > 0.0 else dt_s
        missing = dt_s > GAP_S and dt_s > GAP_PERIODS * usual_s
        if missing and dt_s > RESTART_S:
            return StepKind.RESTART
        self.usual_s = usual_s + USUAL_SHARE * (dt_s - usual_s)
        return StepKind.GAP if missing else StepKind.STEP
