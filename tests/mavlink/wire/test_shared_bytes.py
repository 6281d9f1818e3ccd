"""Frames that share bytes: both checksums fit, and both are found."""

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.mavlink.wire.framer import Framer


def frame_ending_in(sender, end: int) -> bytes:
    """A frame whose last byte, of its checksum, is this one."""
    for boot_ms in range(100_000):
        frame = sender.pack(pymav.MAVLink_attitude_message(boot_ms, 0.1, 0.2, 0.3, 0.0, 0.0, 0.5))
        sender.mav.seq = 1
        if frame[-1] == end:
            return frame
    raise AssertionError("no checksum ends so")


@pytest.mark.parametrize(("kind", "magic"), [("v2", 0xFD), ("v1", 0xFE)])
@pytest.mark.parametrize("before", [b"", b"#####"])
def test_two_frames_that_share_a_byte_are_both_found(dialect, sender, messages, kind, magic, before):
    """Either the first one lacks its last byte or the second one its magic; both checksums fit."""
    first = frame_ending_in(sender, magic)
    others = [sender.pack(one, kind) for one in messages[:3]]
    log = sender.pack(messages[0]) + before + first[:-1] + b"".join(others)
    reader = TlogReader(log, dialect, None, bare=True)
    raw = [log[frame.offset : frame.offset + frame.size] for frame in reader]
    assert raw[1:] == [first, *others]
    assert reader.bad_bytes == len(before)
    assert not reader._walker.is_intact  # a second pass has to look at checksums again


def test_a_link_finds_both_behind_damage_however_the_bytes_come(dialect, sender, messages):
    first = frame_ending_in(sender, 0xFD)
    others = [sender.pack(one) for one in messages[:2]]
    stream = b"#####" + first[:-1] + b"".join(others)
    for cut in range(1, len(stream)):
        framer = Framer(dialect, None)
        frames = [*framer.feed(stream[:cut], 0), *framer.feed(stream[cut:], 0), *framer.finish(0)]
        assert [stream[frame.offset : frame.offset + frame.size] for frame in frames] == [first, *others]
        assert framer.bad_bytes == 5


def test_a_cut_frame_whose_checksum_fits_by_chance_costs_no_other(dialect, sender, messages):
    """The cut frame takes its last bytes from the next one, with a checksum that happens to be right."""
    start, cut, *others = [sender.pack(one) for one in (messages[0], messages[2], *messages[1:4])]
    at = 6  # of the payload's bytes that are left, so that its end and checksum stand in the next frame
    head, rest = bytearray(cut[: 10 + at]), others[0][: len(cut) - 10 - at]
    assert len(rest) < len(others[0])
    for number in range(1 << 16):
        head[10:12] = number.to_bytes(2, "little")
        crc = pymav.x25crc(bytes(head[1:]) + rest[:-2] + bytes([pymav.MAVLink_attitude_message.crc_extra])).crc
        if crc == int.from_bytes(rest[-2:], "little"):
            break
    else:
        raise AssertionError("no such frame")
    log = start + bytes(head) + b"".join(others)
    found = [log[frame.offset : frame.offset + frame.size] for frame in TlogReader(log, dialect, None, bare=True)]
    assert [one for one in found if one in {start, *others}] == [start, *others]
