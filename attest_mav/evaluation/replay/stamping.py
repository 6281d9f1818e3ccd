"""Times for attitude messages that carry none (SIM_STATE, SIMSTATE, AHRS2).

Their sender packs them in one burst with its ATTITUDE, which carries a time and goes first. The order in the log is
the order of packing; arrival times are not: on a slow link, or when a ground station reads several bursts at once,
the next burst's ATTITUDE can lie nearer.
"""

from typing import Final

MAX_APART_NS: Final = 100_000_000
"""A burst can take this long on a slow serial link; an ATTITUDE further back belongs to another one, ours was lost."""


class BurstStamp:
    """Lends the time of each timed message to at most one untimed message after it."""

    def __init__(self) -> None:
        self._t_ns = -1
        self._rx_ns = 0
        self._lent = True

    def timed(self, t_ns: int, rx_ns: int) -> None:
        """A message with a time has come."""
        self._t_ns = t_ns
        self._rx_ns = rx_ns
        self._lent = False

    def time_of_untimed(self, rx_ns: int) -> int | None:
        """The sensor time of an untimed message that arrives now; None when its burst's timed one is missing."""
        if self._lent or abs(rx_ns - self._rx_ns) > MAX_APART_NS:
            return None
        self._lent = True
        return self._t_ns
