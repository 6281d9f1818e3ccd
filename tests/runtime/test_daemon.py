"""The daemon in this process: the built-in vehicle on one link, and a foreign client on its loop."""

import socket
import time
from itertools import cycle, pairwise

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.config.parsing import parse_config
from attest_mav.errors import ConfigError
from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.runtime.daemon import Daemon
from attest_mav.runtime.loop import READ, Handler, Timer, Watch
from attest_mav.service.kept_state import parse_state
from attest_mav.types import EarthField

PERIOD_NS = 5_000_000
PATIENCE_NS = 20_000_000_000
CONFIG = "[[link]]\nurl = 'sim:still'\n[[link]]\nurl = 'udpin:127.0.0.1:0'\n[log]\nstatus_s = 0.1\n"


class Page(Handler):
    """A foreign client, as a web page would be: each byte it sends is answered with a number out of a snapshot."""

    def __init__(self, daemon, sock):
        self.daemon, self.socket = daemon, sock

    @property
    def watch(self):
        return Watch(self.socket.fileno(), 0, READ)

    def readable(self, now_ns):
        self.socket.recv(1)
        self.socket.send(b"%d\n" % self.daemon.snapshot(now_ns).samples)


class Observer:
    """A timer on the daemon's loop: asks the page, hears the UDP link, and stops after five attitudes."""

    def __init__(self, daemon):
        self.daemon = daemon
        self.page, self.browser = socket.socketpair()
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.connect(("127.0.0.1", int(daemon.links[1].url.rpartition(":")[2])))
        station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self.udp.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(station))
        for sock in (self.browser, self.udp):
            sock.setblocking(False)
        self.ticks, self.answers, self.heard, self.snapshots = [], b"", [], []
        self._parser = mavlink.MAVLink(None)
        daemon.loop.add(Page(daemon, self.page))
        daemon.loop.add(Timer(lambda: self.ticks[-1] + PERIOD_NS if self.ticks else 0, self.tick))

    def tick(self, now_ns):
        self.ticks.append(now_ns)
        self.browser.send(b"?")
        self.answers += self._receive(self.browser)
        self.listen()
        self.snapshots.append(self.daemon.snapshot(now_ns))
        if len(self.of_type("ATTITUDE_QUATERNION")) >= 5 or now_ns - self.ticks[0] > PATIENCE_NS:
            self.daemon.loop.stop()

    def listen(self):
        while data := self._receive(self.udp):
            self.heard += self._parser.parse_buffer(data) or []

    def _receive(self, sock):
        try:
            return sock.recv(2000)
        except BlockingIOError:
            return b""

    def of_type(self, name):
        return [one for one in self.heard if one.get_type() == name]

    def close(self):
        for sock in (self.page, self.browser, self.udp):
            sock.close()


@pytest.fixture
def observer(monkeypatch, tmp_path):
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    observer = Observer(
        Daemon(
            parse_config(f"{CONFIG}[record]\nfolder = '{tmp_path}'\n", "test"),
            lambda *_: (EarthField(0.1, 1.1), "a test"),
        )
    )
    yield observer
    observer.close()


def test_a_foreign_client_and_a_timer_live_on_the_daemons_loop(observer, caplog, tmp_path):
    caplog.set_level("INFO", "attest_mav")
    stop, signal = socket.socketpair()
    with stop, signal:
        observer.daemon.run(stop)
    observer.listen()
    counts = [int(line) for line in observer.answers.split()]
    assert counts == sorted(counts)
    assert counts[-1] > 10
    assert len(counts) >= 0.9 * len(observer.ticks)
    last = observer.snapshots[-1]
    assert last.published_lane is not None
    assert last.links[1].attitudes_sent >= 5
    assert last.links[1].traffic.sent_bytes > 5 * 40
    assert last.links[1].traffic.received_bytes == 12 + 9, "the HEARTBEAT"
    assert last.links[0].traffic.received_bytes > 1000
    recorded = b"".join(path.read_bytes() for path in sorted(tmp_path.glob("*.tlog")))
    assert observer.daemon.snapshot(0).recording.written_bytes == len(recorded)
    frames = list(TlogReader(recorded, load_dialect()))
    assert sum(one.component == 1 for one in frames) > 100
    assert sum(one.component == 193 for one in frames) > 5
    assert observer.of_type("HEARTBEAT")[-1].system_status == mavlink.MAV_STATE_POWEROFF
    assert "the first estimate is there" in caplog.messages
    assert any(text.startswith("using RAW_IMU with the filter velocity-aided") for text in caplog.messages)


@pytest.fixture
def jumping_clock(monkeypatch):
    """A time of day that is another one whenever it is asked for, by hours to decades."""
    true_ns, jumps_s = time.time_ns, cycle((0, -3600, 400 * 86400, -9000 * 86400, 1))
    monkeypatch.setattr(time, "time_ns", lambda: true_ns() + next(jumps_s) * 10**9)
    monkeypatch.setattr(time, "time", lambda: time.time_ns() * 1e-9)


@pytest.mark.usefixtures("jumping_clock")
def test_a_time_of_day_that_jumps_moves_nothing(observer, tmp_path):
    stop, signal = socket.socketpair()
    with stop, signal:
        observer.daemon.run(stop)
    last = observer.snapshots[-1]
    assert last.links[1].attitudes_sent >= 5
    assert last.ambiguity == ""
    recorded = b"".join(path.read_bytes() for path in sorted(tmp_path.glob("*.tlog")))
    times = [one.rx_ns for one in TlogReader(recorded, load_dialect()) if one.component == 1]
    assert len(times) > 100
    assert max(b - a for a, b in pairwise(times)) < 10**9
    assert min(b - a for a, b in pairwise(times)) >= 0


def signing_daemon(tmp_path, mode):
    key = tmp_path / "link.key"
    key.write_bytes(bytes(range(32)))
    key.chmod(mode)
    text = f"[[link]]\nurl = 'sim:still'\nsigning = 'sign'\nkey_file = '{key}'\n[state]\nfolder = '{tmp_path}/state'\n"
    return Daemon(parse_config(text, "test"), lambda *_: (EarthField(0.1, 1.1), "a test"))


def test_a_daemon_that_signs_keeps_the_time_of_its_signatures(tmp_path):
    times = []
    for _ in range(2):
        daemon = signing_daemon(tmp_path, 0o600)
        daemon.loop.add(Timer(lambda: 0, lambda _now_ns, daemon=daemon: daemon.loop.stop()))
        stop, signal = socket.socketpair()
        with stop, signal:
            daemon.run(stop)
        times.append(parse_state((tmp_path / "state" / "state.json").read_bytes()).signing_timestamp)
    assert times[0] > 3 * 10**13, "after 2024"
    assert times[1] > times[0]


def test_a_key_that_others_may_read_ends_the_start_and_nothing_is_written(tmp_path):
    with pytest.raises(ConfigError, match="chmod 600"):
        signing_daemon(tmp_path, 0o644)
    assert not (tmp_path / "state").exists()
