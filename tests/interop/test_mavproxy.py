"""A real MAVProxy as client of the daemon, as hub with its own stream rate, and beside us on one link.

MAVProxy itself is installed without its dependencies (maps, video and plots): tools/check does so, else these skip.
"""

import re
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(find_spec("MAVProxy") is None, reason="MAVProxy is not installed")

LISTENING = r"listening on udpin:127\.0\.0\.1:(\d+)"
ONTO_STDERR = "import os, sys; os.dup2(2, 1); os.execv(sys.argv[1], sys.argv[1:])"
"""MAVProxy writes to stdout; programs are read from stderr."""


@pytest.fixture
def mavproxy(start_command):
    """Starts MAVProxy with these options, without modules and files."""
    script = str(Path(sysconfig.get_path("scripts"), "mavproxy.py"))

    def make(*options):
        quiet = ("--daemon", "--no-state", "--default-modules=")
        command = [sys.executable, "-c", ONTO_STDERR, sys.executable, script, *options, *quiet]
        return start_command(command, {"PYTHONUNBUFFERED": "1"})

    return make


def status_file(tmp_path, links):
    path = tmp_path / "proxy.toml"
    path.write_text("".join(f"[[link]]\nurl = '{url}'\n" for url in links) + "[log]\nstatus_s = 1\n")
    return str(path)


def rates(daemon, count):
    """RAW_IMU's rate in so many status lines, and all of these lines."""
    found = [daemon.wait_for(r"\| RAW_IMU ([\d.]+) of 50 Hz.*") for _ in range(count)]
    return [float(one[1]) for one in found], [one[0] for one in found]


def test_as_client_it_receives_our_attitude_and_takes_us_for_no_vehicle(start, mavproxy, tmp_path):
    daemon = start("run", "--config", status_file(tmp_path, ["udpin:127.0.0.1:0", "udpin:127.0.0.1:0"]))
    vehicle_port, client_port = daemon.wait_for(LISTENING)[1], daemon.wait_for(LISTENING)[1]
    proxy = mavproxy(f"--master=udpout:127.0.0.1:{client_port}", "--cmd=watch ATTITUDE_QUATERNION")
    start("sim", "--link", f"udpout:127.0.0.1:{vehicle_port}", "--scenario", "hover")
    daemon.wait_for("the first estimate is there")
    proxy.wait_for(r"ATTITUDE_QUATERNION \{time_boot_ms : \d+")
    assert not any("online system" in line for line in proxy.lines)
    assert daemon.end() == 0


def test_as_hub_that_sets_its_own_rates_it_leaves_us_45_hz(start, mavproxy, tmp_path):
    """The first fall lasts until two seconds of low rate have been measured; later ones are met at once."""
    vehicle = start("sim", "--link", "tcpin:127.0.0.1:0", "--scenario", "square")
    vehicle_port = vehicle.wait_for(r"tcpin:127\.0\.0\.1:(\d+)")[1]
    daemon = start("run", "--config", status_file(tmp_path, ["udpin:127.0.0.1:0"]))
    port = daemon.wait_for(LISTENING)[1]
    mavproxy(f"--master=tcp:127.0.0.1:{vehicle_port}", f"--out=udpout:127.0.0.1:{port}")
    daemon.wait_for("the first estimate is there")
    daemon.wait_for("RAW_IMU arrives at .* asking again")
    daemon.wait_for("another program on this link lowers the rate")
    measured, lines = rates(daemon, 15)
    assert sum(measured) / len(measured) >= 45.0
    assert all("another program on this link lowers the rate" in line for line in lines)
    assert not any("DISAGREES" in line for line in daemon.lines)
    assert daemon.end() == 0


def test_beside_us_on_one_link_neither_disturbs_the_other(start, mavproxy, hub, tmp_path):
    daemon = start("run", "--config", status_file(tmp_path, [f"udpout:127.0.0.1:{hub.port}"]))
    proxy = mavproxy(f"--master=udpout:127.0.0.1:{hub.port}", "--streamrate=-1")
    start("sim", "--link", f"udpout:127.0.0.1:{hub.port}", "--scenario", "square")
    daemon.wait_for("the first estimate is there")
    proxy.wait_for(r"Detected vehicle 1:1 on link 0")
    daemon.wait_for("held back on udpout:127")
    measured, _ = rates(daemon, 5)
    assert sum(measured) / len(measured) >= 45.0
    assert not [line for line in proxy.lines if re.search(r"online system (?!1$)|Detected vehicle (?!1:)", line)]
    assert daemon.end() == 0
