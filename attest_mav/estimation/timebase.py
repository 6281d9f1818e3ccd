"""Time steps from the timestamps that the messages carry: gaps, repeats, reordering, wraps and reboots."""

from enum import IntEnum
from typing import Final

from mypy_extensions import mypyc_attr

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
LATE_LIMIT: Final = 10
"""So many late samples in a row are no disorder: the clock has been set back, by less than a reboot shows."""

WRAP_NS: Final = (1 << 32) * 1_000_000
"""Millisecond clocks of 32 bits wrap after 49.7 days."""
WRAP_WINDOW_NS: Final = 60_000_000_000
"""A backward jump is a wrap only if the clock, continued past the wrap, would have moved on by at most this."""

_RESTART_NS: Final = 1_000_000_000


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
    """The clock went back: by more than a second, or for ``LATE_LIMIT`` samples."""
    REPEAT = 5
    """The same timestamp again: the same sample again."""
    LATE = 6
    """Up to a second back: out of order, to be dropped."""


@mypyc_attr(acyclic=True)  # as Sample
class TimeStep:
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
    """Classifies the timestamps of one lane, in order of arrival."""

    def __init__(self) -> None:
        self._last_ns = -1
        self._wrapped_ns = 0
        self.usual_s = 0.0
        """The usual step, s; 0 while it is not known."""
        self._late_count = 0

    def advance(self, t_ns: int) -> TimeStep:
        """Classify the next timestamp (ns, as the message carries it). REPEAT and LATE leave the time as it was."""
        now_ns = t_ns + self._wrapped_ns
        if self._last_ns < 0:
            self._last_ns = now_ns
            return TimeStep(StepKind.FIRST, 0.0, now_ns)
        delta_ns = now_ns - self._last_ns
        if 0 < delta_ns + WRAP_NS <= WRAP_WINDOW_NS:
            self._wrapped_ns += WRAP_NS
            now_ns += WRAP_NS
            delta_ns += WRAP_NS
        if delta_ns == 0:
            return TimeStep(StepKind.REPEAT, 0.0, now_ns)
        if -_RESTART_NS <= delta_ns < 0 and self._late_count < LATE_LIMIT:
            self._late_count += 1
            return TimeStep(StepKind.LATE, 0.0, now_ns)
        self._late_count = 0
        self._last_ns = now_ns
        if delta_ns < 0:
            self._wrapped_ns = 0
            self._last_ns = t_ns
            return TimeStep(StepKind.REBOOT, 0.0, t_ns)
        return TimeStep(self._kind(delta_ns * 1e-9), delta_ns * 1e-9, now_ns)

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
