"""Real sockets and pseudo-terminals on this machine; the clock is a number."""

import os
import pty
import select
import socket
import termios

import pytest

from attest_mav.config.link_url import parse_link
from attest_mav.errors import LinkError
from attest_mav.runtime.links.base import BUFFER_BYTES, FIRST_RETRY_NS, LONGEST_RETRY_NS, Backoff
from attest_mav.runtime.links.open import open_link
from attest_mav.runtime.links.tcp_server import IDLE_NS, MAX_CLIENTS
from attest_mav.runtime.links.udp_peers import FIRST_SILENCE_NS, MAX_PEERS, PROVEN_NS, SILENCE_NS, UdpPeers

SECOND = 1_000_000_000
PATIENCE_S = 5.0


@pytest.fixture
def opened():
    """Opens links by URL and closes them in the end."""
    links = []

    def make(url, **options):
        links.append(open_link(parse_link(url), 0, **options))
        return links[-1]

    yield make
    for link in links:
        link.close()


def wait(link, write=False):
    """Until the link's descriptor is ready."""
    reading, writing = ([], [link.fd]) if write else ([link.fd], [])
    ready = select.select(reading, writing, [], PATIENCE_S)
    assert ready[0] or ready[1], f"{link.url}: nothing came"


def receive(link, now_ns=0):
    wait(link)
    return link.receive(now_ns)


def other_end(url):
    """The host and port of a listener."""
    _, host, port = url.split(":")
    return host, int(port)


def test_udp_both_ways(opened):
    listener = opened("udpin:127.0.0.1:0")
    caller = opened(listener.url.replace("udpin", "udpout"))
    assert not listener.is_up
    assert listener.receive(0) == b"", "nothing there is nothing, not an error"
    caller.send(b"first", 0)
    assert receive(listener) == b"first"
    assert not listener.is_up
    listener.send(b"too early", 0)
    listener.confirm(0)
    assert listener.is_up
    listener.send(b"answer", 0)
    assert receive(caller) == b"answer"
    assert (caller.sent_bytes, listener.received_bytes, listener.dropped_messages) == (5, 5, 1)


def test_the_port_that_was_chosen_is_said(opened, caplog):
    caplog.set_level("INFO", "attest_mav")
    link = opened("udpin:127.0.0.1:0")
    assert other_end(link.url)[1] > 0
    assert f"listening on {link.url}" in caplog.messages


