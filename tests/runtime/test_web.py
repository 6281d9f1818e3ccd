"""The site on an event loop whose clock the test sets: answers, events, and clients that misbehave."""

import json
import logging
import re
import select
import socket

import pytest

from attest_mav.config.link_url import parse_link
from attest_mav.config.parsing import parse_config
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.runtime.loop import READ, WRITE
from attest_mav.runtime.web.client import REQUEST_NS, Client
from attest_mav.runtime.web.server import EVENTS_NS, FILES, MAX_CLIENTS, MAX_STREAMS, RETRY_NS, WebServer
from attest_mav.service.assembly import service_settings
from attest_mav.service.service import Service
from attest_mav.types import EarthField
from attest_mav.web.response import Response

SECOND = 1_000_000_000
HOST = "Host: localhost\r\n\r\n"


class HandLoop:
    """A loop whose turns and time are the test's."""

    def __init__(self):
        self.handlers = []
        self.now_ns = SECOND

    def add(self, handler):
        self.handlers.append(handler)

    def remove(self, handler):
        self.handlers.remove(handler)

    def turn(self, seconds=0.0):
        """Let the time pass, and serve everything that is ready or due then, until nothing is."""
        self.now_ns += round(seconds * SECOND)
        for _ in range(200):
            if not self._serve_ready() and not self._serve_due():
                return

    def _serve_ready(self):
        poll = select.poll()
        watched = {}
        for handler in self.handlers:
            if (watch := handler.watch) is not None:
                watched[watch.fd] = handler
                flags = (select.POLLIN if watch.events & READ else 0) | (select.POLLOUT if watch.events & WRITE else 0)
                poll.register(watch.fd, flags)
        ready = poll.poll(5)
        for fd, events in ready:
            if events & select.POLLOUT and watched[fd] in self.handlers:
                watched[fd].writable(self.now_ns)
            if events & ~select.POLLOUT and watched[fd] in self.handlers:
                watched[fd].readable(self.now_ns)
        return bool(ready)

    def _serve_due(self):
        due = [one for one in self.handlers if (one.next_deadline_ns or self.now_ns + 1) <= self.now_ns]
        for handler in due:
            if handler in self.handlers:
                handler.due(self.now_ns)
        return bool(due)


class Served:
    """A server with an idle service behind it, and the connections that the test has opened."""

    def __init__(self, port=0):
        self.loop = HandLoop()
        config = parse_config("[[link]]\nurl = 'udpin::0'\n", "test")
        field = EarthField(0.2, -1.1)
        service = Service(service_settings(config), ["udpin::0"], load_dialect(), lambda *_: (field, "a test"), 0)
        url = parse_link(f"tcpin:127.0.0.1:{port}")
        self.server = WebServer(self.loop, url, (), service.snapshot, self.loop.now_ns)
        self.loop.add(self.server)
        self.opened = []

    def connect(self, text="", buffer_bytes=0):
        sock = socket.socket()
        if buffer_bytes:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
        sock.connect(("127.0.0.1", int(self.server.address.rpartition(":")[2])))
        sock.settimeout(5.0)
        self.opened.append(sock)
        sock.sendall(text.encode())
        self.loop.turn()
        return sock

    def get(self, path, method="GET"):
        """The head and the body of an answer."""
        sock = self.connect(f"{method} {path} HTTP/1.1\r\n{HOST}")
        head, _, body = all_of(sock).partition(b"\r\n\r\n")
        sock.close()
        self.loop.turn()
        return head.decode(), body

    @property
    def clients(self):
        return len(self.loop.handlers) - 1

    def close(self):
        self.server.close()
        for sock in self.opened:
            sock.close()


def all_of(sock):
    parts = []
    while part := sock.recv(65536):
        parts.append(part)
    return b"".join(parts)


def is_ended(sock):
    """Whether the other end has closed the connection, after what it may have sent."""
    try:
        all_of(sock)
    except ConnectionResetError:
        return True
    except TimeoutError:
        return False
    return True


@pytest.fixture
def served():
    made = Served()
    yield made
    made.close()


def test_the_page_with_all_that_it_asks_for_and_nothing_else(served):
    head, page = served.get("/")
    assert head.startswith("HTTP/1.1 200 OK\r\n")
    assert "Content-Security-Policy: default-src 'none'; script-src 'self';" in head
    text = page.decode()
    asked, left = {"/live.js", "/live.css", "/palette.css"}, ["/live.js", "/live.css", "/palette.css"]
    assert all(f'"{path}"' in text for path in asked)
    for path in left:  # grows by what the scripts import
        head, body = served.get(path)
        assert head.startswith("HTTP/1.1 200 OK\r\n")
        assert len(body) > 500
        imports = {f"/{name}" for name in re.findall(r'from "\./(\w+\.js)"', body.decode())}
        left += sorted(imports - asked)
        asked |= imports
    assert asked == FILES.keys() - {"/"}
    assert "http" not in text
    assert "style=" not in text
    assert "<script>" not in text
    assert served.clients == 0


