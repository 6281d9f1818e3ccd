"""The site of the daemon: a listener on the event loop, with a bounded number of connections.

An observer must not cost the attitude: an address that cannot be had is told once and tried again for ever.
"""

import logging
import socket
from collections.abc import Callable
from http import HTTPStatus
from importlib.resources import files
from typing import Final

from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError
from attest_mav.runtime.links.base import Address, bind_error, bound_url, resolve
from attest_mav.runtime.loop import READ, Handler, Loop, Watch
from attest_mav.runtime.web.client import Client
from attest_mav.service.snapshot import Snapshot
from attest_mav.web.document import encoded
from attest_mav.web.request import Refusal, Request
from attest_mav.web.response import Response, event
from attest_mav.web.site import Site

log = logging.getLogger("attest_mav.web")

MAX_CLIENTS: Final = 16
"""Connections served at once."""
MAX_STREAMS: Final = 8
"""Streams of events among them: the rest is left for short requests."""
EVENTS_NS: Final = 250_000_000
"""Period of the events."""
RETRY_NS: Final = 5_000_000_000
"""A listener that cannot be had, or a system without descriptors left, is tried again after this time."""
FILES: Final = {
    "/": ("attest_mav.web", "live.html"),
    "/live.css": ("attest_mav.web", "live.css"),
    "/live.js": ("attest_mav.web", "live.js"),
    "/charts.js": ("attest_mav.web", "charts.js"),
    "/elements.js": ("attest_mav.web", "elements.js"),
    "/horizon.js": ("attest_mav.web", "horizon.js"),
    "/tables.js": ("attest_mav.web", "tables.js"),
    "/palette.css": ("attest_mav.report", "palette.css"),
}


class WebServer(Handler):
    """Listens, and sends events. hosts: names that are ours. snapshot: makes one for an instant, ns."""

    def __init__(
        self, loop: Loop, url: LinkUrl, hosts: tuple[str, ...], snapshot: Callable[[int], Snapshot], now_ns: int
    ) -> None:
        self.address = ""
        """Host and port while it listens, else empty."""
        self._loop: Final = loop
        self._url: Final = url
        self._hosts: Final = hosts
        self._snapshot: Final = snapshot
        self._family, self._to = resolve(url, socket.SOCK_STREAM)
        texts = {path: files(package).joinpath(name).read_bytes() for path, (package, name) in FILES.items()}
        self._site: Final = Site(texts)
        self._listener: socket.socket | None = None
        self._streams = 0
        self._clients: Final[list[Client]] = []
        self._accepted = 0
        self._retry_ns: int | None = None
        self._next_event_ns = now_ns
        self._complaint = ""
        self._listen(now_ns)

    @property
    def watch(self) -> Watch | None:
        """See ``Handler``."""
        if self._listener is None or self._retry_ns is not None:
            return None
        return Watch(self._listener.fileno(), self._streams, READ)

    @property
    def next_deadline_ns(self) -> int | None:
        """The next event while somebody waits for it, or the next try to listen."""
        events_ns = self._next_event_ns if any(client.streams for client in self._clients) else None
        return min((one for one in (events_ns, self._retry_ns) if one is not None), default=None)

    def readable(self, now_ns: int) -> None:
        """Accept one connection."""
        if self._listener is None:
            return
        try:
            sock, _ = self._listener.accept()
        except BlockingIOError:
            return
        except OSError:  # gone again, or no descriptor left: the listener would stay readable
            self._retry_ns = now_ns + RETRY_NS
            return
        if len(self._clients) >= MAX_CLIENTS:
            sock.close()
            return
        self._accepted += 1
        client = Client(sock, self._accepted, self._hosts, self._answer, self._forget, now_ns)
        self._clients.append(client)
        self._loop.add(client)

    def due(self, now_ns: int) -> None:
        """Send one event to all who wait for it, and listen again where that failed."""
        if self._retry_ns is not None and now_ns >= self._retry_ns:
            self._retry_ns = None
            if self._listener is None:
                self._listen(now_ns)
        streams = [client for client in self._clients if client.streams]
        if streams and now_ns >= self._next_event_ns:
            self._next_event_ns = now_ns + EVENTS_NS
            data = event(encoded(self._snapshot(now_ns)))
            for client in streams:
                client.push(data, now_ns)

    def close(self) -> None:
        """End all connections and the listener."""
        for client in self._clients.copy():
            client.end()
        if self._listener is not None:
            self._listener.close()
        self._listener = None

    def _answer(self, request: Request | Refusal, now_ns: int) -> Response:
        response = self._site.answer(request, lambda: self._snapshot(now_ns))
        if response.streams and sum(client.streams for client in self._clients) >= MAX_STREAMS:
            return Response(b"all streams of events are in use\n", status=HTTPStatus.SERVICE_UNAVAILABLE)
        return response

    def _forget(self, client: Client) -> None:
        self._clients.remove(client)
        self._loop.remove(client)

    def _listen(self, now_ns: int) -> None:
        """Open the listener, or say why not and when it is tried again."""
        try:
            listener = _listener(self._url, self._family, self._to)
        except LinkError as error:
            if str(error) != self._complaint:
                log.warning("no live page: %s; trying again every %g s", error, RETRY_NS / 1e9)
            self._complaint = str(error)
            self._retry_ns = now_ns + RETRY_NS
            return
        self._complaint = ""
        self._streams += 1
        self._listener = listener
        self.address = bound_url(self._url, listener).partition(":")[2]
        log.info("the live page is at http://%s/", self.address)


def _listener(url: LinkUrl, family: socket.AddressFamily, address: Address) -> socket.socket:
    sock = socket.socket(family, socket.SOCK_STREAM)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        sock.bind(address)
        sock.listen(MAX_CLIENTS)
    except OSError as error:
        sock.close()
        raise bind_error(url, error) from None
    sock.setblocking(False)
    return sock
