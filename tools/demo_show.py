"""The show behind tools/demo: vehicle and daemon as two programs, and this one as a ground station.

What is published is compared with the simulator's truth at the time that each message carries. Then a gyro of the
autopilot fails: its attitude goes wrong, and the daemon has to say so. Ends with 0 only when the attitude was within
the limits throughout, and the wrong attitude and the faulty sensor were named.
"""

import re
import signal
import socket
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
from collections.abc import Iterator
from math import degrees, nan, sqrt
from pathlib import Path
from typing import IO

from attest_mav.algebra import heading_between, q_to_euler, tilt_between
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.constants import MAV_AUTOPILOT_INVALID, MAV_STATE_ACTIVE, MAV_TYPE_GCS
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.samples import AttitudeSample
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings
from attest_mav.types import Quat

SCENARIO = "hover"
SEED = 1

SETTLED_S = 5.0
"""Seconds of the vehicle's clock: from here on the attitude is compared. By then the position is known to the daemon,
and with it the declination."""
FAULT_S = 18.0
"""Here the gyro fails."""
SHOW_S = 26.0
"""Here the show ends."""
FAULT = f"gyro1-bias-x=5@{FAULT_S:g}"
NAMED = "RAW_IMU: gyro x +5"
"""The daemon's words for that fault begin so, apart from the last digit."""
RATE_HZ = 20.0
PATIENCE_S = 30.0
COMPONENT = 193
GROUND_STATION = (255, 190)
"""System and component of the one who watches."""
COLUMNS = 80

MAX_TILT_DEG = 0.8
MAX_HEADING_DEG = 2.0
"""Limits of the root mean square errors."""
CAUGHT_S = 4.0
"""The verdict must come within this time after the fault."""

CONFIG = f"""
[[link]]
url = "udpin:127.0.0.1:0"
[[link]]
url = "udpin:127.0.0.1:0"
publish = ["attitude_quaternion", "named_values", "statustext"]
[output]
rate_hz = {RATE_HZ}
[log]
status_s = 3600
"""

ATTEST_MAV = [sys.executable, "-m", "attest_mav"]
SEVERITIES = ("EMERGENCY", "ALERT", "CRITICAL", "ERROR", "WARNING", "NOTICE", "INFO", "DEBUG")
"""By MAV_SEVERITY."""
VERDICTS = {1.0: "AGREE", 0.0: "DISAGREE", -1.0: "UNDECIDED"}
"""By the value of ATT_OK."""


def show(who: str, text: str) -> None:
    """Print a line that somebody said, wrapped."""
    print(textwrap.fill(f"{who} {text}", COLUMNS, initial_indent="  ", subsequent_indent=" " * 12), flush=True)


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
        show("daemon:", line)
        if found := re.search(r"listening on udpin:127\.0\.0\.1:(\d+)", line):
            ports.append(int(found[1]))
    return daemon, log, ports


def show_log(log: IO[str]) -> None:
    """Print what the daemon says while it runs."""
    for line in log:
        show("daemon:", line)


Heard = AttitudeSample | dict[str, object]
"""A published attitude, or the fields of another message with its name under "message"."""


def heard(port: int) -> Iterator[Heard]:
    """What the daemon sends on its second link, as it comes."""
    dialect = load_dialect()
    decoder = Decoder(dialect)
    wanted = [dialect.id_of(name) for name in ("ATTITUDE_QUATERNION", "NAMED_VALUE_FLOAT", "STATUSTEXT")]
    framer = Framer(dialect, frozenset(wanted))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.connect(("127.0.0.1", port))
        listener.settimeout(PATIENCE_S)
        station, next_s = Encoder(dialect, *GROUND_STATION), 0.0
        while True:
            if time.monotonic() >= next_s:  # a listening link answers whoever speaks MAVLink
                next_s = time.monotonic() + 1.0
                listener.send(station.heartbeat(MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID, 0, MAV_STATE_ACTIVE))
            for frame in framer.feed(listener.recv(65536), time.monotonic_ns()):
                if frame.component != COMPONENT:
                    continue
                if frame.message_id == wanted[0]:
                    yield from (one for one in decoder.decode(frame) if isinstance(one, AttitudeSample))
                else:
                    layout = dialect.by_id[frame.message_id]
                    yield {"message": layout.name, **layout.as_dict(frame.payload)}


