"""What every command shares: the end, in a pipe, on a full disk, by Ctrl-C, and outside of an installation."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from attest_mav.cli.main import main

ROOT = Path(__file__).parent.parent.parent
LAPS = ROOT / "tests" / "data" / "copter_square_laps.tlog"

PRINTING = {
    "help": ["--help"],
    "version": ["--version"],
    "config": ["config", "show"],
    "json": ["replay", str(LAPS), "--json"],
    "table": ["replay", str(LAPS)],
    "evaluate": ["evaluate", "P1-f", "--runs", "2", "--workers", "1"],
}


def ended(command, arguments, stdout):
    done = subprocess.run([*command, *arguments], stdout=stdout, stderr=subprocess.PIPE, text=True, check=False)
    return done.returncode, done.stderr


@pytest.mark.parametrize("arguments", PRINTING.values(), ids=PRINTING)
def test_a_reader_that_has_left_ends_it_quietly(command, arguments):
    reader, writer = os.pipe()
    os.close(reader)
    try:
        assert ended(command, arguments, writer) == (141, "")
    finally:
        os.close(writer)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("arguments", PRINTING.values(), ids=PRINTING)
def test_a_full_disk_behind_standard_output_is_one_line(command, arguments, tmp_path):
    csv = ["--csv", str(tmp_path / "rows.csv")] if "replay" in arguments else []
    with Path("/dev/full").open("w") as full:
        code, said = ended(command, [*arguments, *csv], full)
    assert (code, said) == (65, "attest-mav: error: cannot write standard output: No space left on device\n")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_behind_a_result_is_said_once_and_is_not_the_logs_fault(command):
    done = subprocess.run(
        [*command, "replay", str(LAPS), str(LAPS), "--csv", "/dev/full"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 65
    assert done.stderr == "attest-mav: error: cannot write /dev/full: No space left on device\n"


@pytest.mark.parametrize("arguments", PRINTING.values(), ids=PRINTING)
def test_without_a_standard_output_there_is_no_traceback(command, arguments):
    line = " ".join([*command, *arguments]) + " >&-"
    done = subprocess.run(["sh", "-c", line], stderr=subprocess.PIPE, text=True, check=False)  # noqa: S607
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_ends_it_quietly(command, workers):
    process = subprocess.Popen(
        [*command, "evaluate", "P1-a", "--runs", "100000", "--workers", workers],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A shell makes its background jobs ignore Ctrl-C, and so may be running these tests.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509  # one thread here
    )
    with process:
        time.sleep(3.0)
        os.killpg(process.pid, signal.SIGINT)  # the terminal tells the workers too
        try:
            _, said = process.communicate(timeout=30.0)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    assert (process.returncode, said) == (130, "")


def processes_of_group(group):
    """The processes that live in a process group: (fields of /proc/PID/stat behind the name: state, parent, group)."""
    stats = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            stats.append(path.read_text().rpartition(")")[2].split())
    return sum(fields[2] == str(group) and fields[0] != "Z" for fields in stats)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_the_helpers_end_with_a_program_that_is_ended(command, number):
    process = subprocess.Popen(
        [*command, "evaluate", "P1-a", "--runs", "100000", "--workers", "2"], start_new_session=True
    )
    deadline = time.monotonic() + 60.0
    try:
        while processes_of_group(process.pid) < 4:  # two helpers, and one that keeps count of what they share
            assert time.monotonic() < deadline, "the helpers do not start"
            time.sleep(0.05)
        process.send_signal(number)
        assert process.wait() == -number
        while processes_of_group(process.pid):
            assert time.monotonic() < deadline, "a helper is left"
            time.sleep(0.05)
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def test_usage_errors_are_clicks_own(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["attest-mav", "replay"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    assert "Missing argument 'LOG...'" in capsys.readouterr().err


def test_the_version_of_a_source_tree_that_was_never_installed_is_not_known(tmp_path):
    program = (
        f"import sys; sys.path[:] = [p for p in sys.path if 'attest' not in p] + [{str(ROOT)!r}]\n"
        "from importlib import metadata\n"
        "def missing(name): raise metadata.PackageNotFoundError(name)\n"
        "metadata.version = missing\n"
        "from attest_mav.cli.main import version_text; print(version_text())"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout.startswith("attest-mav unknown (")


def test_a_log_whose_name_is_no_text_is_replayed(command, tmp_path):
    log = os.fsencode(tmp_path) + b"/caf\xe9.tlog"
    Path(os.fsdecode(log)).write_bytes(LAPS.read_bytes())
    rows = tmp_path / "rows.csv"
    for arguments in (["--csv", str(rows)], ["--json"]):
        done = subprocess.run([*command, "replay", log, *arguments], capture_output=True, check=False)
        assert (done.returncode, done.stderr) == (0, b"")
    assert rows.read_bytes().splitlines()[1].startswith(log + b",")
