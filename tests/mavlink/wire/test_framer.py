"""The framer against pymavlink, on generated mixtures, cut anywhere."""

import itertools
import random
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.wire.framer import Framer

LONGEST_FRAME = 280


def sizes(frames):
    return [frame.size for frame in frames]


def rebuilt(stream, frames):
    """The frames' bytes, by what the framer says about them."""
    return [stream[frame.offset : frame.offset + frame.size] for frame in frames]


@pytest.mark.parametrize("kind", ["v1", "v2", "signed"])
def test_header_fields_and_payload_are_those_of_pymavlink(dialect, make_sender, messages, kind):
    sender = make_sender(42, 7)
    for message in messages:
        raw = sender.pack(message, kind)
        framer = Framer(dialect, None)
        (frame,) = framer.feed(raw, 5_000)
        parsed = pymav.MAVLink(None).decode(bytearray(raw))
        assert (frame.message_id, frame.system, frame.component) == (parsed.get_msgId(), 42, 7)
        assert frame.sequence == parsed.get_seq()
        assert frame.version == (1 if kind == "v1" else 2)
        assert frame.signed == (kind == "signed")
        assert frame.rx_ns == 5_000
        header = 6 if kind == "v1" else 10
        assert frame.payload == raw[header : header + raw[1]]
        assert (frame.offset, frame.size) == (0, len(raw))
        assert (framer.frames, framer.bad_bytes, framer.bad_crc, framer.unknown) == (1, 0, 0, 0)


def test_only_wanted_ids_come_out_and_all_are_counted(dialect, sender, messages):
    stream = b"".join(sender.pack(message) for message in messages)
    framer = Framer(dialect, frozenset({27, 30}))
    assert [frame.message_id for frame in framer.feed(stream, 0)] == [27, 30]
    assert framer.frames == len(messages)


def test_a_wanted_id_beyond_the_dialect_is_no_error(dialect, sender, messages):
    framer = Framer(dialect, frozenset({27, 1 << 23}))
    assert [frame.message_id for frame in framer.feed(sender.pack(messages[1]), 0)] == [27]


