"""One connection of the site: a request of bounded size in bounded time, its answer, and the end.

Nothing waits for a client. One that does not read keeps what the kernel and one answer hold, for a few seconds.
"""

import socket
from collections.abc import Callable
from typing import Final

from attest_mav.runtime.loop import READ, WRITE, Handler, Watch
from attest_mav.web.request import Refusal, Request, parse_request
from attest_mav.web.response import Response

READ_BYTES: Final = 4096
SEND_BUFFER_BYTES: Final = 65536
"""Asked of the kernel, bytes: it would otherwise keep megabytes for a client that does not read."""
REQUEST_NS: Final = 5_000_000_000
"""A request must be complete after this time."""
ANSWER_NS: Final = 10_000_000_000
"""An answer, or one event, must be taken after this time."""
FAREWELL_NS: Final = 1_000_000_000
"""How long the client's own end is waited for, so that its last bytes do not destroy the answer."""


class Client(Handler):
    """One connection. number: tells it from others. answer: makes the answer. ended: called when it is over."""

    def __init__(
        self,
        sock: socket.socket,
        number: int,
        hosts: tuple[str, ...],
        answer: Callable[[Request | Refusal, int], Response],
        ended: Callable[["Client"], None],
        now_ns: int,
    ) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER_BYTES)
        self.streams = False
        """Whether events are to be sent."""
        self._socket: Final = sock
        self._number: Final = number
        self._hosts: Final = hosts
        self._answer: Final = answer
        self._ended: Final = ended
        self._head = b""
        self._out = bytearray()
        self._is_answered = False
        self._deadline_ns: int | None = now_ns + REQUEST_NS

    @property
    def watch(self) -> Watch | None:
        """See ``Handler``."""
        return Watch(self._socket.fileno(), self._number, READ | (WRITE if self._out else 0))

    @property
    def next_deadline_ns(self) -> int | None:
        """See ``Handler``."""
        return self._deadline_ns

    def due(self, now_ns: int) -> None:
        """The client was too slow."""
        self.end()

    def readable(self, now_ns: int) -> None:
        """Take a part of the request; what comes behind it is dropped."""
        try:
            data = self._socket.recv(READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.end()
        elif not self._is_answered:
            self._head += data
            request = parse_request(self._head, self._hosts)
            if request is not None:
                self._reply(request, now_ns)

    def writable(self, now_ns: int) -> None:
        """Send what waits."""
        try:
            while self._out:
                del self._out[: self._socket.send(self._out)]
        except BlockingIOError:
            return
        except OSError:
            self.end()
            return
        if self.streams:
            self._deadline_ns = None
        elif self._is_answered:
            self._say_farewell(now_ns)

    def push(self, event: bytes, now_ns: int) -> None:
        """Send an event; a client that has not taken the last one yet misses this one."""
        if not self._out:
            self._out += event
            self._deadline_ns = now_ns + ANSWER_NS
            self.writable(now_ns)

    def end(self) -> None:
        """Close the connection."""
        self._ended(self)
        self._socket.close()

    def _reply(self, request: Request | Refusal, now_ns: int) -> None:
        response = self._answer(request, now_ns)
        with_body = isinstance(request, Refusal) or request.wants_body
        self._is_answered = True
        self._head = b""
        self.streams = response.streams and with_body
        self._out += response.encoded(with_body=with_body)
        self._deadline_ns = now_ns + ANSWER_NS
        self.writable(now_ns)

    def _say_farewell(self, now_ns: int) -> None:
        try:
            self._socket.shutdown(socket.SHUT_WR)
        except OSError:  # gone already
            self.end()
            return
        self._deadline_ns = now_ns + FAREWELL_NS
