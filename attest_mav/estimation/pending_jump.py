"""A time stamp that did not follow from those before it, and those that have continued from it."""

from typing import Final

from attest_mav.estimation.arrivals import Arrivals

CONFIRMING_NS: Final = 600_000_000
"""A jump is confirmed by stamps that continue from it for this long. Shorter stretches are disorder, or sent twice."""
BURST_NS: Final = 5_000_000_000
"""In a log, stamps that arrived in less than half of ``CONFIRMING_NS`` are a backlog that was sent twice, unless they
span this: recorders squeeze their times."""
FASTEST: Final = 10.0
"""On a live link message time runs at most so many times as fast as the arrivals: simulators are sped up. A stretch
that is faster is stored data, and confirms nothing."""


class PendingJump:
    """The stamps since a jump, ns, and their arrivals."""

    def __init__(self, t_ns: int, rx_ns: int, arrivals: Arrivals) -> None:
        self.last_ns = t_ns
        """The newest stamp that continues from the jump."""
        self._first_ns = t_ns
        self._rx_ns = rx_ns
        self._arrivals: Final = arrivals

    def is_confirmed_by(self, t_ns: int, rx_ns: int) -> bool:
        """Take a stamp that continues; whether those so far span enough, on both clocks."""
        self.last_ns = t_ns
        span_ns, arrived_ns = t_ns - self._first_ns, rx_ns - self._rx_ns
        if self._arrivals == Arrivals.LIVE and span_ns > FASTEST * arrived_ns + CONFIRMING_NS:
            self._first_ns, self._rx_ns = t_ns, rx_ns  # a burst, so the stretch that counts begins behind it
            return False
        if span_ns < CONFIRMING_NS:
            return False
        return 2 * arrived_ns >= CONFIRMING_NS or (self._arrivals == Arrivals.RECORDED and span_ns >= BURST_NS)

    def pace(self, rx_ns: int) -> float:
        """Message time of the stretch over its time of arrival, which must not be zero."""
        return (self.last_ns - self._first_ns) / (rx_ns - self._rx_ns)
