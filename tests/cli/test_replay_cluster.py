"""``attest-mav replay --dask``: real workers on loopback, one of which is killed, and clusters that are not there."""

import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner
from pyarrow.parquet import read_table

from attest_mav.cli.replay import command
from attest_mav.cli.replay_spread import Task, _given_up, described
from attest_mav.cli.replay_tables import tables
from attest_mav.errors import UnreadableDataError, UnwritableError, UsageError, WorkersError
from attest_mav.runtime import cluster as module
from attest_mav.runtime.cluster import cluster

CUTS = Path(__file__).parent.parent / "data"
START = CUTS / "copter_square_start.tlog"
DEADLINE_S = 30.0


def replay(*arguments):
    return CliRunner().invoke(command, [*map(str, arguments), "--skip", "2", "--filter", "gradient-descent"])


class Cluster:
    """A scheduler and workers as processes of their own; the system chooses all ports."""

    def __init__(self, folder, workers):
        self._folder = folder
        file = folder / "scheduler.json"
        self._all = [self._start("scheduler", "--port", "0", "--scheduler-file", str(file))]
        deadline = time.monotonic() + DEADLINE_S
        while not file.exists() or not file.read_text().endswith("}"):
            assert time.monotonic() < deadline
        self.address = json.loads(file.read_text())["address"]
        self._all += [self._start("worker", self.address, "--nthreads", "1", "--no-nanny") for _ in range(workers)]

    def end(self):
        for one in reversed(self._all):
            one.kill()
            one.wait(DEADLINE_S)

    def _start(self, name, *options):
        line = [sys.executable, "-m", f"distributed.cli.dask_{name}", *options, "--host", "127.0.0.1", "--no-dashboard"]
        return subprocess.Popen(line, cwd=self._folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory):
    running = Cluster(tmp_path_factory.mktemp("cluster"), 2)
    yield running
    running.end()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("flights")
    for name in ("a", "b", "c"):
        shutil.copy(START, path / f"{name}.tlog")
    (path / "bad.bin").write_bytes(b"not a log at all\n" * 50)
    return path


def test_a_cluster_gives_what_this_process_gives(two_workers, folder, tmp_path, monkeypatch):
    kept = tmp_path / "results.jsonl"
    monkeypatch.chdir(folder.parent)  # a relative name begins here, wherever the workers are
    here = replay(folder.name, "--json", "--workers", 1)
    there = replay(folder.name, "--json", "--dask", two_workers.address, "--results", kept)
    assert there.exit_code == here.exit_code == 65
    assert there.stdout == here.stdout
    assert len(there.stdout.splitlines()) == 3
    assert there.stderr == here.stderr
    # All results are kept, so that nobody is asked for another one.
    again = replay(folder.name, "--json", "--dask", "127.0.0.1:1", "--results", kept)
    assert (again.exit_code, again.stdout, again.stderr) == (here.exit_code, here.stdout, here.stderr)


def test_tables_by_a_cluster_are_those_of_this_process(two_workers, folder, tmp_path):
    paths = {one: [tmp_path / f"{one}.csv", tmp_path / f"{one}.parquet"] for one in ("here", "there")}
    for one, options in (("here", ("--workers", 1)), ("there", ("--dask", two_workers.address))):
        files = ("--csv", paths[one][0], "--parquet", paths[one][1])
        done = replay(folder / "a.tlog", folder / "bad.bin", *files, *options)
        assert done.exit_code == 65
    assert paths["there"][0].read_bytes() == paths["here"][0].read_bytes()
    assert read_table(str(paths["there"][1])).equals(read_table(str(paths["here"][1])))
    assert sorted(one.name for one in tmp_path.iterdir()) == ["here.csv", "here.parquet", "there.csv", "there.parquet"]


def test_the_rows_of_a_log_that_is_given_up_are_dropped_and_lost_ones_are_an_error(tmp_path):
    with tables(str(tmp_path / "a.csv"), None) as written:
        part = tmp_path / "1"
        (tmp_path / "1.csv").write_text("half a row,")
        assert _given_up(Task("a.tlog", "", str(part)), "why")[1] is not None
        written.append(str(part), is_whole=False)
        with pytest.raises(UnwritableError, match=r"rows did not come: no .*1\.csv"):
            written.append(str(part), is_whole=True)
    assert "half" not in (tmp_path / "a.csv").read_text()


