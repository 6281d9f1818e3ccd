"""What times of arrival tell of time stamps: on a live link no message comes before it was sent.

Message time that runs ahead of the arrivals is no live data: it was stored, or it is another vehicle's. A backlog of
the same link does not run ahead; it catches up with the arrivals before it.
"""

from enum import IntEnum
from typing import Final

from attest_mav.estimation.clock_offset import DRIFT

CLOCK_EXCESS: Final = 0.05
"""Message time gains at most this on the arrivals of a live stream, s/s, unless a jump was confirmed at another pace.
Crystals differ by a ten-thousandth; a latency that becomes shorter needs the allowance, not the pace."""
PACE_MARGIN: Final = 1.2
"""A confirmed pace may be exceeded by this factor: simulators do not run evenly."""
DRIFT_STEP_NS: Final = 100_000_000
"""The least difference grows for no longer than this in silence, ns; as in ``DelayMeter``."""


class Arrivals(IntEnum):
    """The clock of the arrivals."""

    RECORDED = 0
    """A recorder's: it may be set, stand still, or be squeezed, so it bounds no time stamp."""
    LIVE = 1
    """A monotonic clock at the moment of reception."""


class ArrivalPace:
    """Bounds how far ahead of the arrivals the stamps of one live stream can be, from ``begin`` on."""

    def __init__(self) -> None:
        self._least_ns = 0
        self._rx_ns = 0
        self._excess = CLOCK_EXCESS

    def lead_ns(self, t_ns: int, rx_ns: int, least_ns: int) -> int:
        """By how much a message comes before it can have been sent, ns; negative for one that comes after.

        least_ns: the smallest recent arrival minus stamp, where more is known of it.
        """
        return max(self._fallen_ns(rx_ns), least_ns) - (rx_ns - t_ns)

    def take(self, t_ns: int, rx_ns: int) -> None:
        """Take a stamp that follows."""
        grown_ns = self._least_ns + int(DRIFT * min(rx_ns - self._rx_ns, DRIFT_STEP_NS))
        self._least_ns = max(min(grown_ns, rx_ns - t_ns), self._fallen_ns(rx_ns))
        self._rx_ns = rx_ns

    def begin(self, t_ns: int, rx_ns: int, pace: float) -> None:
        """Begin anew with a stamp that is believed. pace: of message time, in seconds a second of arrivals."""
        self._least_ns = rx_ns - t_ns
        self._rx_ns = rx_ns
        self._excess = max(CLOCK_EXCESS, PACE_MARGIN * pace - 1.0)

    def _fallen_ns(self, rx_ns: int) -> int:
        """The least difference at that time, if message time has gained all that it may."""
        return self._least_ns - int(self._excess * (rx_ns - self._rx_ns))
