"""UDP: ``udpin:`` waits for a vehicle to speak and answers all who spoke lately, ``udpout:`` speaks first."""

import socket

from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError
from attest_mav.runtime.links.base import READ_BYTES, Address, Link, bind_error, bound_url, log, resolve
from attest_mav.runtime.links.udp_peers import UdpPeers

RECEIVE_BUFFER_BYTES = 1 << 20
"""Asked of the kernel: a second of a busy link, so that nothing is lost while the process waits for the processor."""


class _UdpLink(Link):
    """Base of both directions: one non-blocking socket, read one datagram at a time."""

    def __init__(self, url: str, sock: socket.socket) -> None:
        super().__init__(url)
        self.socket = sock
        self.epoch = 1
        sock.setblocking(False)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)

    @property
    def fd(self) -> int | None:
        return self.socket.fileno()

    def flush(self, now_ns: int) -> None:
        """A datagram never waits: it goes or is dropped."""

    def close(self) -> None:
        """See ``Link``."""
        self.socket.close()


class UdpInLink(_UdpLink):
    """Listens, and sends to every address from which intact frames came lately."""

    def __init__(self, url: LinkUrl) -> None:
        family, address = resolve(url, socket.SOCK_DGRAM)
        sock = socket.socket(family, socket.SOCK_DGRAM)
        try:
            sock.bind(address)
        except OSError as error:
            sock.close()
            raise bind_error(url, error) from None
        super().__init__(bound_url(url, sock), sock)
        self.peers = UdpPeers()
        self._sender: Address | None = None
        log.info("listening on %s", self.url)

    @property
    def is_up(self) -> bool:
        """See ``Link``."""
        return len(self.peers) > 0

    def receive(self, now_ns: int) -> bytes:
        """See ``Link``."""
        try:
            data, address = self.socket.recvfrom(READ_BYTES)
        except OSError:  # nothing there, or an earlier datagram of ours was refused
            return b""
        self._sender = address
        self.received_bytes += len(data)
        return data

    def confirm(self, now_ns: int) -> None:
        """See ``Link``."""
        address = self._sender
        if address is not None and self.peers.heard(address, now_ns):
            self.say("hearing", f"hearing {address[0]}:{address[1]}", now_ns)

    def send(self, message: bytes, now_ns: int) -> None:
        """See ``Link``."""
        addresses = self.peers.answered(now_ns)
        if not addresses:
            self.dropped_messages += 1
        for address in addresses:
            try:
                self.sent_bytes += self.socket.sendto(message, address)
            except OSError:
                self.dropped_messages += 1


class UdpOutLink(_UdpLink):
    """Sends to one address and hears only that one."""

    def __init__(self, url: LinkUrl) -> None:
        family, address = resolve(url, socket.SOCK_DGRAM)
        sock = socket.socket(family, socket.SOCK_DGRAM)
        try:
            sock.connect(address)
        except OSError as error:
            sock.close()
            raise LinkError(f"cannot send to {url}: {error.strerror or error}; check the address") from None
        super().__init__(str(url), sock)
        log.info("sending to %s", self.url)

    def receive(self, now_ns: int) -> bytes:
        """See ``Link``."""
        try:
            data = self.socket.recv(READ_BYTES)
        except OSError:  # nothing there, or nobody listens at the other end yet
            return b""
        self.received_bytes += len(data)
        return data

    def send(self, message: bytes, now_ns: int) -> None:
        """See ``Link``."""
        try:
            self.sent_bytes += self.socket.send(message)
        except OSError:  # nobody listens yet, or the network is full
            self.dropped_messages += 1
