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
        (b"FMT, 128, 89, FMT, BBnNZ", "written as text"),
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


def test_a_stream_without_time_stamps_is_named(copter_start):
    stream = b""
    start = 0
    for _ in range(5):
        end = start + 20 + copter_start[start + 9]
        stream += copter_start[start + 8 : end]
        start = end
    with pytest.raises(UnreadableDataError, match="without the time stamps"):
        require_format(stream, "link.raw")


def test_magic_bytes_with_unrelated_times_make_no_tlog():
    record = struct.pack(">Q", 5) + b"\xfe\x01" + bytes(7)
    other = struct.pack(">Q", 10**15) + b"\xfe\x01" + bytes(7)
    assert detect_format(b"x" * 50 + record + other + b"x" * 50) is None
    assert detect_format(b"x" * 50 + record + record + b"x" * 50) == "tlog"
