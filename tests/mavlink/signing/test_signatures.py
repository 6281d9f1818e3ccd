"""Signatures against pymavlink's in both directions, and attacks: frames repeated, forged, signed with another key."""

import hashlib
import struct

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.signing.links import LinkSigning
from attest_mav.mavlink.signing.settings import SigningSettings
from attest_mav.mavlink.signing.signature import LATEST, timestamp_of
from attest_mav.mavlink.signing.verifier import Trust
from attest_mav.mavlink.wire.framer import Framer

KEY = hashlib.sha256(b"ours").digest()
OTHER = hashlib.sha256(b"another").digest()
UNIX_NS = 1_790_000_000 * 10**9
TICKS = 100_000
"""Ticks of 10 us in a second."""
NOW = (1_790_000_000 - 1_420_070_400) * TICKS
"""The timestamp of ``UNIX_NS``."""
OURS = 193


def heartbeat():
    return pymav.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3)


class Station:
    """A component that signs as pymavlink does."""

    def __init__(self, key=KEY, timestamp=NOW, system=1, component=1, link_id=0):
        self.mav = pymav.MAVLink(None, system, component)
        self.mav.signing.secret_key = key
        self.mav.signing.sign_outgoing = key is not None
        self.mav.signing.link_id = link_id
        self.mav.signing.timestamp = timestamp

    def pack(self, message=None, timestamp=None, version1=False):
        if timestamp is not None:
            self.mav.signing.timestamp = timestamp
        raw = bytes((message or heartbeat()).pack(self.mav, force_mavlink1=version1))
        self.mav.seq = (self.mav.seq + 1) % 256
        return raw


class Receiver:
    """The receiving side of one or more links with a key."""

    def __init__(self, dialect, *settings):
        self.notebook = Notebook()
        links = [(f"link{number}", one) for number, one in enumerate(settings or [SigningSettings(KEY)])]
        self.signing = LinkSigning(dialect, OURS, links, self.notebook)
        self.signing.clock.begin(0, UNIX_NS, 0)
        self.verifier = self.signing.verifiers[0]
        self._framers = [Framer(dialect, None, one.accepts) for one in self.signing.verifiers]

    def hear(self, raw, link=0):
        return len(self._framers[link].feed(raw, 0)) == 1


@pytest.fixture
def receiver(dialect):
    return Receiver(dialect)


def resigned(raw, timestamp, key):
    """The frame with another timestamp, signed with this key."""
    covered = raw[:-12] + struct.pack("<Q", timestamp)[:6]
    return covered + hashlib.sha256(key + covered).digest()[:6]


def test_pymavlink_believes_our_signatures(dialect, receiver):
    encoder = Encoder(dialect, 1, OURS, receiver.signing.signers[0].sign)
    other = Station(timestamp=NOW).mav
    for number in range(300):
        receiver.signing.clock.advance(number * 1_000_000)
        (message,) = other.parse_buffer(encoder.heartbeat(18, 8, 0, 4))
        assert message.get_type() == "HEARTBEAT"
        assert message.get_signed()
    assert other.signing.timestamp >= NOW + 29_900


def test_pymavlink_refuses_our_signatures_under_another_key(dialect, receiver):
    encoder = Encoder(dialect, 1, OURS, receiver.signing.signers[0].sign)
    with pytest.raises(pymav.MAVError, match="Invalid signature"):
        Station(OTHER).mav.parse_buffer(encoder.heartbeat(18, 8, 0, 4))


def test_signatures_of_pymavlink_are_believed(receiver, messages):
    station = Station()
    assert all(receiver.hear(station.pack(message)) for message in messages)
    assert receiver.verifier.counts[Trust.VERIFIED] == len(messages)


def test_any_damage_behind_the_checksum_is_noticed(receiver):
    raw = Station().pack()
    for place in range(len(raw) - 13, len(raw)):
        assert not receiver.hear(raw[:place] + bytes([raw[place] ^ 1]) + raw[place + 1 :])
    assert receiver.verifier.counts[Trust.UNKNOWN_KEY] == 13
    assert receiver.hear(raw), "nothing was learned of the forgeries"


def test_another_key_is_refused_and_told_once(receiver):
    station = Station(OTHER)
    assert not any(receiver.hear(station.pack()) for _ in range(50))
    assert receiver.verifier.counts[Trust.UNKNOWN_KEY] == 50
    assert [note.text for note in receiver.notebook.take()] == [
        "link0: frames of system 1 are signed, and not with our key: dropped"
    ]
    assert receiver.verifier.systems(0) == [(1, Trust.UNKNOWN_KEY)]


def test_a_repeated_frame_is_refused(receiver):
    station = Station()
    first, second = station.pack(), station.pack()
    assert receiver.hear(first)
    assert receiver.hear(second)
    assert not receiver.hear(first)
    assert not receiver.hear(second)
    assert receiver.verifier.counts[Trust.OLD] == 2


def test_streams_of_one_sender_are_apart(receiver):
    assert receiver.hear(Station(timestamp=NOW + 500, link_id=0).pack())
    assert receiver.hear(Station(timestamp=NOW, link_id=1).pack())
    assert receiver.hear(Station(timestamp=NOW, component=2).pack())
    assert not receiver.hear(Station(timestamp=NOW + 500, link_id=0).pack())


