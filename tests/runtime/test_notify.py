import os
import socket

import pytest

from attest_mav.runtime.notify import Notifier


@pytest.fixture(params=["path", "abstract"])
def systemd(request, tmp_path):
    """A notification socket as systemd makes it, and its name as systemd writes it."""
    name = str(tmp_path / "notify") if request.param == "path" else f"@attest-mav-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as server:
        server.bind(name.replace("@", "\0", 1) if name.startswith("@") else name)
        server.settimeout(5.0)
        yield server, name


def test_messages_arrive_as_systemd_wants_them(systemd):
    server, name = systemd
    notifier = Notifier({"NOTIFY_SOCKET": name})
    notifier.ready()
    notifier.alive()
    notifier.status("two\nlines")
    notifier.reloading(1_234_567_891)
    notifier.stopping()
    notifier.close()
    notifier.ready()
    assert [server.recv(100) for _ in range(5)] == [
        b"READY=1",
        b"WATCHDOG=1",
        b"STATUS=two lines",
        b"RELOADING=1\nMONOTONIC_USEC=1234567",
        b"STOPPING=1",
    ]


def test_without_a_socket_nothing_happens():
    notifier = Notifier({})
    notifier.ready()
    assert notifier.watchdog_ns is None
    notifier.close()


def test_a_socket_that_is_gone_is_survived(tmp_path):
    notifier = Notifier({"NOTIFY_SOCKET": str(tmp_path / "gone")})
    notifier.ready()
    notifier.close()


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({"WATCHDOG_USEC": "30000000"}, 15_000_000_000),
        ({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": str(os.getpid())}, 15_000_000_000),
        ({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": "1"}, None),
        ({"WATCHDOG_USEC": "0"}, None),
        ({"WATCHDOG_USEC": "soon"}, None),
        ({}, None),
    ],
)
def test_half_of_the_watchdogs_patience_if_it_is_ours(environment, expected):
    assert Notifier(environment).watchdog_ns == expected
