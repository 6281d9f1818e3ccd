"""The autopilot's clock against the host's, from exchanges of time with it (TIMESYNC).

An exchange proves bounds: the autopilot read its clock after the question was sent and before the answer came. The
offset (host minus autopilot) is the middle, uncertain by half the round trip. The exchange of the least uncertainty is
kept, which grows with its age; one that its successor's bounds contradict is dropped at once, because the clock was
stopped or set.
"""

from typing import Final

from attest_mav.vehicle_reports import TimeExchange

DRIFT: Final = 1e-3
"""Two clocks run apart by at most this, s/s; crystals by a ten-thousandth."""
SKEW_ERROR: Final = 1e-4
"""The skew is estimated once the round trips of the first and last exchange leave it no larger error, s/s."""


class ClockOffset:
    """The offset of one vehicle's clock."""

    def __init__(self) -> None:
        self.skew = 0.0
        """By how much more the offset grows than it should, s/s; 0 while it is not known."""
        self.jumps = 0
        """Exchanges that contradicted what was known."""
        self._first: TimeExchange | None = None
        self._best: TimeExchange | None = None
        self._last: TimeExchange | None = None

    @property
    def round_trip_s(self) -> float:
        """Round trip of the exchange that is used, s; 0 before there is one."""
        return 0.0 if self._best is None else self._best.round_trip_ns * 1e-9

    @property
    def is_known(self) -> bool:
        """Whether the autopilot has answered."""
        return self._best is not None

    def forget(self) -> None:
        """The autopilot's clock is another one from now on."""
        self._first = self._best = self._last = None
        self.skew = 0.0

    def take(self, exchange: TimeExchange) -> bool:
        """Take the next exchange; False when it contradicts what was known."""
        best, first = self._best, self._first
        self._last = exchange
        if best is None or first is None:
            self._first = self._best = exchange
            return True
        error_ns = abs(exchange.offset_ns - self.offset_ns(exchange.rx_ns))
        uncertain_ns = self.uncertainty_ns(exchange.rx_ns)
        if error_ns > uncertain_ns + exchange.round_trip_ns // 2:
            self.jumps += 1
            self.skew = 0.0
            self._first = self._best = exchange
            return False
        if exchange.round_trip_ns // 2 <= uncertain_ns:
            self._best = exchange
            self._estimate_skew(first, exchange)
        return True

    def offset_ns(self, rx_ns: int) -> int:
        """Host minus autopilot at that time of the host, ns; 0 before the first exchange."""
        best = self._best
        return 0 if best is None else best.offset_ns + int(self.skew * (rx_ns - best.rx_ns))

    def uncertainty_ns(self, rx_ns: int) -> int:
        """The largest error of the offset at that time, ns."""
        best = self._best
        return 0 if best is None else best.round_trip_ns // 2 + int(DRIFT * max(0, rx_ns - best.rx_ns))

    def oldest_ns(self, rx_ns: int) -> int:
        """The age of the oldest message that can arrive at that time, ns: what is sent first arrives first.

        Whatever comes with an answer is not older than its round trip.
        """
        last = self._last
        return 0 if last is None else last.round_trip_ns + max(0, rx_ns - last.rx_ns)

    def _estimate_skew(self, first: TimeExchange, last: TimeExchange) -> None:
        elapsed_ns = last.rx_ns - first.rx_ns
        if (first.round_trip_ns + last.round_trip_ns) // 2 <= SKEW_ERROR * elapsed_ns:
            self.skew = min(max((last.offset_ns - first.offset_ns) / elapsed_ns, -DRIFT), DRIFT)