class Watch:
    """A ground station that knows the truth: it shows what it hears, and remembers what the end depends on."""

    def __init__(self) -> None:
        self.errors: list[tuple[float, float]] = []
        """Tilt and heading errors (deg) of all attitudes after ``SETTLED_S``."""
        self.texts: list[tuple[float, str, str]] = []
        """Time (s), severity and text of each whole STATUSTEXT."""
        self._truth = FakeAutopilot(SimSettings(scenario=SCENARIO), SEED)
        self._t_s = 0.0
        self._ahead_s = -time.monotonic()
        self._is_broken = False
        self._next_line_s = 0.0
        self._newest = (nan, nan)
        self._named: dict[str, float] = {}
        self._chunks = ""

    def run(self, port: int) -> None:
        """Watch until the show ends."""
        for one in heard(port):
            if isinstance(one, AttitudeSample):
                self._attitude(one)
                continue
            self._t_s = time.monotonic() + self._ahead_s  # no attitude tells the time while it is withheld
            if one["message"] == "STATUSTEXT":
                self._text(int(str(one["severity"])), one["text"], int(str(one["id"])))
            else:
                self._value(one["name"], float(str(one["value"])))
            if self._t_s >= SHOW_S:
                return  # the heartbeat's values come once a second, whatever happens

    def _attitude(self, sample: AttitudeSample) -> None:
        """Compare an attitude; until the fault show it beside the truth, one a second."""
        self._t_s = sample.t_ns * 1e-9
        self._ahead_s = self._t_s - time.monotonic()
        true_q = self._truth.truth(sample.t_ns).q_nb
        self._newest = (degrees(tilt_between(true_q, sample.q_nb)), degrees(heading_between(true_q, sample.q_nb)))
        if self._t_s >= SETTLED_S:
            self.errors.append(self._newest)
        if self._next_line_s == 0.0:
            print(f"\n{'':>7}  {'published by the daemon':^23}  {'simulator truth':^23}  difference")
            print(f"{'time s':>7}" + 2 * f"  {'roll':>7} {'pitch':>7} {'yaw':>7}" + "  tilt  heading")
        if self._t_s >= FAULT_S and not self._is_broken:
            self._is_broken = True
            print(f"\nThe autopilot's first gyro now reads 5 deg/s too much ({FAULT}):\n")
            print(f"{'time s':>7}  {'our error':^15}  {'autopilot against ours':^23}  verdict")
            print(f"{'':>7}" + f"  {'tilt':>6} {'heading':>8}" + f"  {'tilt':>11} {'heading':>11}")
        elif self._next_line_s <= self._t_s < FAULT_S:
            self._next_line_s = max(self._next_line_s, self._t_s // 1.0) + 1.0
            tilt, heading = self._newest
            text = f"{self._t_s:7.2f}  {euler_text(sample.q_nb)}  {euler_text(true_q)}  {tilt:4.2f}  {heading:+6.2f}"
            print(text + (" magnetic" if self._t_s < SETTLED_S and abs(heading) > 5.0 else ""), flush=True)

    def _value(self, name: object, value: float) -> None:
        """Show the verdict, once a second after the fault. ATT_YAW is the last of the three."""
        self._named[name.decode() if isinstance(name, bytes) else str(name)] = value
        if name != b"ATT_YAW" or not self._is_broken:
            return
        tilt, heading = self._newest
        named = self._named
        text = f"{self._t_s:7.2f}  {tilt:6.2f} {heading:+8.2f}  {named.get('ATT_TILT', nan):11.2f} {value:+11.2f}"
        print(f"{text}  {VERDICTS.get(named.get('ATT_OK', nan), '?')}", flush=True)

    def _text(self, severity: int, text: object, text_id: int) -> None:
        """Show a text as a ground station does; the chunks of one text are put together."""
        raw = text if isinstance(text, bytes) else b""
        self._chunks += raw.decode("ascii", "replace")
        if text_id and len(raw) == 50:
            return
        self.texts.append((self._t_s, SEVERITIES[severity], self._chunks))
        show("ground station:", f"{SEVERITIES[severity]}: {self._chunks}")
        self._chunks = ""


def euler_text(q_nb: Quat) -> str:
    """Roll, pitch and yaw in degrees, in columns."""
    roll, pitch, yaw = (round(degrees(angle), 2) or 0.0 for angle in q_to_euler(q_nb))  # no "-0.00"
    return f"{roll:7.2f} {pitch:7.2f} {yaw % 360.0:7.2f}"


def is_near_truth(errors: list[tuple[float, float]]) -> bool:
    """Print the errors of our own attitude; True when they are within the limits."""
    print(f"\n{len(errors)} of our attitudes compared with the truth, the fault included:")
    print(f"  {'error, degrees':<16} {'rms':>6} {'worst':>6} {'limit of rms':>13}")
    good = len(errors) > 0.8 * (SHOW_S - SETTLED_S) * RATE_HZ
    for number, (name, limit) in enumerate((("tilt", MAX_TILT_DEG), ("heading", MAX_HEADING_DEG))):
        values = [abs(row[number]) for row in errors]
        rms = sqrt(sum(value * value for value in values) / max(len(values), 1))
        good = good and rms <= limit
        print(f"  {name:<16} {rms:6.2f} {max(values, default=0.0):6.2f} {limit:13.2f}")
    return good


def is_caught(texts: list[tuple[float, str, str]]) -> bool:
    """Print when the autopilot was accused and the sensor named; True when both were, in time and not before."""
    accused = [t_s for t_s, severity, text in texts if severity == "CRITICAL" and "DISAGREES" in text]
    named = [t_s for t_s, _, text in texts if NAMED in text]
    for what, times in (("the sensor was named", named), ("the wrong attitude was told", accused)):
        print(f"  {what:<28}" + (f"{times[0] - FAULT_S:5.1f} s after the fault" if times else "  never"))
    return all(times and FAULT_S <= times[0] <= FAULT_S + CAUGHT_S for times in (named, accused))


def main() -> int:
    """The exit code of the demo."""
    print(f"A fake ArduPilot copter ({SCENARIO}) and the daemon, over UDP on this computer:\n")
    watch, clean = Watch(), False
    with tempfile.TemporaryDirectory() as folder:
        daemon, log, ports = start_daemon(folder)
        logger = threading.Thread(target=show_log, args=(log,), daemon=True)
        logger.start()
        link = ["--link", f"udpout:127.0.0.1:{ports[0]}"]
        flight = ["--scenario", SCENARIO, "--seed", str(SEED), "--fault", FAULT]
        vehicle = subprocess.Popen([*ATTEST_MAV, "sim", *link, *flight], stderr=subprocess.DEVNULL)
        try:
            watch.run(ports[1])
            daemon.send_signal(signal.SIGINT)
            clean = daemon.wait(PATIENCE_S) == 0
            logger.join(PATIENCE_S)
        except TimeoutError:
            print(f"demo: nothing came for {PATIENCE_S:g} s")
        finally:
            daemon.kill()
            vehicle.kill()
            vehicle.wait()
    near, caught = is_near_truth(watch.errors), is_caught(watch.texts)
    good = near and caught and clean
    print("\nThe autopilot was caught. The demo succeeded." if good else "\nThe demo FAILED.")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
