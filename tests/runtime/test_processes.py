"""Processes that the system ends: nothing but the task that ends them is lost."""

import pytest

from attest_mav.errors import WorkersError
from attest_mav.runtime.processes import processes

TASK = """
import os
import signal
from pathlib import Path

def task(name):
    once = Path(name)
    if name == "deadly" or (once.is_absolute() and not once.exists()):
        once.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 0 if once.is_absolute() else int(name)
"""
"""A task ends its process at a word, at a path the first time only; else it gives its number."""


@pytest.fixture
def task(tmp_path, monkeypatch):
    """In a module that helping processes find too."""
    (tmp_path / "deadly_tasks.py").write_text(TASK)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    from deadly_tasks import task  # noqa: PLC0415  # written above

    return task


def given_up(name, reason):
    return f"{name}: {reason}"


def test_only_the_task_that_ends_its_processes_is_given_up(task, tmp_path):
    names = ["1", "2", "deadly", *map(str, range(3, 60)), str(tmp_path / "once"), "60"]
    with processes(2, given_up) as task_map:
        results = list(task_map(task, names))
    assert results[2] == "deadly: the system ended its process twice, as it does when memory runs out"
    assert results[:2] + results[3:] == [1, 2, *range(3, 60), 0, 60]


def test_a_task_without_a_result_is_an_error_where_all_are_needed(task):
    with pytest.raises(WorkersError, match=r"ended its process twice.*--workers"), processes(2) as task_map:
        list(task_map(task, ["1", "deadly", "2"]))


def test_tasks_that_are_given_out_after_the_end_of_a_process_are_done(task):
    def names():
        yield "1"
        yield "deadly"
        yield from ["2"] * 29  # with them all are given out that may be ahead
        yield "3"
        yield from ["4"] * 40

    with processes(2, given_up) as task_map:
        results = list(task_map(task, names()))
    assert results[2:] == [2] * 29 + [3] + [4] * 40
