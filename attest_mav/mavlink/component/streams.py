"""Requests messages from an autopilot, measures their rates and repeats requests that are not met.

Each message is requested with MAV_CMD_SET_MESSAGE_INTERVAL, one command at a time, because COMMAND_ACK does not name
the message. The rate that arrives is measured, because ground stations with requests of their own override an accepted
one. A request is repeated, at doubling intervals, while its rate stays low. A rate that the autopilot accepts and does
not deliver even after a second request is its ceiling: the request is then not repeated.
"""

from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.loss_meter import LossMeter
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.stream import LONGEST_PAUSE_NS, Stream, StreamRequest
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
"""Sendings of a command that is not answered, each with its confirmation raised by one."""
LOW_WINDOWS: Final = 2
"""Windows in a row under ``LOW_SHARE`` of the request before it is repeated."""
OVERRIDE_MEMORY_NS: Final = 60_000_000_000
"""A component that requested streams within this time is named as the one that may override ours."""


class StreamManager:
    """The requested streams of one vehicle. ``poll`` returns the requests to send; it does not send.

    asks: False only measures, for links where another program sets the rates.
    """

    def __init__(self, asks: bool, notebook: Notebook) -> None:
        self.streams: list[Stream] = []
        self.asked: list[int] = []
        """Ids of all messages that were ever requested from the vehicle."""
        self.loss: Final = LossMeter()
        """What the link of the requests loses."""
        self.unanswered = 0
        """Requests given up without an answer since the last answer."""
        self.silent_ns = -OVERRIDE_MEMORY_NS
        """When the vehicle was last silent on all links: no other program has lowered the rates of that time."""
        self._lines: Final = LineLimit()
        self._asks: Final = asks
        self._notebook: Final = notebook
        self._queue: list[Stream] = []
        self._fallbacks: list[StreamRequest] = []
        self._asking: Stream | None = None
        self._tries = 0
        self._ack_due_ns = 0
        self._overrider = ""
        self._overridden_ns = -OVERRIDE_MEMORY_NS

    def begin(self, streams: list[Stream], now_ns: int) -> None:
        """Request these and nothing else: a vehicle was found, or found again."""
        self.streams = []
        self._queue = []
        self._fallbacks = []
        self._asking = None
        for stream in reversed(streams):
            self.want(stream, now_ns)

    def forget(self) -> None:
        """Drop all streams: there is no vehicle any more, or another one."""
        self.begin([], 0)
        self.asked = []

    def want(self, stream: Stream, now_ns: int) -> None:
        """Request one more message, before all others that wait."""
        stream.measure_anew(now_ns)
        stream.good_since_ns = now_ns
        self.streams.insert(0, stream)
        if self._asks:
            self._queue.insert(0, stream)

    def drop(self, message_id: int) -> None:
        """Neither request nor measure this message any longer."""
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
        """The vehicle answered a SET_MESSAGE_INTERVAL of ours: only one is unanswered at a time."""
        stream = self._asking
        if stream is None or result == MAV_RESULT_IN_PROGRESS:
            return
        self._asking = None
        self.unanswered = 0
        stream.was_answered = True
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
        """Another component requested streams from the vehicle."""
        self._overrider = who
        self._overridden_ns = now_ns

    def pause(self, now_ns: int) -> None:
        """The vehicle is away: nothing is requested and nothing measured; an open request is sent again afterwards."""
        if self._asking is not None:
            self._queue.insert(0, self._asking)
            self._asking = None
        for stream in self.streams:
            stream.measure_anew(now_ns)

    def poll(self, now_ns: int) -> list[StreamRequest]:
        """Close the measuring windows that have ended, and return the requests that are due."""
        for stream in self.streams:
            if stream.close_window(now_ns, 1.0 - self.loss.share):
                self._judge(stream, now_ns)
        requests: list[StreamRequest] = []
        asking = self._asking
        if asking is not None and now_ns >= self._ack_due_ns:
            if self._tries < MAX_TRIES:
                requests.append(self._next_try(asking, now_ns))
            else:
                self._give_up(asking, now_ns)
        if self._asking is None and self._queue:
            self._asking = self._queue.pop(0)
            self._tries = 0
            requests.append(self._next_try(self._asking, now_ns))
        requests += self._fallbacks
        self._fallbacks = []
        return requests

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` is due: 0 is at once, None never."""
        if self._fallbacks or (self._asking is None and self._queue):
            return 0
        deadlines = [stream.window_end_ns(stream.window_began_ns) for stream in self.streams]
        if self._asking is not None:
            deadlines.append(self._ack_due_ns)
        return min(deadlines) if deadlines else None

    def _next_try(self, stream: Stream, now_ns: int) -> StreamRequest:
        self._ack_due_ns = now_ns + ACK_WAIT_NS
        self._tries += 1
        if stream.message_id not in self.asked:
            self.asked.append(stream.message_id)
        return StreamRequest(stream.message_id, stream.hz, NO_DATA_STREAM, self._tries - 1)

    def _give_up(self, stream: Stream, now_ns: int) -> None:
        """No answer came: the older REQUEST_DATA_STREAM may still be understood."""
        self._asking = None
        self.unanswered += 1
        self._answered(stream, "no answer", now_ns)
        suffix = self._lines.suffix(f"unanswered {stream.name}", now_ns)
        if suffix is not None:
            self._notebook.info(f"{stream.name} at {stream.hz:g} Hz: no answer to {MAX_TRIES} requests{suffix}")
        self._fall_back(stream)

    def _answered(self, stream: Stream, answer: str, now_ns: int) -> None:
        stream.answer = answer
        stream.measure_anew(now_ns)

    def _fall_back(self, stream: Stream) -> None:
        """Request the group that holds the message with REQUEST_DATA_STREAM."""
        if stream.group >= 0:
            stream.refused = False
            stream.answer += ", asked by stream group"
            self._fallbacks.append(StreamRequest(stream.message_id, stream.hz, stream.group, 0))

    def _judge(self, stream: Stream, now_ns: int) -> None:
        """Decide after a window whether to repeat the request."""
        if stream.refused or not self._asks or stream is self._asking or stream in self._queue:
            return
        if stream.is_optional and stream.achieved_hz == 0.0:
            self._find_absent(stream)
            return
        if stream.low_windows == 0:
            if stream.on_trial:
                stream.helped(now_ns)
            return
        if stream.was_met and not self.loss.text and now_ns - self.silent_ns > stream.window_ns:
            stream.fell(now_ns)
        overridden = now_ns - self._overridden_ns < OVERRIDE_MEMORY_NS
        if stream.on_trial and stream.unchanged() and stream.was_answered and not overridden:
            stream.ceiling_hz = stream.achieved_hz
            stream.low_windows = 0
            self._notebook.info(f"{stream.name}: {stream.achieved_hz:.1f} Hz is all that the autopilot gives")
        stream.on_trial = False
        needed = 1 if stream.is_watched(now_ns) else LOW_WINDOWS
        if stream.low_windows >= needed and now_ns >= stream.ask_again_ns:
            self._ask_again(stream, f"; {self._overrider} also asks for streams" if overridden else "", now_ns)

    def hindrance(self, stream: Stream, now_ns: int) -> str:
        """Why a message does not come at the requested rate, "" where that is not known."""
        return stream.override_text(now_ns) or (self.loss.text if stream.ceiling_hz == 0.0 else "")

    def _find_absent(self, stream: Stream) -> None:
        """Notice once that an optional message does not come; it is not requested again."""
        if stream.low_windows >= LOW_WINDOWS and not stream.absent:
            stream.absent = True
            self._notebook.info(f"{stream.name} does not come: the vehicle has no such sensor, or does not send it")

    def _ask_again(self, stream: Stream, suspect: str, now_ns: int) -> None:
        why = suspect or (f"; {stream.override_text(now_ns)}" if stream.is_watched(now_ns) else "")
        suffix = self._lines.suffix(f"again {stream.name}", now_ns)
        if suffix is not None:
            rate = f"{stream.achieved_hz:.1f} Hz instead of {stream.hz:g}"
            self._notebook.warning(f"{stream.name} arrives at {rate}: asking again{why}{suffix}")
        stream.rate_when_asked = stream.achieved_hz
        stream.on_trial = True
        stream.ask_again_ns = now_ns + stream.pause_ns
        stream.pause_ns = min(2 * stream.pause_ns, LONGEST_PAUSE_NS)
        if stream.is_watched(now_ns):
            self._queue.insert(0, stream)
        else:
            self._queue.append(stream)
