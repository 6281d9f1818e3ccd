"""One message that is wanted of an autopilot: the request, and what is measured of what arrives."""

from typing import Final

WINDOW_NS: Final = 2_000_000_000
MIN_WINDOW_PERIODS: Final = 10
"""Rates are measured over two seconds, or over ten periods of the request if that is longer."""
LOW_SHARE: Final = 0.8
"""A window is low when less than this share of the request arrives."""
SAME_RATE: Final = 0.1
"""Two measured rates this near to each other, by share, are the same: asking again changed nothing."""
FIRST_PAUSE_NS: Final = 5_000_000_000
LONGEST_PAUSE_NS: Final = 60_000_000_000


class Order:
    """A request to put on the wire: SET_MESSAGE_INTERVAL, or REQUEST_DATA_STREAM where ``group`` is not negative."""

    def __init__(self, message_id: int, hz: float, group: int, confirmation: int) -> None:
        self.message_id: Final = message_id
        self.hz: Final = hz
        self.group: Final = group
        self.confirmation: Final = confirmation

    @property
    def interval_us(self) -> int:
        """Microseconds from message to message."""
        return round(1e6 / self.hz)


class Stream:
    """One message that is wanted: what was asked for, what was answered and what arrives.

    group: the MAV_DATA_STREAM that holds the message, -1 for none. answer: a word or two, "" before there is one.
    achieved_hz: measured, 0 before the first window ends. ceiling_hz: what the autopilot will not exceed, 0: unknown.
    """

    def __init__(self, message_id: int, name: str, hz: float, group: int) -> None:
        self.message_id: Final = message_id
        self.name: Final = name
        self.hz: Final = hz
        self.group: Final = group
        self.window_ns: Final = max(WINDOW_NS, int(MIN_WINDOW_PERIODS * 1e9 / hz))
        self.answer = ""
        self.refused = False
        self.achieved_hz = 0.0
        self.ceiling_hz = 0.0
        self.count = 0
        self.window_began_ns = 0
        self.low_windows = 0
        self.good_since_ns = 0
        self.rate_when_asked = 0.0
        self.on_trial = False
        """Asked for again: does the rate change?"""
        self.pause_ns = FIRST_PAUSE_NS
        self.ask_again_ns = 0

    def measure_anew(self, now_ns: int) -> None:
        """Begin a window."""
        self.count = 0
        self.window_began_ns = now_ns
        self.low_windows = 0

    def close_window(self, now_ns: int) -> bool:
        """Take the rate of a window that has ended; False while none has."""
        if now_ns - self.window_began_ns < self.window_ns:
            return False
        self.achieved_hz = self.count * 1e9 / (now_ns - self.window_began_ns)
        self.count = 0
        self.window_began_ns = now_ns
        if self.achieved_hz > (1.0 + SAME_RATE) * self.ceiling_hz:
            self.ceiling_hz = 0.0
        limit = LOW_SHARE * (self.ceiling_hz if self.ceiling_hz > 0.0 else self.hz)
        self.low_windows = self.low_windows + 1 if self.achieved_hz < limit else 0
        if self.low_windows > 0:
            self.good_since_ns = now_ns
        elif now_ns - self.good_since_ns >= LONGEST_PAUSE_NS:
            self.pause_ns = FIRST_PAUSE_NS
        return True

    def unchanged(self) -> bool:
        """Whether asking again made no difference to the rate."""
        return self.achieved_hz > 0.0 and abs(self.achieved_hz - self.rate_when_asked) < SAME_RATE * self.achieved_hz
