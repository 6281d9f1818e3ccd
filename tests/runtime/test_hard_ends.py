"""The daemon as a process that is killed, on a disk that is full, and with nobody behind its stderr."""

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from random import Random

import pytest

from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.mavlink.dialect import load_dialect

PATIENCE_S = 60.0
DIALECT = load_dialect()


@pytest.fixture
def config(tmp_path):
    """A configuration that signs, keeps its state and records."""
    key = tmp_path / "link.key"
    key.write_bytes(bytes(range(32)))
    key.chmod(0o600)
    path = tmp_path / "a.toml"
    path.write_text(
        f"[[link]]\nurl = 'sim:still'\nsigning = 'sign'\nkey_file = '{key}'\n[state]\nfolder = '{tmp_path}/state'\n"
        f"[record]\nfolder = '{tmp_path}/flights'\nreserve_mb = 1\n[web]\nlisten = '127.0.0.1:0'\n"
    )
    return path


@contextmanager
def running(config, stderr=subprocess.PIPE, **options):
    """A daemon, which is killed in the end."""
    command = [sys.executable, "-P", "-m", "attest_mav", "run", "--config", str(config)]
    with subprocess.Popen(command, stderr=stderr, text=True, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def said(process, pattern):
    """Wait for a line of the log."""
    for line in process.stderr:
        if re.search(pattern, line):
            return line
    raise AssertionError(f"it ended and never said {pattern}")


def until(condition):
    """Wait until something is so."""
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def recorded(tmp_path):
    return sorted((tmp_path / "flights").glob("*.tlog"))


def test_a_killed_daemon_leaves_whole_files_and_the_next_one_goes_on(config, tmp_path):
    rng, times = Random(3), []
    for number in (1, 2, 3):
        with running(config) as daemon:
            said(daemon, "the first estimate is there")
            until(lambda number=number: len(recorded(tmp_path)) >= number)
            size = recorded(tmp_path)[-1].stat().st_size
            until(lambda size=size: recorded(tmp_path)[-1].stat().st_size > size + rng.randrange(1, 6000))
        assert daemon.returncode == -signal.SIGKILL
        times.append(json.loads((tmp_path / "state" / "state.json").read_text())["signing_timestamp"])
        reader = TlogReader(recorded(tmp_path)[-1].read_bytes(), DIALECT)
        assert sum(1 for _ in reader) > 50
        assert reader.bad_bytes == 0, "the last frame is whole too"
    assert times == sorted(set(times)), "no signature is older than one before"
    assert [path.name for path in (tmp_path / "state").iterdir()] == ["state.json"]


def test_on_a_full_disk_it_starts_and_goes_on_and_says_so(config):
    """No file may grow beyond 0 bytes, as on a full disk."""
    limit = (0, resource.RLIM_INFINITY)
    with running(config, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit)) as daemon:
        assert "state.json: File too large; a restart would lose parameters" in said(daemon, "state.json")
        said(daemon, "nothing is recorded: cannot write .*File too large")
        said(daemon, "the first estimate is there")
        daemon.terminate()
        said(daemon, "stopping")
        assert daemon.wait(PATIENCE_S) == 0


def test_with_a_stderr_that_nobody_reads_or_none_at_all_it_records_on(config, tmp_path):
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    while True:
        try:
            os.write(writer, bytes(1 << 12))
        except BlockingIOError:
            break
    os.set_blocking(writer, True)
    for number, stderr in enumerate((writer, None), start=1):
        closed = {} if stderr is not None else {"preexec_fn": lambda: os.close(2)}
        with running(config, stderr, **closed) as daemon:
            until(lambda number=number: len(recorded(tmp_path)) >= number)
            until(lambda: recorded(tmp_path)[-1].stat().st_size > 8000)
            daemon.terminate()
            assert daemon.wait(PATIENCE_S) == 0
    os.close(reader)
    os.close(writer)
