import os
import stat

import pytest

from attest_mav.errors import ConfigError, UnreadableDataError, UnwritableError
from attest_mav.runtime.files import atomic_write, open_log, read_config


def test_a_log_is_read_in_pieces(tmp_path):
    path = tmp_path / "a.tlog"
    path.write_bytes(b"hello")
    with open_log(path) as log:
        assert len(log) == 5
        assert (log[:], log[1:3], log[3:99], log[9:12]) == (b"hello", b"el", b"lo", b"")


def test_a_log_that_is_cut_while_it_is_read_is_an_error(tmp_path):
    path = tmp_path / "a.tlog"
    path.write_bytes(bytes(5000))
    with open_log(path) as log:
        assert len(log[:4096]) == 4096
        os.truncate(path, 4100)
        with pytest.raises(UnreadableDataError, match="cut while it was read: it ends at byte 4100 of 5000"):
            log[4096:5000]


def test_an_error_of_the_block_is_not_one_of_the_log(tmp_path):
    path = tmp_path / "a.tlog"
    path.write_bytes(b"hello")
    with pytest.raises(BrokenPipeError), open_log(path):
        raise BrokenPipeError


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda _path: None, "no such file"),
        (lambda path: path.mkdir(), "directory"),
        (lambda path: path.touch(), "empty"),
        (os.mkfifo, "not a regular file"),
    ],
    ids=["missing", "directory", "empty", "pipe"],
)
def test_what_is_no_log_says_why(tmp_path, make, said):
    path = tmp_path / "a.tlog"
    make(path)
    with pytest.raises(UnreadableDataError, match=said) as caught, open_log(path):
        pass
    assert str(path) in str(caught.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may read everything")
def test_permission_denied_says_so(tmp_path):
    path = tmp_path / "a.tlog"
    path.write_bytes(b"x")
    path.chmod(0)
    with pytest.raises(UnreadableDataError, match="permission denied"), open_log(path):
        pass


def test_a_written_file_appears_whole_with_ordinary_permissions(tmp_path):
    path = tmp_path / "out.csv"
    path.write_bytes(b"old")
    with atomic_write(path) as file:
        file.write(b"new")
        file.flush()
        assert path.read_bytes() == b"old", "not before the end"
    assert path.read_bytes() == b"new"
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask
    assert list(tmp_path.iterdir()) == [path]


def test_a_failure_leaves_the_old_file_and_no_other(tmp_path):
    path = tmp_path / "out.csv"
    path.write_bytes(b"old")
    with pytest.raises(TypeError), atomic_write(path) as file:
        file.writelines([b"half", None])
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(("name", "said"), [("missing/out.csv", "no such file"), (".", "directory")])
def test_a_place_that_cannot_be_written_says_why(tmp_path, name, said):
    with pytest.raises(UnwritableError, match=said), atomic_write(tmp_path / name) as file:
        file.write(b"x")


def test_a_full_disk_is_blamed_on_the_file():
    with (
        pytest.raises(UnwritableError, match="cannot write /dev/full: No space left"),
        atomic_write("/dev/full") as file,
    ):
        file.write(b"x" * 100_000)
    with (
        pytest.raises(UnwritableError, match="cannot write /dev/full: No space left"),
        atomic_write("/dev/full") as file,
    ):
        file.write(b"less than the buffer holds")


def test_errors_of_others_are_not_blamed_on_the_file(tmp_path):
    foreign = tmp_path / "is not there"
    with pytest.raises(FileNotFoundError, match="is not there"), atomic_write(tmp_path / "out.csv"):
        foreign.read_bytes()
    assert list(tmp_path.iterdir()) == []


def test_a_reader_that_leaves_is_no_failure_of_the_file(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    with pytest.raises(BrokenPipeError), atomic_write(path) as file:
        file.write(os.close(reader) or b"x" * 100_000)


def test_a_pipe_is_written_directly(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        with atomic_write(path) as file:
            file.write(b"through")
        assert os.read(reader, 100) == b"through"
    finally:
        os.close(reader)
    assert stat.S_ISFIFO(path.stat().st_mode)


@pytest.mark.parametrize(
    ("content", "said"),
    [(None, "no such file"), (b"\xff\xfe", "not UTF-8"), (b"#" * (1 << 21), "larger than")],
)
def test_a_configuration_that_cannot_be_read_is_a_configuration_error(tmp_path, content, said):
    path = tmp_path / "c.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigError, match=said):
        read_config(path)
