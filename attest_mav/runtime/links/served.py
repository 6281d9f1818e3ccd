"""A link as a handler of the event loop."""

from collections.abc import Callable
from typing import Final

from attest_mav.runtime.links.base import Link
from attest_mav.runtime.loop import READ, WRITE, Handler, Watch


class ServedLink(Handler):
    """Reads and flushes a link when the loop says so.

    received: takes the bytes that arrived, and the time. restarted: called at each new stream, before its first bytes.
    """

    def __init__(self, link: Link, received: Callable[[bytes, int], None], restarted: Callable[[], None]) -> None:
        self._link: Final = link
        self._received: Final = received
        self._restarted: Final = restarted
        self._epoch = link.epoch

    @property
    def watch(self) -> Watch | None:
        """See ``Handler``."""
        fd = self._link.fd
        if fd is None:
            return None
        return Watch(fd, self._link.epoch, READ | (WRITE if self._link.wants_write else 0))

    @property
    def next_deadline_ns(self) -> int | None:
        """See ``Handler``."""
        return self._link.next_deadline_ns

    def writable(self, now_ns: int) -> None:
        """See ``Handler``."""
        self._link.flush(now_ns)

    def readable(self, now_ns: int) -> None:
        """One read; if there is more, the selector says so at once."""
        data = self._link.receive(now_ns)
        if self._link.epoch != self._epoch:
            self._epoch = self._link.epoch
            self._restarted()
        if data:
            self._received(data, now_ns)

    def due(self, now_ns: int) -> None:
        """Read, which also opens again a link that was lost."""
        self.readable(now_ns)
