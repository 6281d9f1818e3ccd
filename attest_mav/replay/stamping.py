"""Times for attitude messages without one, from a timed message of the same sender.

Streams of one rate are sent in bursts, so an untimed message takes the time of the timed one of its burst: the one
before or the one after, whichever is usually nearer. The usual distance decides, not the single arrival: a ground
station that reads several bursts at once can give the message of the next burst the nearer arrival.

If the two usually arrive further apart than a burst lasts, they are not sent together. The time is then that of the
nearest timed message, moved by the difference of the arrivals.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.record import Record
from attest_mav.samples import AttitudeSample

BURST_NS: Final = 10_000_000
"""Messages that usually arrive within this time of each other are sent in one burst."""
MAX_APART_NS: Final = 100_000_000
"""Two messages further apart belong to different bursts: one was lost."""
MEMORY: Final = 0.95
"""The usual distance is an exponential average with this weight of the past per message; stream rates can change."""


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Stamped(Record):
    """An untimed sample with the time found for it, on the sensor's clock."""

    def __init__(self, sample: AttitudeSample, t_ns: int) -> None:
        self.sample: Final = sample
        self.t_ns: Final = t_ns


class BurstStamp:
    """Finds the time of each untimed sample at the next timed message."""

    def __init__(self) -> None:
        self._t_ns = -1
        self._rx_ns = 0
        self._is_lent = True
        self._held: AttitudeSample | None = None
        self._before_ns = -1.0
        self._after_ns = -1.0

    def timed(self, t_ns: int, rx_ns: int) -> Stamped | None:
        """A timed message has come. Returns the untimed sample before it with its time, if there is one."""
        sample = self._held
        self._held = None
        found: Stamped | None = None
        if sample is not None:
            before_ns, after_ns = sample.rx_ns - self._rx_ns, rx_ns - sample.rx_ns
            if not self._is_lent:
                self._learn(before_ns, after_ns)
            if min(self._before_ns, self._after_ns) > BURST_NS:
                found = self._moved(sample, before_ns, t_ns, after_ns)
            elif self._before_ns <= self._after_ns:
                found = self._from_before(sample)
            elif after_ns <= MAX_APART_NS:
                found = Stamped(sample, t_ns)
        self._t_ns = t_ns
        self._rx_ns = rx_ns
        self._is_lent = False
        return found

    def untimed(self, sample: AttitudeSample) -> Stamped | None:
        """An untimed sample has come. Returns the one before it with its time, if no timed message came in between."""
        sooner = self.finish()
        self._held = sample
        return sooner

    def finish(self) -> Stamped | None:
        """The last untimed sample with the time of the message before it, as no timed message follows."""
        sample = self._held
        self._held = None
        return self._from_before(sample) if sample is not None and self._before_ns <= self._after_ns else None

    def _learn(self, before_ns: int, after_ns: int) -> None:
        """Update the usual distances to both neighbours; each is limited to ``MAX_APART_NS``."""
        before = float(min(abs(before_ns), MAX_APART_NS))
        after = float(min(abs(after_ns), MAX_APART_NS))
        if self._before_ns < 0.0:
            self._before_ns, self._after_ns = before, after
        self._before_ns += (1.0 - MEMORY) * (before - self._before_ns)
        self._after_ns += (1.0 - MEMORY) * (after - self._after_ns)

    def _from_before(self, sample: AttitudeSample) -> Stamped | None:
        """The time of the timed message before, if near and not yet taken by another sample."""
        if self._is_lent or abs(sample.rx_ns - self._rx_ns) > MAX_APART_NS:
            return None
        self._is_lent = True
        return Stamped(sample, self._t_ns)

    def _moved(self, sample: AttitudeSample, before_ns: int, t_ns: int, after_ns: int) -> Stamped | None:
        """The nearest timed message's time, moved by the difference of the arrivals."""
        if before_ns <= after_ns:
            near = self._t_ns >= 0 and abs(before_ns) <= MAX_APART_NS
            return Stamped(sample, self._t_ns + before_ns) if near else None
        return Stamped(sample, t_ns - after_ns) if abs(after_ns) <= MAX_APART_NS else None
