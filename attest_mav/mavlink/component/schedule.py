"""How often an output is sent on a link: at its own rate, or for a while at one that another station has set.

Commands on a MAVLink network carry no proof of their sender. An interval that somebody else sets is therefore bounded,
carries the name of the station that set it, and ends: after ``HELD_NS``, or ``GONE_NS`` after that station was last
heard. A station that wants an interval for longer repeats its command.
"""

from typing import Final

SHORTEST_NS: Final = 10_000_000
LONGEST_NS: Final = 10_000_000_000
"""Bounds of an interval that others set, ns: 100 Hz and 0.1 Hz."""
HELD_NS: Final = 600_000_000_000
"""An interval that others have set ends after this time."""
GONE_NS: Final = 30_000_000_000
"""A station that has not been heard for this long is gone, and its interval ends."""
STOPPED: Final = -1
"""The period of an output that is not sent."""


class Station:
    """A MAVLink component that sends us commands."""

    def __init__(self, system: int, component: int) -> None:
        self.system: Final = system
        self.component: Final = component

    @property
    def name(self) -> str:
        """Its ids, for people."""
        return f"{self.system}/{self.component}"


class Interval:
    """An interval that a station has set. ``period_ns``: ns, STOPPED for none."""

    def __init__(self, station: Station, period_ns: int, now_ns: int) -> None:
        self.station: Final = station
        self.period_ns: Final = period_ns
        self.set_ns: Final = now_ns
        self.heard_ns = now_ns

    def ended(self, now_ns: int) -> str:
        """Why it ends now, "" where it goes on."""
        if now_ns - self.heard_ns >= GONE_NS:
            return f"{self.station.name} is gone"
        return f"set {HELD_NS // 60_000_000_000} minutes ago" if now_ns - self.set_ns >= HELD_NS else ""


class Schedule:
    """Lets through as many samples of a clock as a rate allows. ``period_ns`` 0 lets all through, < 0 none."""

    def __init__(self, period_ns: int) -> None:
        self.interval: Interval | None = None
        """The interval that another station has set, None for our own."""
        self._own_ns: Final = period_ns
        self._next_ns = -1

    @property
    def period_ns(self) -> int:
        """The period that holds now, ns."""
        return self._own_ns if self.interval is None else self.interval.period_ns

    @property
    def rate_text(self) -> str:
        """The rate that holds now, for people."""
        period_ns = self.period_ns
        if period_ns < 0:
            return "0 Hz"
        return "every sample" if period_ns == 0 else f"{1e9 / period_ns:.3g} Hz"

    def set_by(self, station: Station, period_ns: int, now_ns: int) -> bool:
        """Take an interval of a station for a while; whether that changes the rate."""
        before_ns = self.period_ns
        self.interval = Interval(station, period_ns, now_ns)
        return period_ns != before_ns

    def restore(self) -> bool:
        """Go back to our own rate; whether that changes it."""
        before_ns = self.period_ns
        self.interval = None
        return self.period_ns != before_ns

    def due(self, t_ns: int) -> bool:
        """Whether the sample at ``t_ns`` is to be sent. A tenth of a period early still counts: clocks jitter."""
        period_ns = self.period_ns
        if period_ns <= 0:
            return period_ns == 0
        ahead_ns = self._next_ns - t_ns
        if period_ns // 10 < ahead_ns <= 2 * period_ns:  # further ahead, the clock has gone back
            return False
        self._next_ns = self._next_ns + period_ns if abs(ahead_ns) <= period_ns else t_ns + period_ns
        return True