def speak(peers, address, begin_ns, end_ns):
    """Frames of one sender each 0.1 s."""
    for now_ns in range(begin_ns, end_ns + 1, SECOND // 10):
        peers.heard(address, now_ns)


VEHICLE = ("192.0.2.1", 14550)


def test_a_listener_answers_nobody_for_bytes_that_are_no_mavlink(opened):
    listener = opened("udpin:127.0.0.1:0")
    caller = opened(listener.url.replace("udpin", "udpout"))
    for number in range(100):
        caller.send(b"\xfd", number)
        receive(listener, number)
        listener.send(b"answer", number)
    assert (listener.sent_bytes, listener.dropped_messages) == (0, 100)


def test_one_frame_with_a_forged_source_is_answered_for_three_seconds():
    peers = UdpPeers()
    assert peers.heard(VEHICLE, 0)
    assert peers.answered(FIRST_SILENCE_NS) == [VEHICLE]
    assert peers.answered(FIRST_SILENCE_NS + 1) == []


def test_a_known_sender_is_answered_for_half_a_minute_and_the_last_one_for_ever():
    peers = UdpPeers()
    speak(peers, VEHICLE, 0, PROVEN_NS)
    speak(peers, ("192.0.2.2", 1), 0, PROVEN_NS + SECOND)
    assert len(peers.answered(PROVEN_NS + SILENCE_NS)) == 2
    assert peers.answered(10 * SILENCE_NS) == [("192.0.2.2", 1)]


def test_new_senders_displace_no_known_one_and_are_bounded():
    peers = UdpPeers()
    speak(peers, VEHICLE, 0, PROVEN_NS)
    for port in range(20_000):
        peers.heard(("198.51.100.9", port), PROVEN_NS + port)
        assert len(peers) <= MAX_PEERS
    assert VEHICLE in peers.answered(PROVEN_NS + 20_000)
    full = UdpPeers()
    for port in range(MAX_PEERS):
        speak(full, ("192.0.2.2", port), 0, PROVEN_NS)
    assert not full.heard(VEHICLE, PROVEN_NS)


def test_senders_without_end_are_one_line_a_minute(opened, caplog):
    caplog.set_level("INFO", "attest_mav")
    listener = opened("udpin:127.0.0.1:0")
    for number in range(40):
        opened(listener.url.replace("udpin", "udpout")).send(b"frame", 0)
        receive(listener, number)
        listener.confirm(number)
    assert sum("hearing" in message for message in caplog.messages) == 1
    opened(listener.url.replace("udpin", "udpout")).send(b"frame", 0)
    receive(listener, 61 * SECOND)
    listener.confirm(61 * SECOND)
    assert caplog.messages[-1].endswith("(39 more such lines were left out)")


def test_udp_without_anybody_at_the_other_end_is_no_error(opened):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    caller = opened(f"udpout:127.0.0.1:{port}")
    for _ in range(5):
        caller.send(b"x", 0)
        caller.send(b"y", 0)
        assert caller.receive(0) == b""
    assert caller.dropped_messages == 5, "every second one meets the refusal of the one before"


def test_a_listener_that_nobody_called_drops_and_counts(opened):
    listener = opened("udpin:127.0.0.1:0")
    listener.send(b"x", 0)
    assert listener.dropped_messages == 1


@pytest.mark.parametrize("scheme", ["udpin", "tcpin"])
def test_a_port_that_is_taken_is_an_error_that_says_what_to_do(opened, scheme):
    first = opened(f"{scheme}:127.0.0.1:0")
    with pytest.raises(LinkError, match="stop the program that has the port") as caught:
        opened(first.url)
    assert caught.value.exit_code == 69


@pytest.mark.parametrize("scheme", ["udpin", "tcpin"])
def test_an_address_of_another_machine_is_not_blamed_on_the_port(opened, scheme):
    with pytest.raises(LinkError, match=r"this machine does not have the address; give one of its own, or 0\.0\.0\.0"):
        opened(f"{scheme}:192.0.2.1:0")


@pytest.mark.parametrize("url", ["udpout:no.such.host.invalid:1", "tcp:no.such.host.invalid:1", "udpin:192.0.2.1:0"])
def test_an_address_that_is_not_there_is_one_clear_line(opened, url):
    with pytest.raises(LinkError) as caught:
        opened(url)
    assert "\n" not in str(caught.value)


def test_tcp_both_ways_and_anew_after_a_loss(opened):
    server = opened("tcpin:127.0.0.1:0")
    client = opened(server.url.replace("tcpin", "tcp"))
    assert client.wants_write
    wait(client, write=True)
    client.flush(0)
    assert client.is_up
    assert client.epoch == 1
    assert receive(server) == b""
    assert server.is_up
    client.send(b"to the server", 0)
    assert receive(server) == b"to the server"
    server.send(b"to the client", 0)
    assert receive(client) == b"to the client"

    server.close()
    assert receive(client) == b""
    assert not client.is_up
    assert client.fd is None
    assert client.next_deadline_ns == FIRST_RETRY_NS
    client.send(b"lost", 0)
    assert client.dropped_messages == 1


def test_tcp_waits_for_a_server_with_back_off(opened):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        host, port = free.getsockname()
    client = opened(f"tcp:{host}:{port}")
    now_ns, tries = 0, 0
    while tries < 3:
        if client.fd is not None:
            wait(client, write=True)
            client.flush(now_ns)
        assert client.fd is None
        assert client.next_deadline_ns > now_ns
        now_ns = client.next_deadline_ns
        tries += 1
        client.receive(now_ns)
    with socket.socket() as server:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        server.bind((host, port))
        server.listen()
        if client.fd is not None:
            wait(client, write=True)
            client.flush(now_ns)
        now_ns = client.next_deadline_ns or now_ns
        client.receive(now_ns)
        if not client.is_up:
            wait(client, write=True)
            client.flush(now_ns)
        assert client.is_up


def test_tcp_that_is_not_to_wait_fails(opened):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        host, port = free.getsockname()
    with pytest.raises(LinkError, match="start the server"):
        opened(f"tcp:{host}:{port}", wait=False)


def test_a_connect_without_answer_is_given_up(opened):
    """Of a listener whose queue is full nothing is heard."""
    with socket.socket() as deaf:
        deaf.bind(("127.0.0.1", 0))
        deaf.listen(0)
        fillers = []
        for _ in range(4):
            filler = socket.socket()
            filler.setblocking(False)
            filler.connect_ex(deaf.getsockname())
            fillers.append(filler)
        client = opened(f"tcp:127.0.0.1:{deaf.getsockname()[1]}")
        due_ns = client.next_deadline_ns
        assert due_ns is not None
        assert client.receive(due_ns - 1) == b""
        client.receive(due_ns)
        assert client.fd is None
        assert client.next_deadline_ns == due_ns + FIRST_RETRY_NS
        for filler in fillers:
            filler.close()


def collect(server, count, now_ns=0):
    """The bytes of so many reads, by stream."""
    got = {}
    while count:
        data = receive(server, now_ns)
        if data:
            got[server.stream] = got.get(server.stream, b"") + data
            count -= 1
    return got


def test_connections_do_not_displace_each_other(opened):
    server = opened("tcpin:127.0.0.1:0")
    clients = [socket.create_connection(other_end(server.url)) for _ in range(3)]
    for _ in clients:
        receive(server)
    assert server.epoch == 1
    for number, client in enumerate(clients):
        client.sendall(b"%d" % number)
    assert sorted(collect(server, 3).values()) == [b"0", b"1", b"2"]
    server.send(b"to all", 0)
    for client in clients:
        client.settimeout(PATIENCE_S)
        assert client.recv(10) == b"to all"
        client.close()


def test_connections_are_bounded_and_a_silent_one_makes_room(opened, caplog):
    caplog.set_level("INFO", "attest_mav")
    server = opened("tcpin:127.0.0.1:0")
    clients = []
    for number in range(MAX_CLIENTS + 3):
        clients.append(socket.create_connection(other_end(server.url)))
        receive(server, number)
        assert len(server.clients) <= MAX_CLIENTS
    for late in clients[MAX_CLIENTS:]:
        late.settimeout(PATIENCE_S)
        assert late.recv(1) == b"", "refused"
    clients[0].sendall(b"here")
    receive(server, IDLE_NS)
    back = socket.create_connection(other_end(server.url))
    receive(server, IDLE_NS + MAX_CLIENTS)
    back.sendall(b"back")
    assert collect(server, 1, IDLE_NS + MAX_CLIENTS) == {MAX_CLIENTS + 1: b"back"}
    clients[1].settimeout(PATIENCE_S)
    assert clients[1].recv(1) == b"", "the one that was silent longest"
    assert len([message for message in caplog.messages if "connected" in message]) == 1
    for client in [*clients, back]:
        client.close()


def test_a_reader_that_does_not_read_costs_whole_messages_and_no_memory(opened):
    server = opened("tcpin:127.0.0.1:0")
    with socket.socket() as slow:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        slow.connect(other_end(server.url))
        receive(server)
        message = bytes(range(100))
        count = 0
        while server.dropped_messages < 10:
            server.send(message, 0)
            count += 1
            assert count < 200_000
        (client,) = server.clients.values()
        assert len(client.out.data) <= BUFFER_BYTES
        slow.setblocking(False)
        got = bytearray()
        while len(got) < (count - 10) * 100:
            server.flush(0)
            select.select([slow], [], [], PATIENCE_S)
            got += slow.recv(65536)
        assert bytes(got) == message * (count - 10), "no message is torn"


@pytest.fixture
def terminal():
    """A pseudo-terminal: the file descriptor of its far end and the name of its device."""
    far, near = pty.openpty()
    name = os.ttyname(near)
    os.close(near)
    yield far, name
    os.close(far)


def test_a_serial_port_carries_every_byte(opened, terminal):
    far, name = terminal
    link = opened(f"serial:{name}:57600")
    every = bytes(range(256))
    assert link.receive(0) == b""
    assert link.fd is not None, "silence is no hang-up"
    os.write(far, every)
    got = b""
    while len(got) < 256:
        got += receive(link)
    assert got == every, "no byte means anything to the terminal"
    link.send(every, 0)
    back = b""
    while len(back) < 256:
        assert select.select([far], [], [], PATIENCE_S)[0]
        back += os.read(far, 1000)
    assert back == every
    assert link.receive(0) == b""


def test_a_serial_port_has_one_owner(opened, terminal):
    _, name = terminal
    opened(f"serial:{name}:57600")
    with pytest.raises(LinkError, match="another program has it") as caught:
        opened(f"serial:{name}:57600")
    assert caught.value.exit_code == 69


def test_the_baud_rate_is_set(opened, terminal):
    far, name = terminal
    opened(f"serial:{name}:57600")
    assert termios.tcgetattr(far)[5] == termios.B57600


def test_a_missing_device_is_waited_for(opened, terminal, tmp_path, caplog):
    _, name = terminal
    device = tmp_path / "usb"
    link = opened(f"serial:{device}:57600")
    assert link.fd is None
    assert "plug it in" in caplog.text
    due_ns = link.next_deadline_ns
    link.receive(due_ns)
    assert link.next_deadline_ns > due_ns
    device.symlink_to(name)
    link.receive(link.next_deadline_ns)
    assert link.fd is not None
    assert link.epoch == 1
    assert link.next_deadline_ns is None


def test_a_missing_device_is_an_error_for_who_does_not_wait(opened, tmp_path):
    with pytest.raises(LinkError, match="plug it in"):
        opened(f"serial:{tmp_path / 'usb'}:57600", wait=False)


def test_what_is_no_serial_port_is_an_error(opened, tmp_path):
    file = tmp_path / "file"
    file.write_text("x")
    with pytest.raises(LinkError, match=f"cannot open {file}: it is not a serial port"):
        opened(f"serial:{file}:57600")


def test_an_unplugged_device_is_opened_again(opened, tmp_path):
    far, near = pty.openpty()
    device = tmp_path / "usb"
    device.symlink_to(os.ttyname(near))
    os.close(near)
    link = opened(f"serial:{device}:57600")
    os.close(far)
    device.unlink()
    assert receive(link) == b""
    assert link.fd is None
    link.send(b"lost", 0)
    assert link.dropped_messages == 1
    far, near = pty.openpty()
    device.symlink_to(os.ttyname(near))
    os.close(near)
    link.receive(link.next_deadline_ns)
    assert link.epoch == 2
    os.write(far, b"back")
    assert receive(link) == b"back"
    os.close(far)


def test_back_off_grows_to_a_limit_and_starts_again(caplog):
    backoff = Backoff()
    waits = [backoff.next("link", "gone", 0) for _ in range(8)]
    assert waits[0] == FIRST_RETRY_NS
    assert waits == sorted(waits)
    assert waits[-1] == LONGEST_RETRY_NS
    assert len(caplog.records) == 1, "said once"
    backoff.reset()
    assert backoff.next("link", "gone", 0) == FIRST_RETRY_NS
