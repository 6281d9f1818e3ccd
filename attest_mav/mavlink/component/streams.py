"""Asking an autopilot for messages, and seeing that they come.

Each message is asked for with MAV_CMD_SET_MESSAGE_INTERVAL, one command at a time, since COMMAND_ACK does not say which
message it is about. Then what arrives is measured: an ACK is a promise, and ground stations that ask for streams of
their own override it. A rate that stays low is asked for again, ever more seldom; one that the autopilot accepts and
still does not deliver is its ceiling, and is left alone.
"""

from typing import Final

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.stream import LONGEST_PAUSE_NS, Order, Stream
from attest_mav.mavlink.constants import (
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_IN_PROGRESS,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_RESULT_UNSUPPORTED,
    NO_DATA_STREAM,
)

RESULT_NAMES: Final = ("accepted", "temporarily rejected", "denied", "unsupported", "failed", "in progress")
"""By MAV_RESULT."""

ACK_WAIT_NS: Final = 1_000_000_000
MAX_TRIES: Final = 3
"""A command without an answer is sent this often, with a raised confirmation."""
LOW_WINDOWS: Final = 2
"""Under 80 % of the request in two windows in a row: ask again."""
OVERRIDE_MEMORY_NS: Final = 60_000_000_000
"""Who asked for streams within the last minute may be who overrides ours."""


