"""The whole service on a link that signs, beside vehicles that sign with our key, with another one, or not at all."""

import hashlib
import struct

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.service.kept_state import KeptState, parse_state, state_text
from attest_mav.sim.settings import SimSettings

KEY = hashlib.sha256(b"ours").digest()
OTHER = hashlib.sha256(b"another").digest()
HOVER = SimSettings(scenario="hover", fast_rate_hz=50.0)
UNIX_NS = 1_790_000_000 * 10**9
NOW = (1_790_000_000 - 1_420_070_400) * 100_000
SETUP_SIGNING = 256
DIALECT = load_dialect()


class SigningVehicle:
    """The fake autopilot behind pymavlink's signatures: it hears only frames that are signed with its key."""

    def __init__(self, vehicle, key, behind_s=0):
        self._vehicle, self._key, self._began = vehicle, key, NOW - behind_s * 100_000
        self._timestamp = self._began
        self._ears = mavlink.MAVLink(None)
        self._ears.robust_parsing = True
        self._ears.signing.secret_key = key
        self._ears.signing.timestamp = self._began
        self.heard = []

    def handle(self, data, now_ns):
        for message in self._ears.parse_buffer(data) or []:
            self.heard.append(message.get_type())
            self._timestamp = max(self._timestamp, self._ears.signing.timestamp)
            if message.get_type() != "BAD_DATA":
                self._vehicle.handle(data, now_ns)

    def frames_until(self, now_ns):
        self._timestamp = max(self._timestamp, self._began + now_ns // 10_000)
        return [self.signed(frame) for frame in self._vehicle.frames_until(now_ns)]

    def signed(self, frame):
        self._timestamp += 1
        head = bytearray(frame[:-2])
        head[2] |= 1
        extra = DIALECT.by_id[int.from_bytes(frame[7:10], "little")].crc_extra
        covered = with_checksum(bytes(head), extra) + b"\0" + struct.pack("<Q", self._timestamp)[:6]
        return covered + hashlib.sha256(self._key + covered).digest()[:6]

    def __getattr__(self, name):
        return getattr(self._vehicle, name)


@pytest.fixture
def signing_flight(flight):
    """A flight on a link with our key; vehicle_key: what the vehicle signs with, None for nothing."""

    def make(policy, vehicle_key, behind_s=0):
        f = flight(f'signing = "{policy}"\nkey_file = "k"', HOVER, keys={"k": KEY})
        f.service.persistence.restore(KeptState(), UNIX_NS, 0)
        if vehicle_key is not None:
            f.vehicle = SigningVehicle(f.vehicle, vehicle_key, behind_s)
        return f

    return make


@pytest.mark.parametrize("policy", ["sign", "require"])
def test_a_vehicle_with_our_key_is_served_and_hears_us(signing_flight, policy):
    f = signing_flight(policy, KEY)
    f.run_until(8.0)
    assert f.of_type("ATTITUDE_QUATERNION", 7.0)
    assert "COMMAND_LONG" in f.vehicle.heard
    assert "BAD_DATA" not in f.vehicle.heard
    assert all(frame[2] == 1 for frame in f.raw), "every frame is signed"
    assert "signing on udpin::0: system 1 signed with our key |" in f.status()
    assert f.snapshot().link_remarks == ()


@pytest.mark.parametrize(
    ("policy", "vehicle_key", "words"),
    [
        ("sign", OTHER, "system 1 signed, key not known: put its key into key_file ("),
        ("require", OTHER, "system 1 signed, key not known: put its key into key_file ("),
        ("require", None, "system 1 unsigned and dropped: set our key there ("),
    ],
    ids=["another key", "another key, required", "none, required"],
)
def test_a_vehicle_that_is_not_believed_gives_no_attitude(signing_flight, policy, vehicle_key, words):
    f = signing_flight(policy, vehicle_key)
    f.run_until(5.0)
    assert f.of_type("ATTITUDE_QUATERNION") == []
    assert f.snapshot().vehicle is None
    assert f"signing on udpin::0: {words}" in f.status()


def test_an_unsigned_vehicle_is_served_where_signatures_are_not_required(signing_flight):
    f = signing_flight("sign", None)
    f.run_until(8.0)
    assert f.of_type("ATTITUDE_QUATERNION", 7.0)
    assert "signing on udpin::0: system 1 unsigned |" in f.status()


def test_nobody_can_speak_for_a_vehicle_that_signs(signing_flight):
    """The stranger sends attitudes of its own at ten times the vehicle's rate, unsigned and with a forged signature."""
    f = signing_flight("sign", KEY)
    f.run_until(10.0)
    stranger = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    forger = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    forger.signing.secret_key, forger.signing.sign_outgoing = OTHER, True
    forger.signing.timestamp = NOW + 10**12
    while f.now_ns < 15e9:
        f.run_until(f.now_ns * 1e-9 + 0.01)
        lie = mavlink.MAVLink_attitude_message(f.now_ns // 1_000_000, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0)
        for sender in (stranger, forger):
            f.service.receive(0, lie.pack(sender), f.now_ns)
    assert "agrees" in f.status()
    assert f.of_type("ATTITUDE_QUATERNION", 14.0)
    signing = f.snapshot().links[0].signing
    assert signing.bad_signatures == signing.dropped_unsigned == 500


def test_a_service_that_starts_again_signs_with_later_times_even_when_the_clock_was_set_back(signing_flight):
    f = signing_flight("sign", KEY)
    f.run_until(3.0)
    kept = parse_state(state_text(f.service.persistence.state))
    f.run_until(6.0)
    last = int.from_bytes(f.raw[-1][-12:-6], "little")
    again = signing_flight("sign", KEY)
    again.service.persistence.restore(kept, UNIX_NS - 10**15, 0)
    again.run_until(1.0)
    assert int.from_bytes(again.raw[0][-12:-6], "little") > last


def test_setup_signing_is_neither_read_nor_sent(signing_flight):
    f = signing_flight("sign", None)
    f.run_until(5.0)
    station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    key = list(range(32))
    sent = len(f.raw)
    for target in (0, 193):
        f.service.receive(0, mavlink.MAVLink_setup_signing_message(1, target, key, 5).pack(station), f.now_ns)
    f.run_until(6.0)
    assert SETUP_SIGNING not in f.service._companion.wanted
    assert not any(int.from_bytes(frame[7:10], "little") == SETUP_SIGNING for frame in f.raw)
    assert not any(bytes(key) in frame for frame in f.raw[sent:])


def test_on_a_link_that_requires_signatures_only_they_confirm_a_sender(signing_flight):
    f = signing_flight("require", KEY)
    unsigned = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    beat = mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3).pack(unsigned)
    assert not f.service.receive(0, beat, 0)
    assert f.service.receive(0, f.vehicle.signed(beat), 0)
    assert not f.service.receive(0, SigningVehicle(f.vehicle, OTHER).signed(beat), 0)


def test_a_vehicle_whose_clock_is_behind_is_answered_so_that_it_can_follow_ours(signing_flight):
    f = signing_flight("require", KEY, behind_s=3600)
    unsigned = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    beat = mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3).pack(unsigned)
    assert f.service.receive(0, f.vehicle.signed(beat), 0), "the sender is answered"
    assert f.snapshot().vehicle is None
    assert f.snapshot().links[0].signing.old_timestamps == 1
    f.run_until(8.0)
    assert f.of_type("ATTITUDE_QUATERNION", 7.0)
    assert "system 1 signed with our key" in f.status()
