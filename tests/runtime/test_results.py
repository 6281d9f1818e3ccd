"""Results that are kept in a file of JSON lines."""

import json
import os
from pathlib import Path

import pytest

from attest_mav.errors import UnreadableDataError, UnwritableError
from attest_mav.runtime.results import Results


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "a.tlog"
    path.write_bytes(b"flight")
    return path


def keep(path, log, value, work="work"):
    results = Results(str(path), work)
    with results.open():
        results.add(str(log), {"value": value})


def known(path, log, work="work"):
    results = Results(str(path), work)
    with results.open():
        return results.known(str(log))


def test_a_result_is_known_while_log_and_work_are_the_same(tmp_path, log):
    path = tmp_path / "results.jsonl"
    assert known(path, log) is None
    keep(path, log, 1)
    assert known(path, log) == {"value": 1}
    assert known(path, log, "other work") is None
    log.write_bytes(b"another flight")
    assert known(path, log) is None
    keep(path, log, 2)
    assert known(path, log) == {"value": 2}


def test_a_line_that_was_cut_is_done_again_and_costs_no_other(tmp_path, log):
    path = tmp_path / "results.jsonl"
    other = tmp_path / "b.tlog"
    other.write_bytes(b"2")
    keep(path, log, 1)
    whole = path.read_bytes()
    path.write_bytes(whole + whole[:40])
    keep(path, other, 2)
    assert (known(path, log), known(path, other)) == ({"value": 1}, {"value": 2})
    assert len([json.loads(line) for line in path.read_text().splitlines()]) == 2


def test_a_log_that_is_not_there_is_not_kept(tmp_path):
    keep(tmp_path / "results.jsonl", tmp_path / "missing.tlog", 1)
    assert (tmp_path / "results.jsonl").read_bytes() == b""


@pytest.mark.parametrize("text", ["not json\n", "[1]\n", '{"a": 1}\n', "7\n"])
def test_a_file_of_something_else_is_refused_and_left_alone(tmp_path, log, text):
    path = tmp_path / "other.txt"
    path.write_text(text)
    with pytest.raises(UnreadableDataError, match="line 1: no result of a replay"):
        known(path, log)
    assert path.read_text() == text


def test_a_file_that_cannot_be_written_is_named(tmp_path, log):
    with pytest.raises(UnwritableError, match=str(tmp_path)):
        keep(tmp_path, log, 1)


def test_names_that_are_no_text_are_kept_apart(tmp_path):
    path = tmp_path / "results.jsonl"
    names = [os.fsdecode(bytes(tmp_path) + b"/" + odd) for odd in (b"\xff.tlog", b"\xfe.tlog")]
    for value, name in enumerate(names):
        with Path(name).open("wb") as file:
            file.write(b"1")
        keep(path, name, value)
    assert [known(path, name) for name in names] == [{"value": 0}, {"value": 1}]
