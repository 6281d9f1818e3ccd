"""Log lines on a descriptor that nobody reads, and lines without end."""

import io
import json
import logging
import os
import re
import sys

import pytest

from attest_mav.runtime.journal import LINES_A_MINUTE, QUEUED_LINES, FloodFilter, ThreadedHandler, log_to_stderr


def record(text, created=0.0):
    one = logging.LogRecord("attest_mav.test", logging.INFO, "", 0, "%s", (text,), None)
    one.created = created
    return one


@pytest.fixture
def pipe():
    ends = os.pipe()
    yield ends
    for end in ends:
        os.close(end)


def fill(fd):
    """Fill a pipe; the number of bytes that it took."""
    os.set_blocking(fd, False)
    filled = 0
    try:
        while True:
            filled += os.write(fd, b"-" * 4096)
    except BlockingIOError:
        os.set_blocking(fd, True)
    return filled


def read_all(fd):
    os.set_blocking(fd, False)
    data = b""
    try:
        while chunk := os.read(fd, 65536):
            data += chunk
    except BlockingIOError:
        pass
    return data.decode().splitlines()


def test_a_pipe_that_nobody_reads_blocks_nobody_and_the_dropped_lines_are_counted(pipe):
    reader, writer = pipe
    filled = fill(writer)
    handler = ThreadedHandler(writer)
    for number in range(QUEUED_LINES + 5000):
        handler.emit(record(f"{number} {'x' * 200}"))
    assert os.read(reader, filled) == b"-" * filled
    lines = []
    while len(lines) < QUEUED_LINES:
        lines += read_all(reader)
    os.set_blocking(writer, True)
    handler.emit(record("after"))
    handler.close()
    lines += read_all(reader)
    assert lines[0].startswith("0 x")
    assert lines[-1].startswith("after")
    # The thread may have taken its first line while the others came: the count then stands in two lines.
    told = [re.search(r"\((\d+) lines before this one were dropped: nobody read stderr\)$", one) for one in lines]
    dropped = [int(one[1]) for one in told if one]
    assert len(dropped) in {1, 2}
    assert len(lines) + sum(dropped) == QUEUED_LINES + 5000 + 1


def test_the_end_waits_for_the_last_lines(pipe):
    reader, writer = pipe
    handler = ThreadedHandler(writer)
    for number in range(100):
        handler.emit(record(str(number)))
    handler.close()
    assert read_all(reader) == [str(number) for number in range(100)]


def test_lines_that_differ_in_numbers_are_one_kind():
    flood = FloodFilter()
    texts = [f"udpin:0.0.0.0:14550: hearing 10.0.{number % 256}.7:{number}" for number in range(1000)]
    passed = [flood.filter(record(text, number * 0.01)) for number, text in enumerate(texts)]
    assert sum(passed) == LINES_A_MINUTE
    assert flood.filter(record("vehicle found", 10.0)), "another kind"
    late = record(texts[0], 61.0)
    assert flood.filter(late)
    assert late.getMessage() == f"{texts[0]} (980 more such lines were left out)"


def test_a_closed_stderr_is_no_error_and_nothing_is_written_to_what_took_its_number(monkeypatch, capsys):
    logger = logging.getLogger("attest_mav")
    before = logger.handlers[:], logger.level, logger.propagate
    try:
        monkeypatch.setattr(sys, "stderr", None)
        log_to_stderr("info")
        logger.info("nobody hears this")
        assert [type(handler) for handler in logger.handlers] == [logging.NullHandler]
    finally:
        logger.handlers[:], logger.level, logger.propagate = before
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("in_journal", [False, True])
def test_lines_for_programs_are_one_json_object_each_behind_the_priority_of_a_journal(monkeypatch, in_journal):
    monkeypatch.delenv("JOURNAL_STREAM", raising=False)
    if in_journal:
        monkeypatch.setenv("JOURNAL_STREAM", "9:9")
    written = io.StringIO()
    logger = logging.getLogger("attest_mav")
    before = logger.handlers[:], logger.level, logger.propagate
    try:
        monkeypatch.setattr(sys, "stderr", written)
        log_to_stderr("info", "json")
        logging.getLogger("attest_mav.link").warning("two\nlines %s", '"quoted"')
    finally:
        logger.handlers[:], logger.level, logger.propagate = before
    line = written.getvalue().removesuffix("\n")
    assert "\n" not in line
    if in_journal:
        assert line.startswith("<4>{")
        line = line[3:]
    fields = json.loads(line)
    assert re.fullmatch(r"20\d\d-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", fields.pop("time"))
    assert fields == {"level": "warning", "part": "link", "text": 'two\nlines "quoted"'}
