"""The topics of a log: each subscription with its layout, its reader and its count."""

from collections.abc import Mapping
from struct import Struct
from typing import Final

from attest_mav.logs.ulog.layout import Formats, Layout, Selection
from attest_mav.logs.ulog.messages import MessageReader
from attest_mav.logs.ulog.reader import MICRO_NS, TopicReader
from attest_mav.logs.ulog.roles import stream_of
from attest_mav.samples import Sample

ID_BYTES: Final = 2
TIME_BYTES: Final = 8
PADDING: Final = 8
"""Up to so many bytes of padding at the end of a topic are not written."""
LATEST_US: Final = 1 << 52
"""A later time is none; this also keeps nanoseconds within 64 bits."""
CLOCK_BACK_NS: Final = 1_000_000_000
_SUBSCRIPTION: Final = Struct("<BH")
_TIME: Final = Struct("<Q")


class Subscription:
    """One instance of a topic."""

    def __init__(self, stream: str, layout: Layout, reader: TopicReader | None) -> None:
        self.stream: Final = stream
        self.layout: Final = layout
        self.reader: Final = reader
        self.selection: Final = None if reader is None else Selection(layout, reader.names)
        self.count = 0
        """Messages so far."""
        self.size = 0
        """Bytes of the newest one, its id aside: a recorder leaves out the same padding each time."""


class Topics:
    """All topics of a log. readers: by the names of their streams."""

    def __init__(self, readers: Mapping[str, TopicReader]) -> None:
        self.formats: Final = Formats()
        self.messages: Final = MessageReader()
        self.now_ns = 0
        """Time of the newest message."""
        self.span_ns = 0
        """Time from the first message to the newest one."""
        self._readers: Final = dict(readers)
        self._subscriptions: Final[dict[int, Subscription]] = {}
        self._former: Final[dict[int, Subscription]] = {}
        """By id the subscription that another one has replaced: either of the two may be damaged."""
        self._counts: Final[dict[str, int]] = {}

    def subscribe(self, body: bytes) -> None:
        """Take a subscription: instance, id, and the topic's name."""
        instance, number = _SUBSCRIPTION.unpack_from(body)
        topic = body[_SUBSCRIPTION.size :].decode("ascii", "replace")
        layout = self.formats.layout(topic)
        if layout is None:
            return
        stream = stream_of(topic, instance)
        last = self._subscriptions.get(number)
        if last is not None and last.stream != stream:
            self._retire(self._former.pop(number, None))
            self._former[number] = last
        elif last is not None:
            self._retire(last)
        self._subscriptions[number] = Subscription(stream, layout, self._readers.get(stream))

    def fits(self, number: int, size: int) -> bool:
        """Whether a message with this id can have so many bytes of data; by them the id's subscription is chosen."""
        subscription = self._subscriptions.get(number)
        if subscription is None:
            return False
        if -PADDING <= size - subscription.layout.size <= 0:
            return True
        former = self._former.get(number)
        if former is None or not -PADDING <= size - former.layout.size <= 0:
            return False
        self._subscriptions[number], self._former[number] = former, subscription
        return True

    def is_usual(self, number: int, size: int) -> bool:
        """Whether the messages with this id had so many bytes of data so far, or there were none."""
        subscription = self._subscriptions.get(number)
        return subscription is not None and subscription.size in {0, size}

    def data(self, data: bytes, begin: int, end: int) -> list[Sample]:
        """The samples of the data message whose body stands there."""
        subscription = self._subscriptions[data[begin] + 256 * data[begin + 1]]
        subscription.count += 1
        subscription.size = end - begin - ID_BYTES
        reader, selection = subscription.reader, subscription.selection
        if reader is None or selection is None or begin + ID_BYTES + max(selection.size, TIME_BYTES) > end:
            return []
        if not self._follow(_TIME.unpack_from(data, begin + ID_BYTES)[0]):
            return []
        numbers = selection.numbers(data, begin + ID_BYTES)
        return reader.read(MICRO_NS * int(numbers[0]), numbers) if 0.0 <= numbers[0] < LATEST_US else []

    def counts(self) -> dict[str, int]:
        """Number of messages by stream."""
        for subscription in (*self._subscriptions.values(), *self._former.values()):
            self._retire(subscription)
        return dict(self._counts)

    def _retire(self, last: Subscription | None) -> None:
        """Keep the count of a subscription whose id another one takes, or of one at the end of the log."""
        if last is not None and last.count:
            self._counts[last.stream] = self._counts.get(last.stream, 0) + last.count
            last.count = 0

    def _follow(self, t_us: int) -> bool:
        """Follow the time; False for one that cannot be."""
        if t_us >= LATEST_US:
            return False
        t_ns = t_us * MICRO_NS
        if self.now_ns and t_ns > self.now_ns:
            self.span_ns += t_ns - self.now_ns
        if t_ns > self.now_ns or t_ns < self.now_ns - CLOCK_BACK_NS:
            self.now_ns = t_ns
        return True
