"""The walker on damaged logs: every intact record is found, and every byte that belongs to none is counted."""

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.dataflash.reader import RecordReader
from attest_mav.logs.dataflash.routes import Router
from attest_mav.logs.dataflash.source import DataflashSource
from attest_mav.logs.dataflash.units import Column, UnitTable
from attest_mav.logs.dataflash.walker import MARGIN, RecordWalker
from attest_mav.logs.windows import read_windows


class Times(RecordReader):
    """The times of RATE records, us."""

    def __init__(self):
        super().__init__([Column("TimeUS")])
        self.times = []

    def read(self, t_ns, numbers, texts):
        self.times.append(numbers[1])
        return []


def walked(data, window=None):
    reader = Times()
    walker = RecordWalker(Router({"RATE": reader}, UnitTable()))
    if window is None:
        list(read_windows(data, walker))
        return walker, reader.times
    while True:
        start = walker.position
        piece = data[start : start + window]
        walker.walk(piece, start + len(piece) == len(data))
        if start + len(piece) == len(data):
            return walker, reader.times


@pytest.fixture
def log(writer):
    """Two hundred records, one a millisecond; the first is number 3 of the log."""
    writer.begin()
    for k in range(200):
        writer.add("RATE", TimeUS=1000 * k, RDes=float(k))
    return writer


def all_but(*numbers):
    return [1000.0 * k for k in range(200) if k not in numbers]


def place(log, k):
    """Where the record of time k ms begins."""
    return log.starts[k - 200]


def test_an_intact_log(log):
    walker, times = walked(log.data)
    assert times == all_but()
    assert (walker.records, walker.damage.total) == (len(log.starts), 0)


@pytest.mark.parametrize("junk", [b"\0", b"\xff" * 700, b"console: ready\r\n", b"\xa3\x95", b"\xa3\x95\x80" * 40])
def test_bytes_between_records_cost_none(log, junk):
    at = place(log, 50)
    walker, times = walked(log.data[:at] + junk + log.data[at:])
    assert times == all_but()
    assert (walker.damage.total, walker.damage.first) == (len(junk), [(at, len(junk))])


@pytest.mark.parametrize("lost", range(1, 14))
def test_bytes_lost_inside_a_record_cost_that_one(log, lost):
    at = place(log, 50)
    data = log.data[: at + 1] + log.data[at + 1 + lost :]
    walker, times = walked(data)
    assert times == all_but(50)
    assert (walker.damage.total, walker.damage.places) == (15 - lost, 1)


def test_a_header_that_is_overwritten_costs_one_record(log):
    at = place(log, 50)
    walker, times = walked(log.data[:at] + b"\0\0\0" + log.data[at + 3 :])
    assert times == all_but(50)
    assert walker.damage.first == [(at, 15)]


def test_a_record_alone_between_damage_is_found_by_its_time(log):
    at, end = place(log, 50), place(log, 51)
    data = log.data[:at] + b"#" * 40 + log.data[at:end] + b"#" * 40 + log.data[end:]
    walker, times = walked(data)
    assert times == all_but()
    assert (walker.damage.total, walker.damage.places) == (80, 2)


@pytest.mark.parametrize("lost", range(1, 13))
def test_a_record_between_a_cut_one_and_damage_is_found(log, lost):
    at, end = place(log, 50), place(log, 52)
    data = log.data[: at + 3] + log.data[at + 3 + lost : end] + b"##" + log.data[end:]
    walker, times = walked(data)
    assert times == all_but(50)
    assert walker.damage.first == [(at, 15 - lost), (end - lost, 2)]


def test_a_description_between_a_cut_record_and_damage_is_found(log):
    at, end = place(log, 50), place(log, 51)
    other = type(log)()
    other.types = {"PARM": 10}
    other.raw_format(11, "RATE", *other.formats["RATE"])
    moved = bytes(log.data[end:]).replace(log.data[at : at + 3], b"\xa3\x95\x0b")
    walker, times = walked(log.data[: end - 2] + other.data + b"##" + moved)
    assert times == all_but(50)
    assert walker.damage.total == 13 + 2


def test_the_time_of_a_damaged_record_does_not_count_against_the_next(log):
    at, begin, end = place(log, 50), place(log, 51), place(log, 52)
    data = log.data[: at + 7] + b"?!" + log.data[at + 7 : end] + b"##" + log.data[end:]
    walker, times = walked(data)
    assert [one for one in times if one < 1e9] == all_but(50)
    assert begin + 2 not in [place for place, _ in walker.damage.first]


