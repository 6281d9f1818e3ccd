"""``tcpin:`` listens and serves several peers, each with a byte stream of its own."""

import select
import socket
from typing import Final

from attest_mav.config.link_url import LinkUrl
from attest_mav.runtime.links.base import READ_BYTES, Link, bind_error, bound_url, log, resolve
from attest_mav.runtime.links.out_buffer import OutBuffer

MAX_CLIENTS: Final = 8
"""Connections served at once."""
IDLE_NS: Final = 5_000_000_000
"""Of a full house the connection that has been silent longest makes room, if it has been so for this long: a vehicle
that lost its connection comes back."""


class _Client:
    """One connection. stream: its number."""

    def __init__(self, sock: socket.socket, name: str, stream: int, now_ns: int) -> None:
        self.socket: Final = sock
        self.name: Final = name
        self.stream: Final = stream
        self.heard_ns = now_ns
        self.out: Final = OutBuffer()


class TcpServerLink(Link):
    """A listener with its connections. They all hang on one epoll descriptor, and the loop watches that one."""

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
        self.clients: dict[int, _Client] = {}
        """By file descriptor."""
        self.epoll = select.epoll()
        self.epoll.register(self.listener.fileno(), select.EPOLLIN)
        self._streams = 0
        log.info("listening on %s", self.url)

    @property
    def fd(self) -> int | None:
        """See ``Link``."""
        return self.epoll.fileno()

    @property
    def is_up(self) -> bool:
        """See ``Link``."""
        return bool(self.clients)

    def receive(self, now_ns: int) -> bytes:
        """See ``Link``. One event is served; where there are more, the descriptor stays readable."""
        for fd, events in self.epoll.poll(0, 1):
            if fd == self.listener.fileno():
                self._accept(now_ns)
            elif fd in self.clients:
                client = self.clients[fd]
                if events & select.EPOLLOUT:
                    self._flush(client, now_ns)
                if events & ~select.EPOLLOUT:
                    return self._read(client, now_ns)
        return b""

    def send(self, message: bytes, now_ns: int) -> None:
        """See ``Link``."""
        if not self.clients:
            self.dropped_messages += 1
        for client in list(self.clients.values()):
            if client.out.push(message):
                self._flush(client, now_ns)
            else:
                self.dropped_messages += 1

    def flush(self, now_ns: int) -> None:
        """See ``Link``."""
        for client in list(self.clients.values()):
            self._flush(client, now_ns)

    def close(self) -> None:
        """See ``Link``."""
        for client in list(self.clients.values()):
            self._drop(client, "stopping", client.heard_ns)
        self.epoll.close()
        self.listener.close()

    def _accept(self, now_ns: int) -> None:
        try:
            sock, address = self.listener.accept()
        except OSError:  # gone again before we looked
            return
        name = f"{address[0]}:{address[1]}"
        if len(self.clients) >= MAX_CLIENTS and not self._make_room(now_ns):
            sock.close()
            self.say("refused", f"{name} refused: {MAX_CLIENTS} connections are in use", now_ns)
            return
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.epoch += 0 if self.clients else 1
        self._streams += 1
        self.clients[sock.fileno()] = _Client(sock, name, self._streams, now_ns)
        self.epoll.register(sock.fileno(), select.EPOLLIN)
        self.say("connected", f"{name} connected", now_ns)

    def _make_room(self, now_ns: int) -> bool:
        """End the connection that has been silent longest; False where all of them are in use."""
        idle = min(self.clients.values(), key=lambda client: client.heard_ns)
        if now_ns - idle.heard_ns < IDLE_NS:
            return False
        self._drop(idle, "silent, and another one wants its place", now_ns)
        return True

    def _read(self, client: _Client, now_ns: int) -> bytes:
        try:
            data = client.socket.recv(READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as error:
            self._drop(client, error.strerror or str(error), now_ns)
            return b""
        if not data:
            self._drop(client, "closed by the other end", now_ns)
        client.heard_ns = now_ns
        self.stream = client.stream
        self.received_bytes += len(data)
        return data

    def _flush(self, client: _Client, now_ns: int) -> None:
        try:
            self.sent_bytes += client.out.drain(client.socket.send)
        except OSError as error:
            self._drop(client, error.strerror or str(error), now_ns)
            return
        self.epoll.modify(client.socket.fileno(), select.EPOLLIN | (select.EPOLLOUT if client.out.data else 0))

    def _drop(self, client: _Client, reason: str, now_ns: int) -> None:
        self.say("ended", f"connection of {client.name} ended: {reason}", now_ns)
        self.epoll.unregister(client.socket.fileno())
        del self.clients[client.socket.fileno()]
        client.socket.close()