def test_documents_heads_and_refusals(served):
    assert json.loads(served.get("/status")[1])["state"] == "waiting"
    assert served.get("/healthz")[0].startswith("HTTP/1.1 503"), "the test's link is not open"
    head, body = served.get("/metrics", "HEAD")
    assert "Content-Type: text/plain; version=0.0.4" in head
    assert body == b""
    head, _ = served.get("/status", "DELETE")
    assert head.startswith("HTTP/1.1 405")
    assert "Allow: GET, HEAD" in head


def test_a_request_may_come_byte_by_byte(served):
    sock = served.connect()
    for byte in f"GET /status HTTP/1.1\r\n{HOST}":
        sock.send(byte.encode())
        served.loop.turn()
    assert b"200 OK" in all_of(sock)


def test_events_come_four_times_a_second_until_the_reader_leaves(served):
    sock = served.connect(f"GET /events HTTP/1.1\r\n{HOST}")
    for _ in range(8):
        served.loop.turn(EVENTS_NS / SECOND)
    sock.setblocking(False)
    text = sock.recv(1 << 20).decode()
    events = [json.loads(line[6:]) for line in text.splitlines() if line.startswith("data: ")]
    times = [one["now_s"] for one in events]
    assert len(times) >= 8
    assert times[-1] - times[1] == pytest.approx((len(times) - 2) * EVENTS_NS / SECOND)
    sock.close()
    served.loop.turn()
    assert served.clients == 0
    assert served.server.next_deadline_ns is None, "nobody waits for events"


def test_a_client_that_asks_nothing_or_too_slowly_is_dropped(served):
    sock = served.connect("GET / HT")
    served.loop.turn(0.9 * REQUEST_NS / SECOND)
    assert served.clients == 1
    served.loop.turn(0.2 * REQUEST_NS / SECOND)
    assert served.clients == 0
    assert is_ended(sock)


def test_a_client_that_sends_without_end_is_answered_and_dropped(served):
    sock = served.connect("GET / HTTP/1.1\r\nX: " + 20000 * "x")
    assert b" 431 " in sock.recv(4096)
    served.loop.turn(2.0)
    assert served.clients == 0


def test_a_stream_that_nobody_reads_costs_a_bounded_buffer_and_ends(served):
    sock = served.connect(f"GET /events HTTP/1.1\r\n{HOST}", buffer_bytes=4096)
    largest, began_ns = 0, served.loop.now_ns
    while served.clients and served.loop.now_ns - began_ns < 600 * SECOND:
        served.loop.turn(EVENTS_NS / SECOND)
        largest = max([largest, *(len(one._out) for one in served.loop.handlers if one is not served.server)])
    assert served.clients == 0
    assert 0 < largest < 20_000
    assert is_ended(sock)


def test_a_reader_that_is_slow_misses_events_and_stays():
    ours, theirs = socket.socketpair()
    ended = []
    client = Client(ours, 1, (), lambda *_: Response(b"", streams=True), ended.append, 0)
    with theirs:
        theirs.setblocking(False)
        theirs.send(f"GET /events HTTP/1.1\r\n{HOST}".encode())
        client.readable(0)
        sent = received = 0
        for second in range(200):
            for _ in range(4):
                client.push(5000 * b"x", second * SECOND)
                sent += 5000
            received += len(theirs.recv(6000))
            client.writable(second * SECOND)
            assert client.next_deadline_ns is None or client.next_deadline_ns > second * SECOND
        assert not ended
        assert 900_000 < received < sent / 2
        client.end()


def test_connections_are_bounded_and_streams_leave_room_for_short_requests(served):
    streams = [served.connect(f"GET /events HTTP/1.1\r\n{HOST}") for _ in range(MAX_STREAMS + 1)]
    assert b" 200 " in streams[-2].recv(15)
    assert b" 503 " in streams[-1].recv(15)
    assert served.get("/status")[0].startswith("HTTP/1.1 200")
    for _ in range(2 * MAX_CLIENTS):
        served.connect("GET")
    assert served.clients == MAX_CLIENTS
    served.loop.turn(1.1 * REQUEST_NS / SECOND)
    assert served.clients == MAX_STREAMS
    assert served.get("/status")[0].startswith("HTTP/1.1 200")


def test_an_address_that_is_taken_is_told_once_and_had_later(caplog):
    caplog.set_level(logging.INFO, "attest_mav")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        served = Served(other.getsockname()[1])
        assert served.server.address == ""
        for _ in range(3):
            served.loop.turn(RETRY_NS / SECOND)
    served.loop.turn(RETRY_NS / SECOND)
    complaints = [one for one in caplog.messages if one.startswith("no live page: cannot listen on")]
    assert len(complaints) == 1
    assert served.get("/status")[0].startswith("HTTP/1.1 200")
    served.close()
