"""One loop for links, foreign descriptors and timers: real sockets, and a timer instead of patience."""

import os
import socket
import time

import pytest

from attest_mav.config.link_url import parse_link
from attest_mav.runtime.links.open import open_link
from attest_mav.runtime.links.served import ServedLink
from attest_mav.runtime.loop import READ, WRITE, Handler, Loop, Timer, Watch

MILLISECOND = 1_000_000
PATIENCE_NS = 10_000 * MILLISECOND


class Peer(Handler):
    """One end of a socket pair, as a web client would be: answers what it hears; ends when the other end does."""

    def __init__(self, loop, sock):
        self.loop, self.socket = loop, sock
        self.heard = b""
        self.stream = 0
        self.wants_write = False
        self.writable_count = 0

    @property
    def watch(self):
        return Watch(self.socket.fileno(), self.stream, READ | (WRITE if self.wants_write else 0))

    def readable(self, now_ns):
        try:
            data = self.socket.recv(100)
        except ConnectionResetError:  # the other end has gone without reading our answers
            data = b""
        self.heard += data
        if data:
            self.socket.send(data.upper())
        else:
            self.loop.remove(self)
            self.socket.close()

    def writable(self, now_ns):
        self.writable_count += 1
        self.wants_write = False


class Ticker:
    """Calls a function every few milliseconds; a test that does not end is stopped, and fails by what it asserts."""

    def __init__(self, loop, tick, period_ns=2 * MILLISECOND):
        self.next_ns = time.monotonic_ns()
        self.end_ns = self.next_ns + PATIENCE_NS
        self.count = 0
        self.loop, self.tick, self.period_ns = loop, tick, period_ns
        loop.add(Timer(lambda: self.next_ns, self.due))

    def due(self, now_ns):
        self.count += 1
        self.next_ns = now_ns + self.period_ns
        if now_ns > self.end_ns:
            self.loop.stop()
        self.tick(self.count)


@pytest.fixture
def loop():
    loop = Loop()
    yield loop
    loop.close()


@pytest.fixture
def pair():
    """Makes connected sockets and closes them in the end."""
    made = []

    def make():
        made.extend(socket.socketpair())
        return made[-2:]

    yield make
    for one in made:
        one.close()


@pytest.fixture
def stop(pair):
    """A stop signal (the reading end) and what raises it (the writing end)."""
    return pair()


def test_a_foreign_descriptor_and_a_timer_are_served_while_links_run(loop, pair, stop):
    now_ns = time.monotonic_ns()
    listener = open_link(parse_link("udpin:127.0.0.1:0"), now_ns)
    caller = open_link(parse_link(listener.url.replace("udpin", "udpout")), now_ns)
    got = {"listener": b"", "caller": b""}

    def answer(data, now_ns):
        got["listener"] += data
        listener.confirm(now_ns)
        listener.send(data.upper(), now_ns)

    def hear(data, _now_ns):
        got["caller"] += data

    def nothing():
        pytest.fail("no link was opened again")

    loop.add(ServedLink(listener, answer, nothing))
    loop.add(ServedLink(caller, hear, nothing))
    ours, theirs = pair()
    page = Peer(loop, ours)
    loop.add(page)

    def tick(_count):
        caller.send(b"l", time.monotonic_ns())
        theirs.send(b"p")
        if len(got["caller"]) >= 10 and len(page.heard) >= 10:
            loop.stop()

    ticker = Ticker(loop, tick)
    loop.run(stop[0])
    listener.close()
    caller.close()
    assert got["caller"] == b"L" * len(got["caller"])
    assert 10 <= len(got["caller"]) <= len(got["listener"]) <= ticker.count
    assert 10 <= len(page.heard) <= ticker.count
    assert theirs.recv(100).startswith(b"PPPPPPPPP")


def test_handlers_may_come_and_go_while_it_runs(loop, pair, stop):
    peers, heard = [], []

    def tick(count):
        if count <= 5:
            ours, theirs = pair()
            peers.append((Peer(loop, ours), theirs))
            loop.add(peers[-1][0])
            theirs.send(bytes([count]))
        elif count == 6:
            for _, theirs in peers:
                theirs.close()
        elif all(peer.socket.fileno() < 0 for peer, _ in peers):
            heard.extend(peer.heard for peer, _ in peers)
            loop.stop()

    Ticker(loop, tick)
    loop.run(stop[0])
    assert heard == [b"\x01", b"\x02", b"\x03", b"\x04", b"\x05"]


