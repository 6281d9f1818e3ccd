"""Frames made by pymavlink, so that nothing under test makes its own expectations."""

import hashlib
import struct
from collections.abc import Callable

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.dialect import Dialect, load_dialect


@pytest.fixture(scope="session")
def dialect() -> Dialect:
    return load_dialect()


class PymavlinkSender:
    """Packs pymavlink's message objects as version 1, version 2, or version 2 with a signature."""

    def __init__(self, system: int = 1, component: int = 1) -> None:
        self.mav = pymav.MAVLink(None, system, component)

    def pack(self, message: pymav.MAVLink_message, kind: str = "v2") -> bytes:
        self.mav.signing.sign_outgoing = kind == "signed"
        self.mav.signing.secret_key = hashlib.sha256(b"test").digest()
        raw = bytes(message.pack(self.mav, force_mavlink1=kind == "v1"))
        self.mav.seq = (self.mav.seq + 1) % 256
        return raw


@pytest.fixture
def sender() -> PymavlinkSender:
    return PymavlinkSender()


@pytest.fixture(scope="session")
def make_sender() -> Callable[[int, int], PymavlinkSender]:
    return PymavlinkSender


@pytest.fixture(scope="session")
def messages() -> list[pymav.MAVLink_message]:
    """One of each length class: short, long, ending in zeros, with text, with a magic byte in the payload."""
    return [
        pymav.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3),
        pymav.MAVLink_raw_imu_message(123456789, 10, -20, -1000, 1, 2, 3, 200, -30, 400),
        pymav.MAVLink_attitude_message(1000, 0.1, -0.2, 3.0, 0.0, 0.0, 0.0),
        pymav.MAVLink_statustext_message(6, b"\xfd\xfe hello \xfd"),
        pymav.MAVLink_system_time_message(0, 0),
        pymav.MAVLink_param_value_message(b"ATT_T", 0.5, 9, 1, 0),
        pymav.MAVLink_encapsulated_data_message(7, [0xFD, 0xFE] * 126 + [1]),
    ]


@pytest.fixture(scope="session")
def foreign_frame() -> Callable[..., bytes]:
    """A well-formed version 2 frame with an id that no dialect has, and a CRC extra that only its sender knows."""

    def make(payload: bytes, message_id: int = 59999, crc_extra: int = 77, sequence: int = 0) -> bytes:
        assert message_id not in pymav.mavlink_map
        covered = struct.pack("<BBBBBBHB", len(payload), 0, 0, sequence, 1, 1, message_id & 0xFFFF, message_id >> 16)
        crc = pymav.x25crc(covered + payload + bytes([crc_extra])).crc
        return b"\xfd" + covered + payload + struct.pack("<H", crc)

    return make
