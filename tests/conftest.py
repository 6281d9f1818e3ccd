"""Fixtures for all tests."""

import math
import os
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.logs.tlog.reader import tlog_record
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.dialect import Dialect, load_dialect

REPOSITORY = Path(__file__).parent.parent
START_NS = 1_780_000_000_000_000_000
"""Arrival of the first message: in 2026."""
PLACE = {"fix_type": 3, "lat": 518_731_000, "lon": 1_710_000, "alt": 50_000, "time_usec": 0}
"""Where the shared simulator flights start; the declination there is 1.3 degrees, in the simulator's world 0.66."""


class LogBuilder:
    """Makes a tlog message by message; time is that of the autopilot's clock."""

    def __init__(self, dialect):
        self.dialect = dialect
        self.data = b""
        self._encoders = {}

    def add(self, name, t_ms, values, sender=(1, 1)):
        encoder = self._encoders.setdefault(sender, Encoder(self.dialect, *sender))
        self.data += tlog_record(START_NS + round(t_ms * 1_000_000), encoder.message(name, values))

    def heartbeat(self, t_ms=0, autopilot=3, sender=(1, 1)):
        self.add("HEARTBEAT", t_ms, {"type": 2, "autopilot": autopilot, "mavlink_version": 3}, sender)

    def place(self, t_ms=0):
        self.add("GPS_RAW_INT", t_ms, PLACE)

    def imu(self, t_ms, name="RAW_IMU", sender=(1, 1)):
        """Level at rest, nose to magnetic north."""
        time = {"time_usec": round(t_ms * 1000)} if name in ("RAW_IMU", "HIGHRES_IMU") else {"time_boot_ms": t_ms}
        values = {"zacc": -1000, "xmag": 200, "zmag": 440}
        if name == "HIGHRES_IMU":
            values = {"zacc": -9.80665, "xmag": 0.2, "zmag": 0.44, "fields_updated": 0x1FF}
        self.add(name, t_ms, {**time, **values}, sender)

    def attitude(self, t_ms, roll_deg=0.0, yaw_deg=0.0, sender=(1, 1)):
        values = {"time_boot_ms": int(t_ms), "roll": math.radians(roll_deg), "yaw": math.radians(yaw_deg)}
        self.add("ATTITUDE", t_ms, values, sender)

    def truth(self, t_ms, roll_deg=0.0, yaw_deg=0.0):
        """SIM_STATE; it carries no time of its own."""
        w, z = math.cos(math.radians(yaw_deg) / 2), math.sin(math.radians(yaw_deg) / 2)
        c, s = math.cos(math.radians(roll_deg) / 2), math.sin(math.radians(roll_deg) / 2)
        # Yaw, then roll about the nose.
        self.add("SIM_STATE", t_ms, {"q1": w * c, "q2": w * s, "q3": z * s, "q4": z * c})

    def still_flight(self, seconds, hz=50, yaw_deg=0.0, start_ms=1000, own_roll_deg=0.0):
        """A level vehicle at rest with truth, and an autopilot that is wrong about the roll."""
        for k in range(int(seconds * hz) + 1):
            t_ms = start_ms + k * 1000 / hz
            self.attitude(t_ms, own_roll_deg, yaw_deg)
            self.imu(t_ms)
            self.truth(t_ms, yaw_deg=yaw_deg)


@pytest.fixture(scope="session")
def command() -> list[str]:
    """How to start the installed attest-mav as a process: -P keeps a checkout from shadowing an installed wheel."""
    return [sys.executable, "-P", "-m", "attest_mav"]


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of full flight logs, beside the checkout or named by ATTEST_MAV_DATA; tests skip without it."""
    folder = Path(os.environ.get("ATTEST_MAV_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"full flight logs not found at {folder}; set ATTEST_MAV_DATA")
    return folder


@pytest.fixture(scope="session")
def without() -> Callable[..., bytes]:
    """without(data, ids): a tlog of MAVLink 2 frames less the messages of those ids."""

    def drop(data: bytes, *message_ids: int) -> bytes:
        kept, offset = b"", 0
        while offset < len(data):
            # 8 bytes of time, 10 of header, payload, 2 of checksum.
            length = 8 + 12 + data[offset + 9]
            if int.from_bytes(data[offset + 15 : offset + 18], "little") not in message_ids:
                kept += data[offset : offset + length]
            offset += length
        return kept

    return drop


@pytest.fixture(scope="session")
def dialect() -> Dialect:
    return load_dialect()


@pytest.fixture
def log(dialect):
    """An empty tlog, to be filled message by message."""
    return LogBuilder(dialect)


@pytest.fixture(scope="session")
def cuts() -> Path:
    """Folder of pieces of the shared simulator flights."""
    return Path(__file__).parent / "data"


@pytest.fixture(scope="session")
def data_cut(cuts) -> bytes:
    """20 s of square laps: RAW_IMU, ATTITUDE and SIM_STATE at 50 Hz."""
    return (cuts / "copter_square_laps.tlog").read_bytes()


@pytest.fixture
def peer():
    """A UDP socket on loopback, for a link to send to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        sock.bind(("127.0.0.1", 0))
        sock.setblocking(False)
        yield sock


@pytest.fixture
def heard():
    """Takes the messages that have come to a peer."""

    def take(peer):
        parser, messages = mavlink.MAVLink(None), []
        while True:
            try:
                messages += parser.parse_buffer(peer.recv(2000)) or []
            except BlockingIOError:
                return messages

    return take