class StreamKeeper:
    """The requests of one vehicle. ``poll`` returns what is to be sent; it does not send.

    ``asks`` False only measures: for links where someone else sets the rates.
    """

    def __init__(self, asks: bool, notebook: Notebook) -> None:
        self.streams: list[Stream] = []
        self.asked: list[int] = []
        """Ids of all messages that the vehicle was ever asked for."""
        self._asks: Final = asks
        self._notebook: Final = notebook
        self._queue: list[Stream] = []
        self._fallbacks: list[Order] = []
        self._asking: Stream | None = None
        self._tries = 0
        self._ack_due_ns = 0
        self._overrider = ""
        self._overridden_ns = -OVERRIDE_MEMORY_NS

    def begin(self, streams: list[Stream], now_ns: int) -> None:
        """Ask for these and nothing else: a vehicle was found, or found again."""
        self.streams = []
        self._queue = []
        self._fallbacks = []
        self._asking = None
        for stream in reversed(streams):
            self.want(stream, now_ns)

    def forget(self) -> None:
        """There is no vehicle any more, or another one."""
        self.begin([], 0)
        self.asked = []

    def want(self, stream: Stream, now_ns: int) -> None:
        """Ask for one more message, before all others that wait."""
        stream.measure_anew(now_ns)
        stream.good_since_ns = now_ns
        self.streams.insert(0, stream)
        if self._asks:
            self._queue.insert(0, stream)

    def drop(self, message_id: int) -> None:
        """No longer look after this message."""
        self.streams = [stream for stream in self.streams if stream.message_id != message_id]
        self._queue = [stream for stream in self._queue if stream.message_id != message_id]
        if self._asking is not None and self._asking.message_id == message_id:
            self._asking = None

    def arrived(self, message_id: int) -> None:
        """Count a message of the vehicle."""
        for stream in self.streams:
            if stream.message_id == message_id:
                stream.count += 1
                return

    def acknowledged(self, result: int, now_ns: int) -> None:
        """The vehicle answered a SET_MESSAGE_INTERVAL of ours: it can only be the one that is out."""
        stream = self._asking
        if stream is None or result == MAV_RESULT_IN_PROGRESS:
            return
        self._asking = None
        answer = RESULT_NAMES[result] if result < len(RESULT_NAMES) else f"result {result}"
        self._answered(stream, answer, now_ns)
        if result == MAV_RESULT_TEMPORARILY_REJECTED:
            stream.low_windows = LOW_WINDOWS
            stream.ask_again_ns = now_ns + stream.pause_ns
        elif result != MAV_RESULT_ACCEPTED:
            self._notebook.info(f"{stream.name} at {stream.hz:g} Hz: {answer}")
            stream.refused = True
            if result == MAV_RESULT_UNSUPPORTED:
                self._fall_back(stream)

    def overheard(self, who: str, now_ns: int) -> None:
        """Someone else asked the vehicle for streams."""
        self._overrider = who
        self._overridden_ns = now_ns

    def poll(self, now_ns: int) -> list[Order]:
        """Look at the rates that are known by now, and return the requests that are due."""
        for stream in self.streams:
            if stream.close_window(now_ns):
                self._judge(stream, now_ns)
        orders: list[Order] = []
        asking = self._asking
        if asking is not None and now_ns >= self._ack_due_ns:
            if self._tries < MAX_TRIES:
                orders.append(self._next_try(asking, now_ns))
            else:
                self._give_up(asking, now_ns)
        if self._asking is None and self._queue:
            self._asking = self._queue.pop(0)
            self._tries = 0
            orders.append(self._next_try(self._asking, now_ns))
        orders += self._fallbacks
        self._fallbacks = []
        return orders

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` is due: 0 is at once, None never."""
        if self._fallbacks or (self._asking is None and self._queue):
            return 0
        deadlines = [stream.window_began_ns + stream.window_ns for stream in self.streams]
        if self._asking is not None:
            deadlines.append(self._ack_due_ns)
        return min(deadlines) if deadlines else None

    def _next_try(self, stream: Stream, now_ns: int) -> Order:
        self._ack_due_ns = now_ns + ACK_WAIT_NS
        self._tries += 1
        if stream.message_id not in self.asked:
            self.asked.append(stream.message_id)
        return Order(stream.message_id, stream.hz, NO_DATA_STREAM, self._tries - 1)

    def _give_up(self, stream: Stream, now_ns: int) -> None:
        """No answer came: the old request may still be understood."""
        self._asking = None
        self._answered(stream, "no answer", now_ns)
        self._notebook.info(f"{stream.name} at {stream.hz:g} Hz: no answer to {MAX_TRIES} requests")
        self._fall_back(stream)

    def _answered(self, stream: Stream, answer: str, now_ns: int) -> None:
        stream.answer = answer
        stream.measure_anew(now_ns)

    def _fall_back(self, stream: Stream) -> None:
        """Ask with REQUEST_DATA_STREAM for the group that holds the message."""
        if stream.group >= 0:
            stream.refused = False
            stream.answer += ", asked by stream group"
            self._fallbacks.append(Order(stream.message_id, stream.hz, stream.group, 0))

    def _judge(self, stream: Stream, now_ns: int) -> None:
        """Decide after each window whether to ask again."""
        if stream.refused or not self._asks or stream is self._asking or stream in self._queue:
            return
        overridden = now_ns - self._overridden_ns < OVERRIDE_MEMORY_NS
        if stream.on_trial and stream.low_windows > 0 and stream.unchanged() and not overridden:
            stream.ceiling_hz = stream.achieved_hz
            stream.low_windows = 0
            self._notebook.info(f"{stream.name}: {stream.achieved_hz:.1f} Hz is all that the autopilot gives")
        stream.on_trial = False
        if stream.low_windows >= LOW_WINDOWS and now_ns >= stream.ask_again_ns:
            self._ask_again(stream, f"; {self._overrider} also asks for streams" if overridden else "", now_ns)

    def _ask_again(self, stream: Stream, suspect: str, now_ns: int) -> None:
        self._notebook.warning(
            f"{stream.name} arrives at {stream.achieved_hz:.1f} Hz instead of {stream.hz:g}: asking again{suspect}"
        )
        stream.rate_when_asked = stream.achieved_hz
        stream.on_trial = True
        stream.ask_again_ns = now_ns + stream.pause_ns
        stream.pause_ns = min(2 * stream.pause_ns, LONGEST_PAUSE_NS)
        self._queue.append(stream)
