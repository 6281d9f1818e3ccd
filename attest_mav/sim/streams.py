"""When which message is due. Messages of equal interval are due together, as in ArduPilot's buckets."""

from typing import Final

from attest_mav.sim.personality import Personality

OFF: Final = 0
"""Interval of a message that is not streamed."""

LONGEST_INTERVAL_US: Final = 60_000_000
"""ArduPilot streams nothing more slowly than once a minute."""


class Streams:
    """The intervals of one link, since one boot. Times are nanoseconds since that boot.

    fast_rate_hz: rate of the fast messages after boot, None for the personality's own.
    """

    def __init__(self, personality: Personality, loop_rate_hz: int, fast_rate_hz: float | None) -> None:
        self.personality = personality
        self.loop_ns = 1_000_000_000 // loop_rate_hz
        self.fast_rate_hz = fast_rate_hz
        self.names = [stream.message for stream in personality.streams]
        self.intervals: dict[str, int] = {}
        self.due_ns: dict[str, int] = {}
        self.next_ns = 0
        for name in self.names:
            # The heartbeat opens the conversation; everything else follows one interval after the boot.
            self._start(name, self.default_interval_ns(name), -1 if name == "HEARTBEAT" else 0)

    def has(self, name: str) -> bool:
        """Whether the firmware knows such a stream."""
        return name in self.intervals

    def default_interval_ns(self, name: str) -> int:
        """The interval after boot, ns; OFF for a message that is only sent when asked for."""
        stream = self.personality.streams[self.names.index(name)]
        rate_hz = self.fast_rate_hz if stream.fast and self.fast_rate_hz is not None else stream.rate_hz
        return self._allowed_ns(round(1e6 / rate_hz)) if rate_hz > 0.0 else OFF

    def set_interval_us(self, name: str, interval_us: int, now_ns: int) -> bool:
        """SET_MESSAGE_INTERVAL: 0 asks for the default, -1 (any negative number) for none.

        False when there is no default to go back to.
        """
        if interval_us == 0:
            interval_ns = self.default_interval_ns(name)
            if interval_ns == OFF and self.personality.whole_milliseconds:
                return False  # in no stream group: ArduPilot knows no default
        elif interval_us < 0:
            interval_ns = OFF
        else:
            interval_ns = self._allowed_ns(interval_us)
        self._start(name, interval_ns, now_ns)
        return True

    def set_group_rate(self, group: int, rate_hz: int, now_ns: int) -> None:
        """REQUEST_DATA_STREAM: one rate for all of a group, or of every group when ``group`` is 0."""
        for stream in self.personality.streams:
            if stream.group > 0 and group in {0, stream.group}:
                interval_ns = self._allowed_ns(1_000_000 // rate_hz) if rate_hz > 0 else OFF
                self._start(stream.message, interval_ns, now_ns)

    def _allowed_ns(self, interval_us: int) -> int:
        """The interval that the firmware sets when this one is requested, ns.

        ArduPilot: whole milliseconds, cut down; at least one; and "at most 80 % of main loop rate", again cut down,
        so that a 400 Hz loop sends 333 Hz and a 50 Hz loop 40 Hz. Others: as asked, one message a loop at most.
        """
        if not self.personality.whole_milliseconds:
            return max(interval_us * 1000, self.loop_ns)
        interval_ms = max(min(interval_us, LONGEST_INTERVAL_US) // 1000, 1)
        if interval_ms * 800 < self.loop_ns / 1000:
            interval_ms = int(self.loop_ns / 1000 / 800)
        return interval_ms * 1_000_000

    def _start(self, name: str, interval_ns: int, now_ns: int) -> None:
        self.intervals[name] = interval_ns
        if interval_ns == OFF:
            self.due_ns.pop(name, None)
        else:
            # On the grid of whole intervals since boot: streams of one rate then share their ticks.
            self.due_ns[name] = (now_ns // interval_ns + 1) * interval_ns
        self.next_ns = min(self.due_ns.values(), default=2**62)

    def take_due(self, now_ns: int) -> list[str]:
        """The messages to send now, in the firmware's order; each is then due again one interval on."""
        if now_ns < self.next_ns:
            return []
        due = [name for name in self.names if self.due_ns.get(name, now_ns + 1) <= now_ns]
        for name in due:
            interval_ns = self.intervals[name]
            following = self.due_ns[name] + interval_ns
            # What could not be sent in time is left out, not made up for.
            self.due_ns[name] = following if following > now_ns else (now_ns // interval_ns + 1) * interval_ns
        self.next_ns = min(self.due_ns.values(), default=2**62)
        return due
