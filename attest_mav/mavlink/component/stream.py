"""One message that an autopilot is to send: the request, and the rate measured from its arrivals."""

from typing import Final

WINDOW_NS: Final = 2_000_000_000
MIN_WINDOW_PERIODS: Final = 10
"""Rates are measured over two seconds, or over ten periods of the request if that is longer."""
LOW_SHARE: Final = 0.8
"""A window is low when less than this share of the request arrives."""
SAME_RATE: Final = 0.1
"""Two measured rates that differ by less than this share are the same: the new request changed nothing."""
FIRST_PAUSE_NS: Final = 5_000_000_000
LONGEST_PAUSE_NS: Final = 60_000_000_000
"""Pauses between requests that repeat one: the first, doubled after each, and the limit."""


class StreamRequest:
    """A request to be sent: SET_MESSAGE_INTERVAL, or REQUEST_DATA_STREAM where ``group`` is a MAV_DATA_STREAM."""

    def __init__(self, message_id: int, hz: float, group: int, confirmation: int) -> None:
        self.message_id: Final = message_id
        self.hz: Final = hz
        self.group: Final = group
        self.confirmation: Final = confirmation

    @property
    def interval_us(self) -> int:
        """Interval between messages, us."""
        return round(1e6 / self.hz)


class Stream:
    """One requested message: its request, the autopilot's answer and the measured rate.

    group: the MAV_DATA_STREAM that holds the message, NO_DATA_STREAM for none. is_optional: the vehicle may have no
    sensor for it, so its absence is no fault.
    """

    def __init__(self, message_id: int, name: str, hz: float, group: int, is_optional: bool = False) -> None:
        self.message_id: Final = message_id
        self.name: Final = name
        self.hz: Final = hz
        self.group: Final = group
        self.is_optional: Final = is_optional
        self.window_ns: Final = max(WINDOW_NS, int(MIN_WINDOW_PERIODS * 1e9 / hz))
        """Length of a measuring window."""
        self.answer = ""
        """The autopilot's answer in a word or two, "" before there is one."""
        self.refused = False
        """The autopilot will not send this message."""
        self.achieved_hz = 0.0
        """Rate measured in the last window, 0 before one has ended."""
        self.ceiling_hz = 0.0
        """Rate that the autopilot does not exceed, 0 while none is known."""
        self.absent = False
        """An optional message that does not come although it was requested."""
        self.count = 0
        """Arrivals in the present window."""
        self.window_began_ns = 0
        """Start of the present window."""
        self.low_windows = 0
        """Windows in a row with a low rate."""
        self.good_since_ns = 0
        """End of the last window with a low rate."""
        self.rate_when_asked = 0.0
        """Rate measured when the request was last repeated, Hz."""
        self.on_trial = False
        """The request was repeated, and the next window shows whether the rate has changed."""
        self.pause_ns = FIRST_PAUSE_NS
        """Pause before the request may be repeated once more."""
        self.ask_again_ns = 0
        """End of the present pause."""

    def measure_anew(self, now_ns: int) -> None:
        """Begin a window, and forget the low ones before it."""
        self.count = 0
        self.window_began_ns = now_ns
        self.low_windows = 0

    def close_window(self, now_ns: int) -> bool:
        """End the window when its time has come, and take its rate; False while it goes on."""
        if now_ns - self.window_began_ns < self.window_ns:
            return False
        self.achieved_hz = self.count * 1e9 / (now_ns - self.window_began_ns)
        self.absent = self.absent and self.count == 0
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
        """Whether the repeated request has left the rate as it was."""
        return self.achieved_hz > 0.0 and abs(self.achieved_hz - self.rate_when_asked) < SAME_RATE * self.achieved_hz
