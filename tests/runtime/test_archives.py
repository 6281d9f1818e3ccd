"""Logs in archives."""

import errno
import gzip
import zipfile

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.runtime import unpacking
from attest_mav.runtime.files import open_log

LOG = bytes(range(256)) * 5000


def gzipped(path, content=LOG):
    path.write_bytes(gzip.compress(content))
    return path


def zipped(path, **members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def test_a_log_in_gzip_is_read_through(tmp_path):
    with open_log(gzipped(tmp_path / "a.tlog.gz")) as log:
        assert len(log) == len(LOG)
        assert log[:] == LOG
        assert log[1000:1010] == LOG[1000:1010]


def test_the_only_file_of_a_zip_archive_is_read_through(tmp_path):
    members = {"flights/": b"", "flights/a.bin": LOG, "__MACOSX/._a.bin": b"x"}
    with open_log(zipped(tmp_path / "a.zip", **members)) as log:
        assert log[:] == LOG


def test_several_files_in_a_zip_archive_are_named(tmp_path):
    path = zipped(tmp_path / "a.zip", **{f"{name}.bin": LOG for name in "abcd"})
    with pytest.raises(UnreadableDataError, match=r"holds 4 files \(a.bin, b.bin, c.bin, ...\); expected one log"):
        open_log(path).__enter__()
    with pytest.raises(UnreadableDataError, match="holds no file; expected one log"):
        open_log(zipped(tmp_path / "b.zip", **{"x/": b""})).__enter__()


def test_an_archive_of_an_empty_file_has_no_log(tmp_path):
    with pytest.raises(UnreadableDataError, match="holds an empty file"):
        open_log(gzipped(tmp_path / "a.gz", b"")).__enter__()


def test_an_archive_that_holds_too_much_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(unpacking, "MOST_BYTES", 1 << 20)
    for path in (gzipped(tmp_path / "a.gz"), zipped(tmp_path / "a.zip", a=LOG)):
        with pytest.raises(UnreadableDataError, match="more than 1 MiB"):
            open_log(path).__enter__()


def test_a_disk_without_room_for_the_log_says_so(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(unpacking.Unpacker, "inflate", full)
    with pytest.raises(UnreadableDataError, match="gzip archive cannot be unpacked: No space left on device"):
        open_log(gzipped(tmp_path / "a.gz")).__enter__()


def test_an_encrypted_archive_says_so(tmp_path):
    path = zipped(tmp_path / "a.zip", a=b"log")
    data = bytearray(path.read_bytes())
    for header, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        data[data.index(header) + flags] |= 1
    path.write_bytes(data)
    with pytest.raises(UnreadableDataError, match="encrypted"):
        open_log(path).__enter__()


@pytest.mark.parametrize("pack", [gzipped, lambda path, content: zipped(path, a=content)])
def test_an_archive_that_unfolds_far_beyond_its_size_is_given_up(tmp_path, pack):
    path = pack(tmp_path / "a", bytes(40 << 20))
    assert path.stat().st_size < 100_000
    with pytest.raises(UnreadableDataError, match="over 200 times its own size"):
        open_log(path).__enter__()


def test_a_crowd_of_files_is_refused_before_they_are_listed(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(12_000):
            archive.writestr(zipfile.ZipInfo(f"{number:060d}"), b"")
    with pytest.raises(UnreadableDataError, match="very many or very large files"):
        open_log(path).__enter__()


def test_an_unknown_way_of_packing_says_so(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("a.bin", LOG)
    with pytest.raises(UnreadableDataError, match="packed in a way that is unknown"):
        open_log(path).__enter__()
