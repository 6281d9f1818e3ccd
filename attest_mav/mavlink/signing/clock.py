"""The timestamps of our own signatures: they run with the time of day, strictly grow, and never go back.

The host tells the time of day at the start and from time to time, since the clock of a small computer is often set
long after its start. A correct signature with a later timestamp moves ours forward, as in the reference
implementation: whoever signs with the key is believed, and a receiver refuses frames that are a minute older than its
own time. The time is kept over a restart, so that a clock that was set back meanwhile costs nothing.
"""

from typing import Final

from attest_mav.mavlink.signing.signature import LATEST, TICK_NS, timestamp_of

RESERVE: Final = 60 * 100_000
"""Ticks that may have been used since the time was last kept: a minute."""


class SigningClock:
    """Timestamps for signatures. ``advance`` tells the host's monotonic time, ``set_time`` the time of day."""

    def __init__(self) -> None:
        self._now_ns = 0
        self._offset = 0  # ticks from the host's monotonic clock to timestamps; it only grows
        self._last = 0

    def begin(self, kept: int, unix_ns: int, now_ns: int) -> None:
        """Start at the time of day, or a minute after the timestamp kept last where the clock is behind that one."""
        self.set_time(unix_ns, now_ns)
        if self.timestamp <= kept:
            self.follow(min(kept + RESERVE, LATEST))

    def advance(self, now_ns: int) -> None:
        """Take the time of the host's monotonic clock."""
        self._now_ns = now_ns

    def set_time(self, unix_ns: int, now_ns: int) -> None:
        """The time of day is ``unix_ns``; one that is behind ours changes nothing."""
        self.advance(now_ns)
        self.follow(timestamp_of(unix_ns))

    def follow(self, timestamp: int) -> None:
        """Go on from this timestamp if it is later than ours."""
        self._offset = max(self._offset, timestamp - self._now_ns // TICK_NS)

    @property
    def now_ns(self) -> int:
        """The host's monotonic time, as told last."""
        return self._now_ns

    @property
    def timestamp(self) -> int:
        """Our time: no signature of ours is later."""
        return max(self._last, self._offset + self._now_ns // TICK_NS)

    def take(self) -> int:
        """A timestamp for one signature, later than all before it."""
        self._last = max(self._last + 1, self._offset + self._now_ns // TICK_NS)
        return self._last
