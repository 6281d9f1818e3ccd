"""Links in one direction, signed vehicles, loops and clashes: each is named for what it is."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.sim.settings import SimSettings

HOVER = SimSettings(scenario="hover", fast_rate_hz=50.0)


class Deaf:
    """A vehicle that takes nothing; ``edit`` changes each of its frames."""

    def __init__(self, vehicle, edit=lambda frame: frame):
        self._vehicle, self._edit = vehicle, edit

    def handle(self, _data, _now_ns):
        """Nothing is heard."""

    def frames_until(self, now_ns):
        return [self._edit(frame) for frame in self._vehicle.frames_until(now_ns)]

    def __getattr__(self, name):
        return getattr(self._vehicle, name)


def signed(frame):
    """The frame with a signature that nobody can check."""
    head = bytearray(frame[:-2])
    head[2] |= 1
    extra = load_dialect().by_id[int.from_bytes(frame[7:10], "little")].crc_extra
    return with_checksum(bytes(head), extra) + bytes(13)


@pytest.mark.parametrize(
    ("edit", "text"),
    [
        (lambda frame: frame, "the autopilot does not hear us: no request was answered; check the line towards it"),
        (signed, "the vehicle signs its messages and answers no unsigned request: let it accept unsigned messages"),
    ],
)
def test_a_vehicle_that_answers_nothing_is_named_once_a_minute_and_used(flight, edit, text):
    f = flight("", HOVER)
    f.vehicle = Deaf(f.vehicle, edit)
    f.run_until(70.0)
    assert text in f.status()
    assert 1 <= sum(text in line for line in f.texts) <= 2
    assert "the autopilot's limit" not in f.status()
    assert not any("is all that the autopilot gives" in line for line in f.texts)
    assert f.of_type("ATTITUDE_QUATERNION", 60.0), "what comes is used"


def test_a_vehicle_that_answers_is_not_said_to_be_deaf(flight):
    f = flight("", HOVER)
    f.run_until(20.0)
    assert f.snapshot().link_remarks == ()


def test_our_own_frames_that_come_back_are_named(flight):
    f = flight("", HOVER)
    f.run_until(10.0)
    seen = len(f.raw)
    while f.now_ns < 15e9:
        f.run_until(f.now_ns * 1e-9 + 0.05)
        for frame in f.raw[seen:]:
            f.service.receive(0, frame, f.now_ns)
        seen = len(f.raw)
    text = "udpin::0 brings our own frames back: a router sends them to where they came from"
    assert text in f.snapshot().link_remarks
    assert f.texts.count(text) == 1
    assert max(f.errors_deg(10.0)) < 3.0


def test_another_component_with_our_ids_stands_in_the_status(flight):
    f = flight("", HOVER)
    f.run_until(10.0)
    other = mavlink.MAVLink(None, srcSystem=1, srcComponent=193)
    other.seq = 150
    f.service.receive(0, mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3).pack(other), f.now_ns)
    f.run_until(11.0)
    assert "another component speaks as 1/193, which is us" in f.status()
    f.run_until(25.0)
    assert "1/193" not in f.status()


def test_damaged_bytes_are_named_and_no_ceiling_is_invented(flight):
    f = flight("", HOVER)
    count = iter(range(10**9))

    def damaged(frame):
        if next(count) % 3:
            return frame
        return frame[:12] + bytes([frame[12] ^ 0x10]) + frame[13:]

    f.vehicle.frames_until, whole = (lambda now_ns: [damaged(one) for one in whole(now_ns)]), f.vehicle.frames_until
    f.run_until(60.0)
    assert "% of the frames are damaged on the link" in f.status()
    assert not any("is all that the autopilot gives" in line for line in f.texts)
    assert sum("asking again" in line for line in f.texts) <= 2
