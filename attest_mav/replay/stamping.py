"""Times for attitude messages that carry none (SIM_STATE, SIMSTATE, AHRS2), from one of the same sender that does.

Streams of one rate leave in bursts, so the untimed message has the time of the timed one of its burst: the one before
it or the one behind it, whichever is usually nearer. Which of the two it is goes by the order in the log and not by the
single arrival: a ground station that reads several bursts at once stamps the next one's message nearer.

Where the two usually arrive well apart they are not sent together. Then the time is the nearest timed message's, moved
by the difference of the arrivals.
"""

from typing import Final

from attest_mav.types import AttitudeSample

BURST_NS: Final = 10_000_000
"""Messages that usually arrive nearer to each other than this are sent in one burst."""
MAX_APART_NS: Final = 100_000_000
"""Further apart two messages have nothing to do with each other: one was lost."""
MEMORY: Final = 0.95
"""What is usual is an average that forgets at this rate per message: streams change when someone asks again."""


class Stamped:
    """An untimed sample with the time found for it, on the sensor's clock."""

    def __init__(self, sample: AttitudeSample, t_ns: int) -> None:
        self.sample: Final = sample
        self.t_ns: Final = t_ns


class BurstStamp:
    """Finds the time of each untimed sample when the next timed message has come."""

    def __init__(self) -> None:
        self._t_ns = -1
        self._rx_ns = 0
        self._is_lent = True
        self._held: AttitudeSample | None = None
        self._before_ns = -1.0
        self._after_ns = -1.0

    def timed(self, t_ns: int, rx_ns: int) -> Stamped | None:
        """A timed message has come; the untimed sample before it with its time, if there is one."""
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
        """An untimed sample has come; the one before it with its time, if no timed message came between the two."""
        sooner = self.finish()
        self._held = sample
        return sooner

    def finish(self) -> Stamped | None:
        """No timed message comes behind the last untimed sample: what can be said without."""
        sample = self._held
        self._held = None
        return self._from_before(sample) if sample is not None and self._before_ns <= self._after_ns else None

    def _learn(self, before_ns: int, after_ns: int) -> None:
        """Follow how far away the neighbours usually are; distances beyond ``MAX_APART_NS`` are as bad as that."""
        before = float(min(abs(before_ns), MAX_APART_NS))
        after = float(min(abs(after_ns), MAX_APART_NS))
        if self._before_ns < 0.0:
            self._before_ns, self._after_ns = before, after
        self._before_ns += (1.0 - MEMORY) * (before - self._before_ns)
        self._after_ns += (1.0 - MEMORY) * (after - self._after_ns)

    def _from_before(self, sample: AttitudeSample) -> Stamped | None:
        """The time of the timed message before, if it is near and no other sample has it."""
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
