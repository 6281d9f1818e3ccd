"""Links: byte streams to a vehicle that never block and never give up.

A link is driven by a selector loop::

    link = open_link(parse_link("udpin:127.0.0.1:14550"), now_ns)   # see attest_mav.runtime.links.open
    ...
    when link.fd is readable, or link.next_deadline_ns has come:  data = link.receive(now_ns)
    when link.wants_write and link.fd is writable:                link.flush(now_ns)
    at any time:                                                  link.send(message, now_ns)

``fd`` may change or be None while a link is down; ``epoch`` grows with every new stream, which is when a framer has
to forget the beginning of a frame. ``send`` takes whole messages: one that does not fit into the bounded buffer is
dropped whole and counted, so that a slow link never tears a message or delivers old ones.
"""

import errno
import logging
import socket
from abc import ABC, abstractmethod

from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError
from attest_mav.mavlink.component.line_limit import LineLimit

log = logging.getLogger("attest_mav.link")

READ_BYTES = 65536
"""Largest read, bytes: no datagram is larger."""

BUFFER_BYTES = 8192
"""Bound of the output buffer of a stream, bytes: 0.1 s at 921600 baud. Older attitudes are of no use."""

FIRST_RETRY_NS = 250_000_000
LONGEST_RETRY_NS = 4_000_000_000
"""A lost link is tried again after 0.25 s, then twice as long each time, up to 4 s, for ever."""

Address = tuple[str, int] | tuple[str, int, int, int]


class Link(ABC):
    """The interface of all links."""

    def __init__(self, url: str) -> None:
        self.url = url
        """The URL, with the port that the system chose."""
        self.epoch = 0
        """Byte streams begun; a datagram socket is one stream."""
        self.received_bytes = 0
        """Bytes received."""
        self.sent_bytes = 0
        """Bytes handed to the system."""
        self.dropped_messages = 0
        """Messages not sent, because the link was down or its buffer full."""
        self.stream = 0
        """Number of the byte stream that the last bytes belong to, on a link that has several at once."""
        self._lines = LineLimit()

    @property
    @abstractmethod
    def fd(self) -> int | None:
        """The file descriptor to watch now; None while there is none."""

    @property
    def wants_write(self) -> bool:
        """Whether ``flush`` has something to do once the descriptor is writable."""
        return False

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``receive`` wants to be called even if nothing is readable."""
        return None

    @property
    def is_up(self) -> bool:
        """Whether messages can be sent at all."""
        return self.fd is not None

    @property
    def is_open(self) -> bool:
        """Whether the device or socket is open: a link that listens is open before anyone speaks."""
        return self.fd is not None

    @abstractmethod
    def receive(self, now_ns: int) -> bytes:
        """The bytes of at most one read, empty when none have arrived. Also opens a lost link again when it is due."""

    def confirm(self, now_ns: int) -> None:  # noqa: B027  # most links know their other end
        """The bytes received last held an intact frame: their sender speaks MAVLink."""

    def say(self, kind: str, text: str, now_ns: int) -> None:
        """Log what happened to the link, at most one line of a kind in a minute."""
        suffix = self._lines.suffix(kind, now_ns)
        if suffix is not None:
            log.info("%s: %s%s", self.url, text, suffix)

    @abstractmethod
    def send(self, message: bytes, now_ns: int) -> None:
        """Send one whole message, or drop and count it."""

    @abstractmethod
    def flush(self, now_ns: int) -> None:
        """Send buffered bytes; to be called when the descriptor is writable."""

    @abstractmethod
    def close(self) -> None:
        """Close the link; nothing is sent afterwards."""


class Backoff:
    """When to try again: soon at first, then ever more slowly, up to a limit."""

    def __init__(self) -> None:
        self.wait_ns = FIRST_RETRY_NS
        self.reason = ""

    def next(self, url: str, reason: str, now_ns: int) -> int:
        """The time of the next try. A reason is logged as a warning once, not at every try."""
        level = logging.DEBUG if reason == self.reason else logging.WARNING
        log.log(level, "%s: %s; trying again, at the latest every %g s", url, reason, LONGEST_RETRY_NS / 1e9)
        self.reason = reason
        due_ns = now_ns + self.wait_ns
        self.wait_ns = min(2 * self.wait_ns, LONGEST_RETRY_NS)
        return due_ns

    def reset(self) -> None:
        """The link works: begin with the short wait next time."""
        self.wait_ns = FIRST_RETRY_NS
        self.reason = ""


def resolve(url: LinkUrl, kind: socket.SocketKind) -> tuple[socket.AddressFamily, Address]:
    """Look the host up, once and at the start: a name look-up blocks, so it has no place in the loop."""
    try:
        family, _, _, _, address = socket.getaddrinfo(url.host, url.port, type=kind)[0]
    except (OSError, UnicodeError) as error:
        raise LinkError(f"cannot open {url}: host {url.host!r} is not known ({error}); use an IP address") from None
    return family, address  # type: ignore[return-value]  # only IPv4 and IPv6 are asked for


def bind_error(url: LinkUrl, error: OSError) -> LinkError:
    """One line for a listener that cannot be had."""
    advice = {
        errno.EADDRINUSE: "stop the program that has the port, or choose another",
        errno.EADDRNOTAVAIL: "this machine does not have the address; give one of its own, or 0.0.0.0 for all of them",
        errno.EACCES: "ports below 1024 are the superuser's; choose a higher one",
    }
    what_to_do = advice.get(error.errno or 0, "check address and port")
    return LinkError(f"cannot listen on {url}: {error.strerror or error}; {what_to_do}")


def bound_url(url: LinkUrl, sock: socket.socket) -> str:
    """The URL with the port that the system chose where 0 was asked for."""
    return str(LinkUrl(url.scheme, host=url.host, port=sock.getsockname()[1]))
