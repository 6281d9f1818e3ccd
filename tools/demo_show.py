"""The show behind tools/demo: vehicle and daemon as two programs, and this one as a listener on the daemon's own link.

What is published is compared with the simulator's truth at the time that each message carries. Ends with 1 when
the attitude is worse than the limits, or when one of the programs fails.
"""

import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from math import degrees, sqrt
from pathlib import Path
from typing import IO

from attest_mav.algebra import heading_between, q_to_euler, tilt_between
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.samples import AttitudeSample
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings
from attest_mav.types import Quat

SCENARIO = "hover"
SEED = 1

SHOW_S = 16.0
SETTLED_S = 5.0
"""Seconds of the vehicle's clock: the end of the show, and where the comparison begins. By then the position is known
to the daemon, and with it the declination."""
RATE_HZ = 20.0
PATIENCE_S = 30.0
COMPONENT = 193

MAX_TILT_DEG = 0.8
MAX_HEADING_DEG = 2.0
"""Limits of the root mean square errors."""

CONFIG = f"""
[[link]]
url = "udpin:127.0.0.1:0"
[[link]]
url = "udpin:127.0.0.1:0"
[output]
rate_hz = {RATE_HZ}
[log]
status_s = 4
"""

ATTEST_MAV = [sys.executable, "-m", "attest_mav"]


def start_daemon(folder: str) -> tuple[subprocess.Popen[str], IO[str], list[int]]:
    """The daemon, its log, and the ports of its two links, which the system has chosen."""
    config = Path(folder, "demo.toml")
    config.write_text(CONFIG)
    daemon = subprocess.Popen([*ATTEST_MAV, "run", "--config", str(config)], stderr=subprocess.PIPE, text=True)
    log = daemon.stderr
    if log is None:
        raise RuntimeError("no pipe was made")
    ports: list[int] = []
    while len(ports) < 2:
        line = log.readline()
        if not line:
            sys.exit("demo: the daemon ended at once")
        print(f"  daemon: {line}", end="")
        if found := re.search(r"listening on udpin:127\.0\.0\.1:(\d+)", line):
            ports.append(int(found[1]))
    return daemon, log, ports


def show_log(log: IO[str]) -> None:
    """Print what the daemon says while it runs."""
    for line in log:
        print(f"  daemon: {line}", end="", flush=True)


def published(port: int) -> Iterator[AttitudeSample]:
    """The attitudes that the daemon sends on its second link, as they come."""
    dialect = load_dialect()
    decoder = Decoder(dialect)
    framer = Framer(dialect, frozenset([dialect.id_of("ATTITUDE_QUATERNION")]))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.connect(("127.0.0.1", port))
        listener.settimeout(PATIENCE_S)
        listener.send(b"\0")  # a listening link answers whoever has spoken
        while True:
            for frame in framer.feed(listener.recv(65536), time.monotonic_ns()):
                if frame.component == COMPONENT:
                    yield from (one for one in decoder.decode(frame) if isinstance(one, AttitudeSample))


def euler_text(q_nb: Quat) -> str:
    """Roll, pitch and yaw in degrees, in columns."""
    roll, pitch, yaw = (degrees(angle) for angle in q_to_euler(q_nb))
    return f"{roll:7.2f} {pitch:7.2f} {yaw % 360.0:7.2f}"


def watch(port: int) -> list[tuple[float, float]]:
    """Show the attitudes beside the truth, one a second; tilt and heading errors (deg) of all after ``SETTLED_S``."""
    truth = FakeAutopilot(SimSettings(scenario=SCENARIO), SEED)
    errors: list[tuple[float, float]] = []
    next_line_s = 0.0
    for sample in published(port):
        t_s = sample.t_ns * 1e-9
        true_q = truth.truth(sample.t_ns).q_nb
        tilt = degrees(tilt_between(true_q, sample.q_nb))
        heading = degrees(heading_between(true_q, sample.q_nb))
        if t_s >= SETTLED_S:
            errors.append((tilt, heading))
        if next_line_s == 0.0:
            print(f"{'':>7}  {'published by the daemon':^23}  {'simulator truth':^23}  difference")
            print(f"{'time s':>7}" + 2 * f"  {'roll':>7} {'pitch':>7} {'yaw':>7}" + "  tilt  heading (degrees)")
        if t_s >= next_line_s:
            next_line_s = max(next_line_s, t_s // 1.0) + 1.0
            text = f"{t_s:7.2f}  {euler_text(sample.q_nb)}  {euler_text(true_q)}  {tilt:4.2f}  {heading:+6.2f}"
            print(text, "" if t_s >= SETTLED_S else " (heading still magnetic)" * (abs(heading) > 5.0), flush=True)
        if t_s >= SHOW_S:
            break
    return errors


def verdict(errors: list[tuple[float, float]]) -> bool:
    """Print the result; True when it is within the limits."""
    expected = (SHOW_S - SETTLED_S) * RATE_HZ
    good = abs(len(errors) - expected) < 0.1 * expected
    print(f"\n{len(errors)} attitudes compared with the truth ({expected:.0f} expected):")
    print(f"  {'error, degrees':<16} {'rms':>6} {'worst':>6} {'limit of rms':>13}")
    for number, (name, limit) in enumerate((("tilt", MAX_TILT_DEG), ("heading", MAX_HEADING_DEG))):
        values = [abs(row[number]) for row in errors]
        rms = sqrt(sum(value * value for value in values) / max(len(values), 1))
        good = good and rms <= limit
        print(f"  {name:<16} {rms:6.2f} {max(values, default=0.0):6.2f} {limit:13.2f}")
    return good


def main() -> int:
    """The exit code of the demo."""
    print(f"A fake ArduPilot copter ({SCENARIO}) and the daemon, over UDP on this computer:\n")
    with tempfile.TemporaryDirectory() as folder:
        daemon, log, ports = start_daemon(folder)
        logger = threading.Thread(target=show_log, args=(log,), daemon=True)
        logger.start()
        flight = ["--link", f"udpout:127.0.0.1:{ports[0]}", "--scenario", SCENARIO, "--seed", str(SEED)]
        vehicle = subprocess.Popen([*ATTEST_MAV, "sim", *flight], stderr=subprocess.DEVNULL)
        try:
            errors = watch(ports[1])
            daemon.send_signal(signal.SIGINT)
            clean = daemon.wait(PATIENCE_S) == 0
            logger.join(PATIENCE_S)
        except TimeoutError:
            errors, clean = [], False
            print(f"demo: nothing came for {PATIENCE_S:g} s")
        finally:
            daemon.kill()
            vehicle.kill()
            vehicle.wait()
    good = verdict(errors) and clean
    print("\nThe demo succeeded." if good else "\nThe demo FAILED.")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