def test_a_record_alone_of_another_time_is_none(log):
    foreign = type(log)()
    foreign.types = dict(log.types)
    foreign.add("RATE", TimeUS=10**12)
    at = place(log, 50)
    walker, times = walked(log.data[:at] + b"#" * 40 + foreign.data + b"#" * 40 + log.data[at:])
    assert times == all_but()
    assert walker.damage.total == 95


@pytest.mark.parametrize("cut", range(1, 15))
def test_a_log_that_is_cut_short_is_read_to_its_last_record(log, cut):
    walker, times = walked(log.data[:-cut])
    assert times == all_but(199)
    assert walker.damage.total == 15 - cut


def test_a_lost_description_costs_the_records_of_its_type(log):
    at = log.starts[3]
    assert log.data[at + 5 : at + 9] == b"RATE"
    walker, times = walked(log.data[:at] + log.data[at + 89 :])
    assert times == []
    assert walker.damage.total == 200 * 15


def test_a_second_log_behind_the_first_may_number_its_records_otherwise(log):
    other = type(log)()
    other.types = {"PARM": 10}
    other.raw_format(10, "PARM", *other.formats["PARM"])
    other.add("RATE", TimeUS=5_000_000)
    other.add("PARM", TimeUS=5_000_001, Name="X", Value=1.0)
    walker, times = walked(log.data + other.data)
    assert times == [*all_but(), 5_000_000.0]
    assert walker.damage.total == 0


def test_a_log_joined_to_itself_makes_nothing_twice(log):
    walker, times = walked(log.data * 3)
    assert times == all_but() * 3
    assert walker.damage.total == 0
    router = Router({}, UnitTable())
    list(read_windows(log.data * 3, RecordWalker(router)))
    assert len(router._routes) == len({"FMT", "MSG", "RATE"})
    assert router.counts()["RATE"] == 600


def test_a_description_that_cannot_be_is_damage(log):
    at = place(log, 50)
    false = b"\xa3\x95\x80" + bytes([10, 2]) + b"RATE" + bytes(80)
    walker, times = walked(log.data[:at] + false + log.data[at:])
    assert times == all_but()
    assert walker.damage.total == len(false)


def test_a_type_whose_letters_do_not_fit_its_length_is_passed_over(log):
    log.raw_format(99, "ODD", "Qf", "TimeUS,X", length=8)
    log.data += b"\xa3\x95\x63" + bytes(5)
    log.add("RATE", TimeUS=200_000)
    walker, times = walked(log.data)
    assert times == [*all_but(), 200_000.0]
    assert walker.damage.total == 0


@pytest.mark.parametrize("window", [MARGIN + 1, MARGIN + 77, 3000])
def test_the_size_of_the_windows_changes_nothing(log, window):
    generator = random.Random(7)
    data = bytearray(log.data)
    for _ in range(12):
        data[generator.randrange(400, len(data))] ^= 0xFF
    damaged = bytes(data)
    one, times = walked(damaged)
    many, same = walked(damaged, window)
    assert (same, many.records, many.damage.total) == (times, one.records, one.damage.total)
    assert len(times) > 180


def test_records_and_damage_are_all_of_the_log(log):
    """Each byte belongs to a record or to damage."""
    generator = random.Random(3)
    data = bytearray(log.data)
    for _ in range(30):
        del data[generator.randrange(400, len(data))]
    walker, times = walked(bytes(data))
    head = place(log, 0)
    assert walker.damage.total + 15 * len(times) + head == len(data)


@settings(deadline=None, max_examples=60)
@given(st.binary(max_size=3000))
def test_no_bytes_raise(data):
    walker, _ = walked(data)
    assert walker.position == len(data)
    assert walker.damage.total <= len(data)


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 3200), st.integers(0, 255)), max_size=20))
def test_no_damage_raises_anything_but_an_error_for_the_user(edits):
    data = bytearray(LOG)
    for at, value in edits:
        data[at % len(data)] = value
    try:
        summary = DataflashSource(bytes(data)).summary()
    except UnreadableDataError:
        return
    assert summary.bad_bytes <= len(data)


LOG = bytes.fromhex("a39580") + bytes([128, 89]) + b"FMT\0BBnNZ".ljust(20, b"\0") + b"Type,Length".ljust(64, b"\0")
LOG += bytes.fromhex("a39580") + bytes([10, 31]) + b"PARMQNf".ljust(20, b"\0") + b"TimeUS,Name,Value".ljust(64, b"\0")
LOG += (bytes.fromhex("a3950a") + bytes(8) + b"AHRS_TRIM_X".ljust(16, b"\0") + bytes(4)) * 100
