"""What a file is, and what is said about one that is no log."""

import struct

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.detect import HEAD_BYTES, detect_format, require_format

DATAFLASH = bytes.fromhex("a39580 80 59") + b"FMT\0BBnNZ\0"
ULOG = b"ULog\x01\x12\x35\x01" + bytes(8)


def test_the_three_formats(copter_start, plane_turn):
    assert detect_format(copter_start[:HEAD_BYTES]) == "tlog"
    assert detect_format(plane_turn[:200]) == "tlog"
    assert detect_format(DATAFLASH) == "dataflash"
    assert detect_format(ULOG) == "ulog"


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("sitl/copter_square.tlog", "tlog"),
        ("sitl/plane_circles.tlog", "tlog"),
        ("public/vtol_4hz.tlog", "tlog"),
        ("sitl/copter_square.BIN", "dataflash"),
        ("public/px4_small.ulg", "ulog"),
    ],
)
def test_the_flights(data_folder, name, kind):
    with (data_folder / name).open("rb") as file:
        assert require_format(file.read(HEAD_BYTES), name) == kind


def test_a_tlog_with_a_damaged_start_is_one(copter_start):
    assert detect_format(bytes(1000) + copter_start[:2000]) == "tlog"
    assert detect_format(copter_start[13:2000]) == "tlog"


def test_a_tlog_of_one_record_whole_or_cut_is_one(copter_start):
    end = 20 + copter_start[9]
    assert detect_format(copter_start[:end]) == "tlog"
    assert detect_format(copter_start[: end - 5]) == "tlog"


@pytest.mark.parametrize(
    ("head", "words"),
    [
        (b"", "the file is empty"),
        (b"\x89PNG\r\n\x1a\n" + bytes(100), "a PNG picture"),
        (b"\x1f\x8b\x08" + bytes(100), "gzip-compressed: unpack it first"),
        (b"PK\x03\x04" + bytes(100), "a zip archive: unpack it first"),
    ],
)
def test_a_foreign_format_is_named(head, words):
    with pytest.raises(UnreadableDataError) as caught:
        require_format(head, "flight.tlog")
    message = str(caught.value)
    assert message.startswith("flight.tlog: ")
    assert words in message
    assert "\n" not in message
    assert caught.value.exit_code == 65


@pytest.mark.parametrize("head", [b"time,roll,pitch\n0,1,2\n", bytes(5000), b"\xff" * 5000, b"\0"])
def test_what_is_not_known_is_left_to_who_reads_it_all(head):
    assert detect_format(head) is None
    assert require_format(head, "flight.tlog") == "tlog"


def stream_of(tlog, frames):
    """The first frames of a tlog of version 2 without their times."""
    stream = b""
    start = 0
    for _ in range(frames):
        end = start + 20 + tlog[start + 9]
        stream += tlog[start + 8 : end]
        start = end
    return stream


@pytest.mark.parametrize("cut", [0, 5, 17])
@pytest.mark.parametrize("before", [b"", b"boot: 3 sensors\r\n", b"\0" * 100])
def test_a_stream_without_times_is_known_wherever_it_begins(copter_start, cut, before):
    assert detect_format(before + stream_of(copter_start, 9)[cut:]) == "mavlink"


def test_two_frames_that_fill_a_file_are_a_stream(copter_start):
    assert detect_format(stream_of(copter_start, 2)) == "mavlink"
    assert detect_format(stream_of(copter_start, 2)[:-1]) is None


FMT = "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format\nIMU, 95000, 0.001\n"


@pytest.mark.parametrize(
    "head",
    [
        FMT.encode(),
        b"58\n\nArduCopter V3.0.1\nFree RAM: 1273\n" + FMT.encode(),
        FMT.replace("\n", "\r\n").encode(),
        b"\xef\xbb\xbf" + b"58\r\n\r\n" + FMT.replace("\n", "\r\n").encode(),
        b"\xff\xfe" + FMT.encode("utf-16-le"),
        FMT.replace(", ", ",").encode(),
    ],
)
def test_a_dataflash_log_in_text_is_one_whatever_stands_before_it(head):
    assert require_format(head, "flight.log") == "dataflash-text"


def record_format(name, labels):
    """The DataFlash record that describes one kind of record."""
    return b"\xa3\x95\x80" + bytes([1, 20]) + name.ljust(4, b"\0") + b"Q".ljust(16, b"\0") + labels.ljust(64, b"\0")


def test_an_sdlog2_file_is_no_dataflash_log_in_spite_of_its_magic():
    sdlog2 = record_format(b"IMU", b"AccX,AccY,AccZ") + record_format(b"TIME", b"StartTime")
    assert detect_format(sdlog2) is None
    with pytest.raises(UnreadableDataError, match="sdlog2"):
        require_format(sdlog2, "flight.px4log")
    assert detect_format(record_format(b"IMU", b"TimeUS,GyrX") + record_format(b"TIME", b"TimeUS")) == "dataflash"


def test_magic_bytes_with_unrelated_times_make_no_tlog():
    record = struct.pack(">Q", 5) + b"\xfe\x01" + bytes(7)
    other = struct.pack(">Q", 10**15) + b"\xfe\x01" + bytes(7)
    assert detect_format(b"x" * 50 + record + other + b"x" * 50) is None
    assert detect_format(b"x" * 50 + record + record + b"x" * 50) == "tlog"