def test_a_worker_without_the_folder_of_the_tables_says_so(tmp_path):
    with pytest.raises(UnreadableDataError, match="it has no /nonexistent/parts; expected the logs and the folder"):
        described([str(tmp_path), "/nonexistent/parts"])


def counting(of):
    """A task that holds its worker while a file is there, and ends it at a word; sent to workers by value."""

    def task(path):
        if (of / f"hold-{path}").exists():
            (of / f"started-{os.getpid()}").touch()
            while True:
                signal.pause()  # until the process is killed
        if path == "deadly":
            os._exit(1)
        return int(path)

    return task


def given_up(task, reason):
    return f"{task}: {reason}"


def test_a_killed_worker_loses_nothing(two_workers, tmp_path):
    said = []
    with cluster(two_workers.address, sys.getrecursionlimit, given_up, said.append) as task_map:
        (tmp_path / "hold-5").touch()
        results = task_map(counting(tmp_path), [str(k) for k in range(40)])
        assert [next(results) for _ in range(4)] == [0, 1, 2, 3]
        deadline = time.monotonic() + DEADLINE_S
        while not (started := list(tmp_path.glob("started-*"))):
            assert time.monotonic() < deadline
        (tmp_path / "hold-5").unlink()
        os.kill(int(started[0].name.partition("-")[2]), signal.SIGKILL)
        assert list(results) == list(range(4, 40))
    assert said == []
    assert not logging.getLogger("distributed.client").isEnabledFor(logging.WARNING), "no lines beside our own"


def test_a_task_that_ends_its_workers_is_given_up_alone_and_a_lost_scheduler_ends_the_work(tmp_path, monkeypatch):
    # The first worker that ends blames all its tasks, of which some had only waited.
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    running = Cluster(tmp_path, 3)
    try:
        with cluster(running.address, sys.getrecursionlimit, given_up, print) as task_map:
            results = list(task_map(counting(tmp_path), ["1", "deadly", *"23456789"]))
        assert results == [1, "deadly: 2 workers ended while they had it", *range(2, 10)]
        (tmp_path / "hold-9").touch()
        with cluster(running.address, sys.getrecursionlimit, given_up, print) as task_map:
            results = task_map(counting(tmp_path), ["8", "9"])
            assert next(results) == 8
            running.end()
            with pytest.raises(WorkersError, match="is gone; --results keeps what is done"):
                next(results)
    finally:
        running.end()


def test_workers_that_have_another_program_are_named(two_workers):
    said = []
    with cluster(two_workers.address, os.getpid, given_up, said.append):
        pass
    assert said
    assert all("results may differ" in one for one in said)


def test_a_worker_that_cannot_do_the_work_is_named_at_once(two_workers):
    here = os.getpid()

    def impossible():
        if os.getpid() != here:
            raise FileNotFoundError("no logs here")
        return "attest-mav"

    with (
        pytest.raises(WorkersError, match=r"worker tcp://127.0.0.1:\d+ cannot do the work: no logs here"),
        cluster(two_workers.address, impossible, given_up, print),
    ):
        pass


def test_nobody_at_the_address_is_one_line(monkeypatch, folder):
    monkeypatch.setattr(module, "CONNECT_S", 0.5)
    for address, words in (("127.0.0.1:1", "nobody answers"), ("localhost", "missing port"), ("odd://x:1", "scheme")):
        error = replay(folder, "--dask", address).exception
        assert isinstance(error, WorkersError)
        assert error.exit_code == 69
        assert words in str(error)
        assert "expected HOST:PORT" in str(error)


def test_a_scheduler_without_workers_is_left(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "WORKERS_S", 0.5)
    alone = Cluster(tmp_path, 0)
    try:
        with (
            pytest.raises(WorkersError, match=r"has no workers after 0.5 s; start some"),
            cluster(alone.address, os.getpid, given_up, print),
        ):
            pass
    finally:
        alone.end()


def test_without_the_extra_the_command_says_what_to_install(monkeypatch, folder):
    monkeypatch.setattr(module, "find_spec", lambda _: None)
    error = replay(folder, "--dask", "127.0.0.1:1").exception
    assert isinstance(error, UsageError)
    assert "attest-mav[cluster]" in str(error)


@pytest.mark.parametrize("more", [("--workers", 2), ("--report", "a.html"), ("--tlog", "a.tlog")])
def test_what_a_cluster_cannot_do_is_refused(more):
    error = replay(START, "--dask", "127.0.0.1:1", *more).exception
    assert isinstance(error, UsageError)
    assert str(error).startswith("--dask and ")
