"""The daemon as a process, with the fake autopilot as another and systemd played by a socket."""

import signal
import socket
import subprocess
import sys
import time

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

PATIENCE_S = 30.0
LISTENING = r"listening on (?:udpin|tcpin):127\.0\.0\.1:(\d+)"


@pytest.fixture
def config(tmp_path):
    """A configuration file with one listening link and a quick status."""

    def make(text=""):
        path = tmp_path / "attest-mav.toml"
        path.write_text(f"[[link]]\nurl = 'udpin:127.0.0.1:0'\n[log]\nstatus_s = 0.3\n{text}")
        return str(path)

    return make


class Peer:
    """A ground station on the daemon's UDP link, which hears what the daemon sends."""

    def __init__(self, port):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(("127.0.0.1", int(port)))
        self.socket.settimeout(PATIENCE_S)
        self._parser = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self.socket.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(self._parser))

    def wait_for(self, name, accept=lambda _: True):
        while True:
            for message in self._parser.parse_buffer(self.socket.recv(2000)) or []:
                if message.get_type() == name and accept(message):
                    return message


class Systemd:
    """The receiving end of NOTIFY_SOCKET."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(path)
        self.socket.settimeout(PATIENCE_S)

    def wait_for(self, start):
        """All messages up to the one that starts so."""
        messages = []
        while not messages or not messages[-1].startswith(start):
            messages.append(self.socket.recv(4096).decode())
        return messages

    def forget(self):
        """Drop what has arrived so far."""
        self.socket.setblocking(False)
        try:
            while True:
                self.socket.recv(4096)
        except BlockingIOError:
            self.socket.settimeout(PATIENCE_S)


@pytest.fixture
def systemd(tmp_path):
    server = Systemd(str(tmp_path / "notify"))
    yield server
    server.socket.close()


def test_systemd_sees_ready_and_the_watchdog_with_and_without_a_vehicle_and_stopping(start, config, systemd):
    watchdog = {"NOTIFY_SOCKET": systemd.socket.getsockname(), "WATCHDOG_USEC": "200000"}
    daemon = start("run", "--config", config(), **watchdog)
    port = daemon.wait_for(LISTENING)[1]
    before = systemd.wait_for("STATUS=waiting | no vehicle yet")
    assert before[0] == "READY=1", "a vehicle that is off holds up no boot"
    systemd.wait_for("WATCHDOG=1")

    sim = start("sim", "--link", f"udpout:127.0.0.1:{port}", "--scenario", "still")
    assert "READY=1" not in systemd.wait_for("STATUS=active | RAW_IMU"), "said once"
    systemd.wait_for("WATCHDOG=1")

    assert sim.end() == 0
    daemon.wait_for("attitude withheld: samples stopped")
    systemd.forget()
    silent = [message for _ in range(3) for message in systemd.wait_for("STATUS=waiting")]
    assert "WATCHDOG=1" in silent, "a vehicle that is switched off is no failure"

    peer = Peer(port)
    peer.wait_for("HEARTBEAT", lambda m: m.get_srcComponent() == 193)
    daemon.process.send_signal(signal.SIGTERM)
    systemd.wait_for("STOPPING=1")
    peer.wait_for("HEARTBEAT", lambda m: m.get_srcComponent() == 193 and m.system_status == 7)
    assert daemon.exit_code() == 0
    peer.socket.close()


def test_sighup_reads_the_configuration_again(start, config, systemd):
    path = config()
    daemon = start("run", "--config", path, NOTIFY_SOCKET=systemd.socket.getsockname())
    daemon.wait_for("ready: the links are open")
    begun_us = time.monotonic_ns() // 1000

    config("level = 'debug'\n[output]\nrate_hz = 5\n[streams]\nimu_hz = 100\n")
    systemd.forget()
    daemon.process.send_signal(signal.SIGHUP)
    reloading = systemd.wait_for("RELOADING=1\nMONOTONIC_USEC=")[-1]
    assert begun_us <= int(reloading.rpartition("=")[2]) <= time.monotonic_ns() // 1000
    systemd.wait_for("READY=1")
    daemon.wait_for(r"reload: output\.rate_hz = 5\.0 \(was 20\.0\)")
    daemon.wait_for(r"reload: streams\.imu_hz = 100\.0 needs a restart; 50\.0 stays")

    config("[output]\nratehz = 3")
    daemon.process.send_signal(signal.SIGHUP)
    systemd.wait_for("READY=1")
    daemon.wait_for(r"reload: .*unknown key output\.ratehz; did you mean rate_hz\?; the configuration in force stays")
    assert daemon.end() == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_with_0_even_before_there_is_a_vehicle(start, number):
    daemon = start("run", "--link", "udpin:127.0.0.1:0")
    daemon.wait_for(LISTENING)
    assert daemon.end(number) == 0


def test_the_built_in_vehicle_needs_no_other_process(start):
    daemon = start("run", "--link", "sim:still", "--link", "udpin:127.0.0.1:0")
    peer = Peer(daemon.wait_for(LISTENING)[1])
    message = peer.wait_for("ATTITUDE_QUATERNION")
    assert (message.get_srcSystem(), message.get_srcComponent()) == (1, 193)
    daemon.wait_for("the first estimate is there")
    assert daemon.end() == 0
    peer.socket.close()


def test_a_server_that_goes_away_is_found_again(start, tmp_path):
    server = start("sim", "--link", "tcpin:127.0.0.1:0", "--scenario", "still")
    port = server.wait_for(r"on tcpin:127\.0\.0\.1:(\d+)")[1]
    config = tmp_path / "tcp.toml"
    config.write_text(f"[[link]]\nurl = 'tcp:127.0.0.1:{port}'\n[log]\nstatus_s = 0.3\n")
    daemon = start("run", "--config", str(config))
    daemon.wait_for("the first estimate is there")
    assert server.end() == 0
    daemon.wait_for("trying again")
    start("sim", "--link", f"tcpin:127.0.0.1:{port}", "--scenario", "still")
    daemon.wait_for("connected")
    daemon.wait_for("vehicle found again")
    daemon.wait_for(r"active .* sent (1[5-9]|2\d)\.")
    assert daemon.end() == 0


def test_two_vehicles_are_waited_out(start, config, systemd):
    daemon = start("run", "--config", config(), NOTIFY_SOCKET=systemd.socket.getsockname())
    port = daemon.wait_for(LISTENING)[1]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for system in (1, 2):
            vehicle = mavlink.MAVLink(None, srcSystem=system, srcComponent=1)
            beat = mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3)
            sender.sendto(beat.pack(vehicle), ("127.0.0.1", int(port)))
        daemon.wait_for("several vehicles, systems 1 and 2: name one")
        systemd.wait_for("STATUS=waiting | several vehicles, systems 1 and 2")
    assert daemon.end() == 0


def test_a_busy_port_is_one_line_and_69(start):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        daemon = start("run", "--link", f"udpin:127.0.0.1:{other.getsockname()[1]}")
        assert daemon.exit_code() == 69
    assert len(daemon.lines) == 1
    assert daemon.lines[0].startswith("attest-mav: error: cannot listen on udpin:127.0.0.1:")


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ((), 2, "no link: name one with --link URL"),
        (("--link", "foo"), 2, "link 'foo': expected serial:"),
        (("--link", "sim:loop-the-loop"), 2, "loop-the-loop"),
        (("--config", "/nonexistent/a.toml"), 78, "cannot read the configuration /nonexistent/a.toml"),
        (("--link", "udpout:no.such.host.invalid:1"), 69, "is not known"),
    ],
)
def test_what_cannot_be_meant_is_one_line(start, arguments, code, said):
    daemon = start("run", *arguments)
    assert daemon.exit_code() == code
    assert len(daemon.lines) == 1
    assert daemon.lines[0].startswith("attest-mav: error: ")
    assert said in daemon.lines[0]


def test_a_misspelt_key_is_one_line_and_78(start, config):
    daemon = start("run", "--config", config("[output]\nratehz = 3"))
    assert daemon.exit_code() == 78
    assert len(daemon.lines) == 1
    assert daemon.lines[0].endswith("unknown key output.ratehz; did you mean rate_hz?")


def test_it_runs_where_no_memory_is_both_writable_and_executable(start_command, command):
    """What the unit file's MemoryDenyWriteExecute=yes means, by the kernel's own switch."""
    program = (
        "import ctypes, os, sys\n"
        "if ctypes.CDLL(None).prctl(65, 1, 0, 0, 0): sys.exit('no such switch')  # PR_SET_MDWE\n"
        f"os.execv({command[0]!r}, {command!r} + ['run', '--link', 'sim:still'])\n"
    )
    daemon = start_command([sys.executable, "-c", program], {})
    if daemon.wait_for("headings are true|no such switch")[0] == "no such switch":
        pytest.skip("this kernel cannot be asked for it; Linux can from 6.3 on")
    assert daemon.end() == 0


def test_run_imports_neither_numpy_nor_rich():
    """Each would cost memory and start-up time that a daemon has no use for."""
    program = (
        "import sys, attest_mav.cli.run, attest_mav.runtime.links.sim, attest_mav.runtime.links.serial;"
        "from attest_mav.mavlink.dialect import load_dialect; load_dialect();"
        "from attest_mav.cli.run import find_field; find_field(47.0, 8.0, 400.0);"
        "print([name for name in ('numpy', 'rich', 'pymavlink.mavutil') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
