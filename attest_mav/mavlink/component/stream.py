"""One message that an autopilot is to send: the request, and the rate measured from its arrivals."""

from itertools import pairwise
from typing import Final

WINDOW_NS: Final = 2_000_000_000
MIN_WINDOW_PERIODS: Final = 10
"""Rates are measured over two seconds, or over ten periods of the request if that is longer."""
LOW_SHARE: Final = 0.8
"""A window is low when less than this share of the request arrives."""
SAME_RATE: Final = 0.1
"""Two measured rates that differ by less than this share are the same: the new request changed nothing."""
QUICK_WINDOW_NS: Final = 100_000_000
QUICK_PERIODS: Final = 6
"""While another program lowers the rate again and again, windows are so long: a fall is noticed at once."""
QUICK_SHARE: Final = 0.5
"""A quick window, which holds few messages, is low when less than this share of the request arrives."""
WATCH_NS: Final = 300_000_000_000
"""Quick windows are used for so long after the last fall."""
QUICK_PAUSE_NS: Final = 1_000_000_000
"""Pause between requests while asking helps each time."""
FALLS: Final = 4
"""So many falls show whether they come at equal intervals."""
UNEVEN: Final = 0.25
"""Intervals that differ from their mean by less than this share are equal."""
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
        """Length of a measuring window, ns."""
        self.was_answered = False
        """The autopilot has answered a request for this message."""
        self.fell_ns: Final[list[int]] = []
        """When the rate fell although a request had been met, the newest last."""
        self._quick_ns: Final = max(QUICK_WINDOW_NS, int(QUICK_PERIODS * 1e9 / hz))
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
        self.was_met = False
        """The last repeated request was met."""

    def is_watched(self, now_ns: int) -> bool:
        """Whether the rate has fallen lately although requests were met, so that quick windows are used."""
        return bool(self.fell_ns) and now_ns - self.fell_ns[-1] < WATCH_NS

    def window_end_ns(self, now_ns: int) -> int:
        """The end of the present window."""
        return self.window_began_ns + (self._quick_ns if self.is_watched(now_ns) else self.window_ns)

    def helped(self, now_ns: int) -> None:
        """The repeated request was met: the next one may follow as soon as the rate falls again."""
        self.on_trial = False
        self.pause_ns = QUICK_PAUSE_NS
        self.ask_again_ns = min(self.ask_again_ns, now_ns + QUICK_PAUSE_NS)
        self.was_met = True

    def fell(self, now_ns: int) -> None:
        """The rate has fallen after a request that was met: another program has lowered it."""
        self.was_met = False
        self.fell_ns.append(now_ns)
        del self.fell_ns[:-FALLS]

    def override_text(self, now_ns: int) -> str:
        """What is known of the program that lowers the rate, "" where none does."""
        falls = self.fell_ns
        if not self.is_watched(now_ns):
            return ""
        gaps_s = [(later - sooner) * 1e-9 for sooner, later in pairwise(falls)]
        mean_s = sum(gaps_s) / max(len(gaps_s), 1)
        if len(falls) < FALLS or max(abs(gap_s - mean_s) for gap_s in gaps_s) > UNEVEN * mean_s:
            return "another program on this link lowers the rate"
        return f"another program on this link lowers the rate every {mean_s:.0f} s"

    def measure_anew(self, now_ns: int) -> None:
        """Begin a window, and forget the low ones before it."""
        self.count = 0
        self.window_began_ns = now_ns
        self.low_windows = 0

    def close_window(self, now_ns: int, arriving: float) -> bool:
        """End the window when its time has come, and take its rate; False while it goes on.

        arriving: share of the frames that the link does not lose.
        """
        if now_ns < self.window_end_ns(now_ns):
            return False
        share = QUICK_SHARE if self.is_watched(now_ns) else LOW_SHARE
        self.achieved_hz = self.count * 1e9 / (now_ns - self.window_began_ns)
        self.absent = self.absent and self.count == 0
        self.count = 0
        self.window_began_ns = now_ns
        if self.achieved_hz > (1.0 + SAME_RATE) * self.ceiling_hz:
            self.ceiling_hz = 0.0
        limit = share * (self.ceiling_hz if self.ceiling_hz > 0.0 else arriving * self.hz)
        self.low_windows = self.low_windows + 1 if self.achieved_hz < limit else 0
        if self.low_windows > 0:
            self.good_since_ns = now_ns
        elif now_ns - self.good_since_ns >= LONGEST_PAUSE_NS:
            self.pause_ns = FIRST_PAUSE_NS
        return True

    def unchanged(self) -> bool:
        """Whether the repeated request has left the rate as it was."""
        return self.achieved_hz > 0.0 and abs(self.achieved_hz - self.rate_when_asked) < SAME_RATE * self.achieved_hz