def test_a_number_that_is_given_out_again_is_watched_anew(loop, pair, stop):
    """A link that is lost and opened within one turn gets the same number; the kernel has forgotten the old one."""
    ours, theirs = pair()
    peer = Peer(loop, ours)
    loop.add(peer)
    again = []

    def tick(count):
        if count == 1:
            theirs.send(b"first")
        elif count == 2:
            new_ours, new_theirs = pair()
            os.dup2(new_ours.fileno(), peer.socket.fileno())  # closes the old one
            new_ours.close()
            peer.stream += 1
            again.append(new_theirs)
        elif count == 3:
            again[0].send(b"second")
        elif b"second" in peer.heard:
            loop.stop()

    Ticker(loop, tick)
    loop.run(stop[0])
    assert peer.heard == b"firstsecond"


def test_a_number_may_pass_from_one_handler_to_another_in_one_turn(loop, pair, stop):
    old, new = pair(), pair()
    first, second = Peer(loop, old[0]), Peer(loop, new[0])
    loop.add(first)

    def tick(count):
        if count == 1:
            loop.remove(first)
            second.socket = socket.socket(fileno=os.dup2(new[0].fileno(), first.socket.fileno()))
            first.socket.detach()
            loop.add(second)
            new[1].send(b"for the second")
        elif second.heard:
            loop.stop()

    Ticker(loop, tick)
    loop.run(stop[0])
    second.socket.close()
    assert (first.heard, second.heard) == (b"", b"for the second")


def test_who_is_removed_is_not_called_any_more_even_in_the_same_turn(loop, pair, stop):
    """Both are readable at once; whichever is served first removes the other."""
    called = []

    class Rival(Peer):
        def readable(self, now_ns):
            called.append(self)
            loop.remove(next(one for one in rivals if one is not self))

    ends = [pair(), pair()]
    rivals = [Rival(loop, ours) for ours, _ in ends]
    for rival, (_, theirs) in zip(rivals, ends, strict=True):
        loop.add(rival)
        theirs.send(b"x")
    loop.add(Timer(lambda: 0, lambda _: loop.stop()))
    loop.run(stop[0])
    assert len(called) == 1


def test_to_be_writable_is_told_when_it_is_wanted_and_only_then(loop, pair, stop):
    peer = Peer(loop, pair()[0])
    loop.add(peer)

    def tick(count):
        peer.wants_write = count == 3
        if count == 6:
            loop.stop()

    Ticker(loop, tick)
    loop.run(stop[0])
    assert peer.writable_count == 1


def test_deadlines_are_met_in_order_after_the_descriptors(loop, pair, stop):
    calls = []
    ours, theirs = pair()

    class Reader(Peer):
        def readable(self, now_ns):
            super().readable(now_ns)
            calls.append("descriptor")

    def end(_):
        calls.append("second")
        loop.stop()

    theirs.send(b"x")
    loop.add(Timer(lambda: 0 if "first" not in calls else None, lambda _: calls.append("first")))
    loop.add(Timer(lambda: 0, end))
    loop.add(Reader(loop, ours))
    loop.run(stop[0])
    assert calls == ["descriptor", "first", "second"]


def test_a_timer_is_not_called_early_however_often_another_one_is(loop, stop):
    asked_ns = time.monotonic_ns() + 20 * MILLISECOND
    called = []

    def due(now_ns):
        called.append(now_ns)
        loop.stop()

    loop.add(Timer(lambda: asked_ns, due))
    Ticker(loop, lambda _: None)
    loop.run(stop[0])
    assert asked_ns <= called[0] <= time.monotonic_ns()


@pytest.mark.parametrize("far_ns", [None, 10**25])
def test_the_stop_signal_is_heard_however_far_the_next_deadline_is(loop, stop, far_ns):
    def never(_):
        pytest.fail("the deadline has not come")

    loop.add(Timer(lambda: far_ns, never))
    stop[1].send(b"x")
    loop.run(stop[0])


def test_after_the_stop_signal_nothing_is_called(loop, stop):
    called = []
    stop[1].send(b"x")
    loop.add(Timer(lambda: 0, called.append))
    loop.run(stop[0])
    assert called == []
