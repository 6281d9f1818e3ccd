"""Delay of a sample beyond the usual delay of its link.

The two clocks have nothing in common but that they run alike, so only changes can be seen: the least recent difference
between arrival and timestamp is the quickest that a sample has come, and what exceeds it is delay. That is how a
backlog shows (a link that stalls, a host that sleeps): its samples arrive together, and are as old as they are.
"""

from typing import Final

FORGETTING: Final = 0.5
"""The least difference grows at this rate, s/s: a sensor clock that runs slow is no backlog. Crystals need a
ten-thousandth of it; simulators on a busy computer run at two thirds of real time."""
FORGETTING_STEP_S: Final = 0.1
"""Silence makes it grow for no longer than this: after a stall the backlog must still be seen whole."""


class DelayMeter:
    """Follows one lane."""

    def __init__(self) -> None:
        self._least_ns = 0
        self._last_rx_ns = -1

    def delay_s(self, t_ns: int, rx_ns: int) -> float:
        """How much later than the quickest this sample came, s; t_ns by the sensor's clock, rx_ns by the host's."""
        difference_ns = rx_ns - t_ns
        if self._last_rx_ns < 0:
            self._least_ns = difference_ns
        else:
            silence_s = min((rx_ns - self._last_rx_ns) * 1e-9, FORGETTING_STEP_S)
            grown_ns = self._least_ns + int(1e9 * FORGETTING * max(0.0, silence_s))
            self._least_ns = min(grown_ns, difference_ns)
        self._last_rx_ns = rx_ns
        return (difference_ns - self._least_ns) * 1e-9
