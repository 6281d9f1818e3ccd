"""Delay of a sample: measured where the autopilot tells its time, else beyond the usual delay of its link.

With a known offset of the clocks a sample's age is its arrival, minus the offset, minus its timestamp. Without one only
changes can be seen: the least recent difference between arrival and timestamp is the quickest that a sample has come,
and what exceeds it is delay. That is how a backlog shows (a link that stalls, a host that sleeps): its samples arrive
together, and are as old as they are.
"""

from typing import Final

from attest_mav.estimation.arrivals import Arrivals
from attest_mav.estimation.clock_offset import DRIFT, ClockOffset
from attest_mav.estimation.timebase import wrapped_difference_ns

RECORDED_DRIFT: Final = 0.5
"""For times of arrival in a log the least difference grows at this rate, s/s: recorders' clocks are set and copies
squeeze their times, simulators on a busy computer run at two thirds of real time, and nobody takes old for new."""
DRIFT_STEP_S: Final = 0.1
"""Silence makes it grow for no longer than this: after a stall the backlog must still be seen whole."""

EARLIEST_NS: Final = -1_000_000_000
SLACK_NS: Final = 500_000_000
"""A smaller age than the first, or one by more than the second beyond what the round trip allows, shows that the
timestamps do not come from the clock that answers."""
PATIENCE_NS: Final = 3_000_000_000
"""Where ages have been possible before, the second counts after this time, or after the age itself where that is
less: an answer may have overtaken a backlog, which has come by then."""


class DelayMeter:
    """Follows one lane. clock: the vehicle's. arrivals: how fast the least difference may grow."""

    def __init__(self, clock: ClockOffset, arrivals: Arrivals = Arrivals.RECORDED) -> None:
        self.least_ns = 0
        """The smallest recent arrival minus timestamp, ns; no meaning before the first sample."""
        self._clock: Final = clock
        self._drift: Final = DRIFT if arrivals == Arrivals.LIVE else RECORDED_DRIFT
        self._last_rx_ns = -1
        self._foreign_at = -1
        self._has_fitted = False
        self._too_old_since_ns = -1

    def delay_s(self, t_ns: int, rx_ns: int) -> float:
        """How late this sample came, s; t_ns by the sensor's clock, rx_ns by the host's."""
        difference_ns = rx_ns - t_ns
        if self._last_rx_ns < 0:
            self.least_ns = difference_ns
        else:
            silence_s = min((rx_ns - self._last_rx_ns) * 1e-9, DRIFT_STEP_S)
            grown_ns = self.least_ns + int(1e9 * self._drift * max(0.0, silence_s))
            self.least_ns = min(grown_ns, difference_ns)
        self._last_rx_ns = rx_ns
        clock = self._clock
        if not clock.is_known or self._foreign_at == clock.jumps:
            return (difference_ns - self.least_ns) * 1e-9
        age_ns = wrapped_difference_ns(difference_ns, clock.offset_ns(rx_ns))
        if self._is_foreign(age_ns, clock.oldest_ns(rx_ns) + SLACK_NS, rx_ns):
            self._foreign_at = clock.jumps  # until the clock that answers is found to have been set
            return (difference_ns - self.least_ns) * 1e-9
        # No sample comes before it was taken: a smaller difference was that of another setting of the clock.
        self.least_ns = max(self.least_ns, difference_ns - max(0, age_ns + clock.uncertainty_ns(rx_ns)))
        return max(0, age_ns) * 1e-9

    def _is_foreign(self, age_ns: int, oldest_ns: int, rx_ns: int) -> bool:
        """Whether no sample of the clock that answers can have this age."""
        if age_ns <= oldest_ns:
            self._too_old_since_ns = -1
            self._has_fitted = self._has_fitted or age_ns >= EARLIEST_NS
            return age_ns < EARLIEST_NS
        if not self._has_fitted:
            return True
        if self._too_old_since_ns < 0:
            self._too_old_since_ns = rx_ns
        return rx_ns - self._too_old_since_ns >= min(age_ns, PATIENCE_NS)