@pytest.mark.parametrize(("age_s", "counts"), [(0, True), (59, True), (61, False), (86400, False)])
@pytest.mark.parametrize("known", [False, True], ids=["new stream", "known stream"])
def test_a_frame_may_be_a_minute_old(receiver, age_s, counts, known):
    station = Station()
    if known:
        assert receiver.hear(station.pack(timestamp=NOW - 55 * TICKS))
    receiver.signing.clock.set_time(UNIX_NS + 30 * 10**9, 0)
    assert receiver.hear(station.pack(timestamp=NOW + (30 - age_s) * TICKS)) == counts


@pytest.mark.parametrize("timestamp", [NOW + 10**9, LATEST, (1 << 48) - 1])
def test_a_forged_timestamp_in_the_future_locks_nobody_out(receiver, timestamp):
    station = Station()
    assert receiver.hear(station.pack())
    forged = resigned(station.pack(), timestamp, OTHER)
    assert not receiver.hear(forged)
    assert receiver.hear(station.pack())
    assert receiver.signing.clock.timestamp <= NOW + 2, "the time of the last true frame"


def test_a_correct_signature_in_the_future_counts_and_our_time_follows(receiver):
    ahead = NOW + 3600 * TICKS
    assert receiver.hear(Station(timestamp=ahead).pack())
    assert receiver.signing.clock.take() >= ahead
    assert [note.text for note in receiver.notebook.take()] == [
        "link0: system 1 signs with a time 3600 s ahead of ours: ours follows it"
    ]


def test_a_correct_signature_at_the_end_of_all_times_counts_nowhere(receiver):
    assert not receiver.hear(resigned(Station().pack(), (1 << 48) - 1, KEY))
    assert receiver.verifier.counts[Trust.FUTURE] == 1
    assert receiver.hear(Station().pack())
    assert receiver.signing.clock.timestamp == NOW


@pytest.mark.parametrize("version1", [False, True])
@pytest.mark.parametrize("requires", [False, True])
def test_unsigned_frames_count_where_signatures_are_not_required(dialect, requires, version1):
    receiver = Receiver(dialect, SigningSettings(KEY, requires))
    raw = Station(key=None).pack(version1=version1)
    assert receiver.hear(raw) != requires
    assert receiver.verifier.counts[Trust.DROPPED if requires else Trust.UNSIGNED] == 1


@pytest.mark.parametrize("version1", [False, True])
def test_unsigned_frames_of_a_system_that_has_signed_are_not_believed(receiver, version1):
    stranger = Station(key=None)
    assert receiver.hear(stranger.pack(version1=version1))
    assert receiver.hear(Station().pack())
    assert not receiver.hear(stranger.pack(version1=version1))
    assert not receiver.hear(Station(key=None, component=154).pack(version1=version1))
    assert receiver.hear(Station(key=None, system=2).pack(version1=version1))
    assert receiver.verifier.systems(0) == [(1, Trust.VERIFIED), (2, Trust.UNSIGNED)]
    assert [note.text for note in receiver.notebook.take()] == [
        "link0: unsigned frames under system 1, which signs with our key: dropped"
    ]


def test_a_named_message_is_taken_unsigned_but_not_of_who_has_signed(dialect):
    receiver = Receiver(dialect, SigningSettings(KEY, True, ("RADIO_STATUS",)))
    status = pymav.MAVLink_radio_status_message(1, 2, 3, 4, 5, 6, 7)
    radio = Station(key=None, system=51, component=68)
    assert receiver.hear(radio.pack(status))
    assert not receiver.hear(radio.pack(heartbeat()))
    assert receiver.hear(Station().pack())
    assert receiver.hear(Station(key=None, component=68).pack(status)), "a radio that borrows the vehicle's system"
    assert not receiver.hear(Station(key=None).pack(status))


def test_a_frame_cannot_be_repeated_on_another_link_with_the_same_key(dialect):
    receiver = Receiver(dialect, SigningSettings(KEY), SigningSettings(KEY), SigningSettings(OTHER))
    raw = Station().pack()
    assert receiver.hear(raw, link=0)
    assert not receiver.hear(raw, link=1)
    assert not receiver.hear(raw, link=2)
    assert receiver.hear(Station(OTHER).pack(), link=2)


def test_our_own_frames_that_come_back_prove_nothing_about_the_vehicle(dialect, receiver):
    encoder = Encoder(dialect, 1, OURS, receiver.signing.signers[0].sign)
    receiver.hear(encoder.heartbeat(18, 8, 0, 4))
    assert receiver.hear(Station(key=None).pack())
    assert receiver.verifier.systems(0) == [(1, Trust.UNSIGNED)]


def test_the_key_is_in_no_text():
    settings = SigningSettings(KEY)
    assert str(KEY) not in f"{settings!r} {settings}"
    assert KEY.hex() not in repr(settings)
    assert "key" not in repr(settings)


def test_the_timestamps_of_the_guide():
    assert timestamp_of(1_420_070_400 * 10**9) == 0
    assert timestamp_of(1_420_070_401 * 10**9 + 19_999) == 100_001
    assert timestamp_of(0) == 0
    assert timestamp_of(10**21) == LATEST