@pytest.mark.parametrize("kind", ["v1", "v2", "signed"])
def test_every_single_damaged_bit_is_noticed(dialect, sender, messages, kind):
    raw = sender.pack(messages[1], kind)
    covered = len(raw) - (13 if kind == "signed" else 0)
    for bit in range(8 * covered):
        damaged = bytearray(raw)
        damaged[bit // 8] ^= 1 << bit % 8
        framer = Framer(dialect, None)
        assert framer.feed(bytes(damaged), 0) + framer.finish(0) == []
        assert (framer.frames, framer.bad_bytes) == (0, len(raw))


@pytest.mark.parametrize("flags", [0x02, 0x03, 0x80])
def test_unknown_incompatibility_flags_make_no_frame(dialect, flags):
    payload = bytes(range(1, 10))
    covered = struct.pack("<BBBBBBHB", len(payload), flags, 0, 0, 1, 1, 0, 0) + payload
    crc = pymav.x25crc(covered + bytes([pymav.mavlink_map[0].crc_extra])).crc
    framer = Framer(dialect, None)
    raw = b"\xfd" + covered + struct.pack("<H", crc)
    assert framer.feed(raw + bytes(13), 0) + framer.finish(0) == []
    assert framer.bad_bytes == len(raw) + 13


def test_a_payload_longer_than_this_dialect_knows_is_taken_whole(dialect):
    payload = bytes(range(1, 60))
    covered = struct.pack("<BBBBBBHB", len(payload), 0, 0, 0, 1, 1, 27, 0) + payload
    crc = pymav.x25crc(covered + bytes([pymav.mavlink_map[27].crc_extra])).crc
    (frame,) = Framer(dialect, None).feed(b"\xfd" + covered + struct.pack("<H", crc), 0)
    assert frame.payload == payload


# --- mixtures ------------------------------------------------------------------------------------------------------


def pieces(sender, messages, foreign_frame, rng):
    """Random parts of a stream, with whether each is an intact frame."""
    parts = []
    for _ in range(rng.randint(1, 12)):
        what = rng.choice(("v1", "v2", "v2", "signed", "garbage", "magics", "truncated", "broken", "unknown"))
        raw = sender.pack(rng.choice(messages), what if what in {"v1", "v2", "signed"} else rng.choice(("v1", "v2")))
        if what == "garbage":
            parts.append((rng.randbytes(rng.randint(1, 300)), False))
        elif what == "magics":
            parts.append((bytes(rng.choice((0xFD, 0xFE, 0, 1, 27)) for _ in range(rng.randint(1, 60))), False))
        elif what == "truncated":
            parts.append((raw[: rng.randint(1, len(raw) - 1)], False))
        elif what == "broken":
            at = rng.randrange(1, len(raw))
            parts.append((raw[:at] + bytes([raw[at] ^ rng.randint(1, 255)]) + raw[at + 1 :], False))
        elif what == "unknown":
            parts.append((foreign_frame(rng.randbytes(rng.randint(1, 255))), False))
        else:
            parts.append((raw, True))
    return parts


@settings(max_examples=150, derandomize=True, deadline=None)
@given(seed=st.integers(0, 2**32), cuts=st.lists(st.integers(0, 4000), max_size=30))
def test_mixtures_give_exactly_their_intact_frames_however_they_are_cut(
    dialect, make_sender, messages, foreign_frame, seed, cuts
):
    parts = pieces(make_sender(1, 1), messages, foreign_frame, random.Random(seed))
    stream = b"".join(raw for raw, _ in parts)
    # A signed frame whose signature alone is broken has an intact checksum: take it for whole.
    intact = [raw for raw, good in parts if good]
    framer = Framer(dialect, None)
    edges = sorted({min(cut, len(stream)) for cut in cuts} | {0, len(stream)})
    frames = [frame for start, stop in itertools.pairwise(edges) for frame in framer.feed(stream[start:stop], 0)]
    frames += framer.finish(0)
    assert rebuilt(stream, frames) == intact
    assert framer.frames == len(intact)
    passed_over = len(stream) - sum(map(len, intact)) - framer.bad_bytes
    assert (passed_over == 0) == (framer.unknown == 0)


@settings(max_examples=30, derandomize=True, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_byte_by_byte_is_the_same_as_at_once(dialect, make_sender, messages, foreign_frame, seed):
    stream = b"".join(raw for raw, _ in pieces(make_sender(1, 1), messages, foreign_frame, random.Random(seed)))
    whole, crumbs = Framer(dialect, None), Framer(dialect, None)
    at_once = whole.feed(stream, 0) + whole.finish(0)
    one_by_one = [frame for byte in stream for frame in crumbs.feed(bytes([byte]), 0)] + crumbs.finish(0)
    assert [(f.offset, f.size, f.payload) for f in at_once] == [(f.offset, f.size, f.payload) for f in one_by_one]
    for counter in ("frames", "bad_bytes", "unknown", "lost"):
        assert getattr(whole, counter) == getattr(crumbs, counter)


@settings(max_examples=200, derandomize=True, deadline=None)
@given(chunks=st.lists(st.binary(max_size=200), max_size=8))
def test_any_bytes_are_either_frames_or_bad(dialect, chunks):
    framer = Framer(dialect, None)
    frames = [frame for chunk in chunks for frame in framer.feed(chunk, 0)] + framer.finish(0)
    if framer.unknown == 0:
        assert sum(sizes(frames)) + framer.bad_bytes == sum(map(len, chunks))


def test_clean_mixtures_agree_with_pymavlinks_parser(dialect, make_sender, messages):
    rng = random.Random(1)
    sender = make_sender(1, 1)
    stream = b"".join(sender.pack(rng.choice(messages), rng.choice(("v1", "v2", "signed"))) for _ in range(400))
    parser = pymav.MAVLink(None)
    parser.robust_parsing = True
    theirs = [bytes(message.get_msgbuf()) for message in parser.parse_buffer(stream)]
    framer = Framer(dialect, None)
    assert rebuilt(stream, framer.feed(stream, 0)) == theirs
    assert (framer.bad_bytes, framer.lost) == (0, 0)


# --- resynchronisation ---------------------------------------------------------------------------------------------


def test_an_unknown_id_in_garbage_does_not_swallow_what_follows(dialect, sender, messages):
    garbage = bytes.fromhex("fd ff 00 00 00 01 01 5f ea 00")  # asks for 267 bytes of a message nobody knows
    good = [sender.pack(message) for message in messages]
    for lead in (b"", b"x", good[0]):
        framer = Framer(dialect, None)
        stream = lead + garbage + b"".join(good)
        frames = framer.feed(stream, 0) + framer.finish(0)
        assert rebuilt(stream, frames)[-len(good) :] == good
        assert framer.unknown == 0


def test_a_frame_in_the_length_of_a_cut_one_is_found(dialect, sender, messages):
    cut = sender.pack(messages[6])[:40]
    good = sender.pack(messages[1])
    framer = Framer(dialect, None)
    assert framer.feed(cut + good, 0) == []
    assert rebuilt(cut + good, framer.finish(0)) == [good]


def test_a_false_magic_holds_frames_back_for_less_than_the_longest_frame(dialect, sender, messages):
    false = bytes.fromhex("fd ff 01 00 00 01 01 1b 00 00")  # a signed RAW_IMU of full length
    framer = Framer(dialect, None)
    fed = framer.feed(false, 0)
    received = len(false)
    sent = 0
    while not fed:
        raw = sender.pack(messages[1])
        sent += 1
        for byte in raw:
            fed = framer.feed(bytes([byte]), 0)
            received += 1
            if fed:
                break
    assert received <= LONGEST_FRAME
    assert len(fed) == sent - 1  # the last one is still on its way


def test_a_coincidence_in_a_search_gives_way_to_the_real_frame(dialect):
    """A false frame with a fitting checksum that ends in the middle of a real one."""
    false_head = bytes.fromhex("00 fd 23 00 00 00 01 01 1b 00 00") + b"filler"  # in a search: something precedes it
    text = b"a real frame of text "
    real_head = struct.pack("<BBBBBBBHB", 0xFD, 50, 0, 0, 9, 1, 1, 253, 0)
    # The false frame is 2 + 9 + 35 bytes from its magic on; its checksum lies in the real frame's payload.
    before = (false_head[1:] + real_head + bytes([6]) + text)[: 10 + 0x23]
    crc = pymav.x25crc(before[1:] + bytes([pymav.mavlink_map[27].crc_extra])).crc
    payload = (before + struct.pack("<H", crc))[len(false_head) - 1 + len(real_head) :]
    payload += b"!" * (50 - len(payload))
    real = real_head + payload
    real += struct.pack("<H", pymav.x25crc(real[1:] + bytes([pymav.mavlink_map[253].crc_extra])).crc)
    stream = false_head + real
    false = Framer(dialect, None).feed(stream[1 : 1 + 10 + 0x23 + 2], 0)
    assert [frame.message_id for frame in false] == [27], "the coincidence must be a frame by itself"
    framer = Framer(dialect, None)
    assert rebuilt(stream, framer.feed(stream, 0)) == [real]


@pytest.mark.parametrize("size", [1, 7, 60])
def test_a_frame_cut_in_its_signature_gives_way_to_the_real_one_however_the_bytes_come(dialect, sender, messages, size):
    """Its checksum fits, and the first bytes of the next frame stand where its signature should."""
    cut = sender.pack(messages[0], "signed")[:-9]
    real = sender.pack(messages[1], "signed")
    stream = b"garbage" + cut + real
    framer = Framer(dialect, None)
    found = [
        one for begin in range(0, len(stream), size) for one in framer.feed(stream[begin : begin + size], 0)
    ] + framer.finish(0)
    assert rebuilt(stream, found) == [real]


# --- unknown ids ---------------------------------------------------------------------------------------------------


def test_unknown_frames_between_good_ones_are_passed_over(dialect, sender, messages, foreign_frame):
    good = [sender.pack(message) for message in messages]
    strange = [foreign_frame(bytes([0xFD] * n)) for n in (1, 20, 255)]
    stream = good[0] + strange[0] + good[1] + strange[1] + strange[2] + good[2] + strange[0]
    framer = Framer(dialect, None)
    frames = framer.feed(stream, 0) + framer.finish(0)
    assert rebuilt(stream, frames) == good[:3]
    assert (framer.frames, framer.unknown, framer.bad_bytes) == (3, 4, 0)


def test_an_unknown_frame_is_not_proven_by_a_neighbour_of_garbage(dialect, sender, messages, foreign_frame):
    inner = sender.pack(messages[1])
    stream = sender.pack(messages[0]) + foreign_frame(b"xx" + inner) + b"garbage" + sender.pack(messages[0])
    framer = Framer(dialect, None)
    frames = framer.feed(stream, 0) + framer.finish(0)
    assert (framer.unknown, len(frames)) == (0, 3)
    assert inner in rebuilt(stream, frames)


def test_a_damaged_frame_whose_id_became_unknown_is_damage(dialect, sender, messages):
    raw = bytearray(sender.pack(messages[1]))
    raw[8] = 0xEA
    stream = sender.pack(messages[0]) + bytes(raw) + sender.pack(messages[0])
    framer = Framer(dialect, None)
    assert len(framer.feed(stream, 0) + framer.finish(0)) == 2
    assert (framer.unknown, framer.bad_bytes) == (0, len(raw))


def test_four_unknown_frames_in_a_row_prove_nothing(dialect, sender, messages, foreign_frame):
    stream = foreign_frame(b"1") * 4 + sender.pack(messages[0])
    framer = Framer(dialect, None)
    assert len(framer.feed(stream, 0)) == 1
    assert (framer.unknown, framer.bad_bytes) == (0, 4 * len(foreign_frame(b"1")))


# --- counters ------------------------------------------------------------------------------------------------------


def test_lost_frames_are_counted_for_each_sender(dialect, make_sender, messages):
    one, other = make_sender(1, 1), make_sender(1, 2)
    framer = Framer(dialect, None)
    ours = [one.pack(messages[0]) for _ in range(300)]
    theirs = [other.pack(messages[0]) for _ in range(10)]
    framer.feed(b"".join(ours[:100] + theirs[:2] + ours[103:] + theirs[7:]), 0)
    assert framer.lost == 3 + 5


def test_late_and_repeated_frames_are_not_lost_ones(dialect, sender, messages):
    a, b, c, d = (sender.pack(messages[0]) for _ in range(4))
    framer = Framer(dialect, None)
    framer.feed(a + c + b + b + d + d, 0)
    assert framer.lost == 1  # b was missing when c came; that it came later does not undo the count


def test_reset_forgets_the_stream_and_keeps_the_counters(dialect, sender, messages):
    raw = [sender.pack(message) for message in messages]
    framer = Framer(dialect, None)
    framer.feed(raw[0] + raw[1][:20], 0)
    framer.reset()
    (frame,) = framer.feed(raw[5], 1)
    assert (framer.frames, framer.lost, framer.bad_bytes) == (2, 0, 20)
    assert frame.offset == len(raw[0]) + 20


def test_finish_leaves_the_framer_ready(dialect, sender, messages):
    raw = [sender.pack(message) for message in messages]
    framer = Framer(dialect, None)
    framer.feed(raw[0] + b"\xfd\x09", 0)
    assert framer.finish(0) == []
    (frame,) = framer.feed(raw[1], 0)
    assert (frame.offset, framer.bad_bytes) == (len(raw[0]) + 2, 2)


def test_garbage_without_end_is_counted_while_it_comes_and_not_kept(dialect):
    framer = Framer(dialect, None)
    for _ in range(50):
        framer.feed(b"no frame in here" * 64, 0)
    assert framer.bad_bytes == 50 * 1024


class Bouncer:
    """An acceptance check that refuses frames with these sequence numbers, and keeps the bytes it was shown."""

    def __init__(self, refused):
        self.refused = refused
        self.shown = []

    def __call__(self, frame):
        self.shown.append(frame)
        return frame[4] not in self.refused


@pytest.mark.parametrize("crumb", [1, 7, 10_000])
def test_a_frame_that_is_not_accepted_is_counted_and_not_returned(dialect, make_sender, messages, crumb):
    sender = make_sender(1, 1)
    raws = [sender.pack(message, "signed") for message in messages]
    stream = b"".join(raws)
    bouncer = Bouncer({1, 4})
    framer = Framer(dialect, None, bouncer)
    frames = [frame for at in range(0, len(stream), crumb) for frame in framer.feed(stream[at : at + crumb], 0)]
    assert bouncer.shown == raws, "the whole frame, from its magic to the end of its signature"
    assert rebuilt(stream, frames) == [raw for number, raw in enumerate(raws) if number not in {1, 4}]
    assert (framer.frames, framer.refused, framer.bad_bytes) == (len(raws), 2, 0)


def test_a_refused_frame_spoils_no_count_of_missing_ones(dialect, make_sender, messages):
    true, forger = make_sender(1, 1), make_sender(1, 1)
    forger.mav.seq = 90
    stream = true.pack(messages[0]) + forger.pack(messages[0]) + true.pack(messages[0])
    assert len(Framer(dialect, None).feed(stream, 0)) == 3
    framer = Framer(dialect, None, Bouncer({90}))
    assert len(framer.feed(stream, 0)) == 2
    assert framer.lost == 0


def test_only_wanted_frames_are_checked_for_acceptance(dialect, sender, messages):
    bouncer = Bouncer(set())
    Framer(dialect, frozenset({27}), bouncer).feed(b"".join(sender.pack(message) for message in messages), 0)
    assert [frame[7] for frame in bouncer.shown] == [27]
