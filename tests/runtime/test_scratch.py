"""Scratch files: in memory, on disk, and where the disk has no room."""

import resource
import tempfile
from contextlib import closing

import pytest

from attest_mav.errors import UnwritableError
from attest_mav.runtime.scratch import MEMORY_BYTES, ScratchFile

MANY = bytes(range(256)) * (MEMORY_BYTES // 128)


@pytest.fixture
def file():
    with closing(ScratchFile()) as found:
        yield found


@pytest.mark.parametrize("data", [b"few", MANY])
def test_bytes_come_back(file, data):
    file.write(data)
    file.seek(1)
    assert file.read(len(data)) == data[1:]


@pytest.fixture
def no_room():
    """No file of this process may grow beyond a megabyte."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.usefixtures("no_room")
def test_a_full_disk_is_an_error_that_names_folder_and_remedy(file):
    with pytest.raises(UnwritableError, match=rf"in {tempfile.gettempdir()}: File too large; .*TMPDIR"):
        file.write(MANY)


def test_a_folder_that_is_not_there_is_one_too(file, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(UnwritableError, match="none: no such file"):
        file.write(MANY)
