"""``tcp:`` connects to a server, again and again if need be."""

import os
import socket

from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError
from attest_mav.runtime.links.base import READ_BYTES, Backoff, Link, log, resolve
from attest_mav.runtime.links.out_buffer import OutBuffer

CONNECT_TIMEOUT_NS = 5_000_000_000
FIRST_CONNECT_TIMEOUT_S = 5.0


class TcpClientLink(Link):
    """One connection to a server; made anew with back-off whenever it fails."""

    def __init__(self, url: LinkUrl, now_ns: int, *, wait: bool) -> None:
        super().__init__(str(url))
        self.family, self.address = resolve(url, socket.SOCK_STREAM)
        self.socket: socket.socket | None = None
        self.connected = False
        self.backoff = Backoff()
        self.deadline_ns: int | None = now_ns
        self.out = OutBuffer()
        if wait:
            self._begin(now_ns)
        else:
            self._connect_or_fail()

    @property
    def fd(self) -> int | None:
        """See ``Link``."""
        return None if self.socket is None else self.socket.fileno()

    @property
    def is_up(self) -> bool:
        """See ``Link``."""
        return self.connected

    @property
    def is_open(self) -> bool:
        """See ``Link``. A connection that was not accepted yet is none."""
        return self.connected

    @property
    def wants_write(self) -> bool:
        """See ``Link``."""
        return self.socket is not None and (not self.connected or bool(self.out.data))

    @property
    def next_deadline_ns(self) -> int | None:
        """See ``Link``."""
        return self.deadline_ns

    def receive(self, now_ns: int) -> bytes:
        """See ``Link``."""
        if self.deadline_ns is not None and now_ns >= self.deadline_ns:
            self._overdue(now_ns)
        if not self.connected or self.socket is None:
            return b""
        try:
            data = self.socket.recv(READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as error:
            self._lost(error.strerror or str(error), now_ns)
            return b""
        if not data:
            self._lost("closed by the other end", now_ns)
        self.received_bytes += len(data)
        return data

    def send(self, message: bytes, now_ns: int) -> None:
        """See ``Link``."""
        if not self.connected or not self.out.push(message):
            self.dropped_messages += 1
            return
        self.flush(now_ns)

    def flush(self, now_ns: int) -> None:
        """See ``Link``."""
        if self.socket is None:
            return
        if not self.connected:
            self._finish(now_ns)
            return
        try:
            self.sent_bytes += self.out.drain(self.socket.send)
        except OSError as error:
            self._lost(error.strerror or str(error), now_ns)

    def close(self) -> None:
        """See ``Link``."""
        if self.socket is not None:
            self.socket.close()
        self.socket = None
        self.connected = False

    def _connect_or_fail(self) -> None:
        sock = socket.socket(self.family, socket.SOCK_STREAM)
        sock.settimeout(FIRST_CONNECT_TIMEOUT_S)
        try:
            sock.connect(self.address)
        except OSError as error:
            sock.close()
            raise LinkError(f"cannot connect to {self.url}: {error}; start the server, or check the address") from None
        self._up(sock)

    def _begin(self, now_ns: int) -> None:
        self.socket = socket.socket(self.family, socket.SOCK_STREAM)
        self.socket.setblocking(False)
        self.deadline_ns = now_ns + CONNECT_TIMEOUT_NS
        try:
            self.socket.connect(self.address)
        except BlockingIOError:
            return
        except OSError as error:
            self._lost(error.strerror or str(error), now_ns)
            return
        self._up(self.socket)

    def _finish(self, now_ns: int) -> None:
        """The socket of a pending connect became writable: it is connected, or it never will be."""
        if self.socket is None:
            return
        code = self.socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            self._lost(os.strerror(code), now_ns)
        else:
            self._up(self.socket)

    def _up(self, sock: socket.socket) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket = sock
        self.connected = True
        self.deadline_ns = None
        self.epoch += 1
        self.out = OutBuffer()
        self.backoff.reset()
        log.info("connected to %s", self.url)

    def _overdue(self, now_ns: int) -> None:
        if self.socket is None:
            self._begin(now_ns)
        elif not self.connected:
            self._lost("no answer", now_ns)

    def _lost(self, reason: str, now_ns: int) -> None:
        self.close()
        self.deadline_ns = self.backoff.next(self.url, reason, now_ns)
