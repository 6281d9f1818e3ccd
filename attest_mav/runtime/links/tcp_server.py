"""``tcpin:`` listens and serves one peer, the newest."""

import select
import socket

from attest_mav.config.link_url import LinkUrl
from attest_mav.runtime.links.base import READ_BYTES, Link, bind_error, bound_url, log, resolve
from attest_mav.runtime.links.out_buffer import OutBuffer


class TcpServerLink(Link):
    """A listener with one peer. A new connection replaces the old one: a vehicle that lost its own comes back.

    Listener and peer hang on one epoll descriptor, and the loop watches that one.
    """

    def __init__(self, url: LinkUrl) -> None:
        family, address = resolve(url, socket.SOCK_STREAM)
        self.listener = socket.socket(family, socket.SOCK_STREAM)
        self.listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self.listener.bind(address)
            self.listener.listen(4)
        except OSError as error:
            self.listener.close()
            raise bind_error(url, error) from None
        self.listener.setblocking(False)
        super().__init__(bound_url(url, self.listener))
        self.peer: socket.socket | None = None
        self.out = OutBuffer()
        self.epoll = select.epoll()
        self.epoll.register(self.listener.fileno(), select.EPOLLIN)
        log.info("listening on %s", self.url)

    @property
    def fd(self) -> int | None:
        """See ``Link``."""
        return self.epoll.fileno()

    @property
    def is_up(self) -> bool:
        """See ``Link``."""
        return self.peer is not None

    def receive(self, now_ns: int) -> bytes:
        """See ``Link``."""
        data = b""
        for fd, events in self.epoll.poll(0):
            if fd == self.listener.fileno():
                self._accept()
            elif self.peer is not None and fd == self.peer.fileno():
                if events & select.EPOLLOUT:
                    self.flush(now_ns)
                data = self._read()
        return data

    def _accept(self) -> None:
        try:
            peer, address = self.listener.accept()
        except OSError:  # gone again before we looked
            return
        self._drop("replaced by a new connection")
        peer.setblocking(False)
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.peer = peer
        self.out = OutBuffer()
        self.epoch += 1
        self.epoll.register(peer.fileno(), select.EPOLLIN)
        log.info("%s: %s:%s connected", self.url, address[0], address[1])

    def _read(self) -> bytes:
        if self.peer is None:
            return b""
        try:
            data = self.peer.recv(READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as error:
            self._drop(error.strerror or str(error))
            return b""
        if not data:
            self._drop("closed by the other end")
        self.received_bytes += len(data)
        return data

    def send(self, message: bytes, now_ns: int) -> None:
        """See ``Link``."""
        if self.peer is None or not self.out.push(message):
            self.dropped_messages += 1
            return
        self.flush(now_ns)

    def flush(self, now_ns: int) -> None:
        """See ``Link``."""
        if self.peer is None:
            return
        try:
            self.sent_bytes += self.out.drain(self.peer.send)
        except OSError as error:
            self._drop(error.strerror or str(error))
            return
        self.epoll.modify(self.peer.fileno(), select.EPOLLIN | (select.EPOLLOUT if self.out.data else 0))

    def _drop(self, reason: str) -> None:
        if self.peer is None:
            return
        log.info("%s: connection ended: %s", self.url, reason)
        self.epoll.unregister(self.peer.fileno())
        self.peer.close()
        self.peer = None

    def close(self) -> None:
        """See ``Link``."""
        self._drop("stopping")
        self.epoll.close()
        self.listener.close()
