"""Damaged archives: all that stands before the damage is read, and the loss is told."""

import gzip
import io
import tracemalloc
import zipfile
import zlib

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.runtime import gzip_archive
from attest_mav.runtime.files import open_log

LOG = b"".join(b"%d," % (number * number) for number in range(30_000))
GZIPPED = gzip.compress(LOG, mtime=0)
ZIP_DATA_AT = 30 + len("a.bin")


def zipped(method=zipfile.ZIP_DEFLATED, **members):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, content in (members or {"a.bin": LOG}).items():
            archive.writestr(zipfile.ZipInfo(name), content, method)
    return file.getvalue()


ZIPPED = zipped(**{"a.bin": LOG})


def rotten(archive, at, byte=0xFF):
    return archive[:at] + bytes([archive[at] ^ byte]) + archive[at + 1 :]


def read(tmp_path, archive):
    """The bytes of the log, and the remarks in one text."""
    path = tmp_path / "archive"
    path.write_bytes(archive)
    with open_log(path) as log:
        return log[:], "; ".join(log.notes)


def before(archive, end):
    """What zlib unpacks of the bytes before the damage."""
    if archive is GZIPPED:
        return zlib.decompressobj(31).decompress(archive[:end])
    return zlib.decompressobj(-15).decompress(archive[ZIP_DATA_AT:end])


def test_an_intact_archive_has_no_remark(tmp_path):
    for archive in (GZIPPED, ZIPPED, zipped(zipfile.ZIP_STORED), GZIPPED + bytes(100)):
        assert read(tmp_path, archive) == (LOG, "")


@pytest.mark.parametrize("share", [0.01, 0.3, 0.9])
def test_a_gzip_archive_that_is_cut_short_is_read_to_the_cut(tmp_path, share):
    end = int(share * len(GZIPPED))
    expected = before(GZIPPED, end)
    assert read(tmp_path, GZIPPED[:end]) == (expected, "the gzip archive is damaged: it is cut short")
    assert 0 < len(expected) < len(LOG)


def test_a_gzip_archive_without_its_trailer_is_read_whole(tmp_path):
    assert read(tmp_path, GZIPPED[:-3]) == (LOG, "the gzip archive is damaged: it is cut short")


@pytest.mark.parametrize("share", [0.01, 0.3, 0.9])
def test_a_zip_archive_that_is_cut_short_is_read_to_the_cut(tmp_path, share):
    end = int(share * len(ZIPPED))
    log, note = read(tmp_path, ZIPPED[:end])
    assert log == before(ZIPPED, end)
    assert "its directory is missing or wrong, so its first file is read" in note
    assert f"{len(log)} of {len(LOG)} bytes of the log can be unpacked" in note


@pytest.mark.parametrize("archive", [GZIPPED, ZIPPED])
def test_all_before_a_rotten_block_is_read(tmp_path, archive):
    at = len(archive) // 2
    log, note = read(tmp_path, archive[:at] + b"\xff" * 300 + archive[at + 300 :])
    assert log.startswith(before(archive, at))
    assert "cannot be unpacked" in note or "can be unpacked" in note
    assert "records without a checksum of their own may be wrong" in note


def test_a_checksum_that_does_not_fit_is_told(tmp_path):
    stored, told_at = zipped(zipfile.ZIP_STORED), ZIPPED.index(b"PK\1\2") + 16
    for archive in (rotten(GZIPPED, len(GZIPPED) - 6), rotten(ZIPPED, told_at), rotten(stored, 5000)):
        log, note = read(tmp_path, archive)
        assert len(log) == len(LOG)
        assert "records without a checksum of their own may be wrong" in note


def test_a_member_of_a_gzip_archive_behind_a_damaged_one_is_found(tmp_path):
    parts = [LOG[begin : begin + 50_000] for begin in range(0, 200_000, 50_000)]
    members = [gzip.compress(part, mtime=0) for part in parts]
    at = len(members[0]) + len(members[1]) // 2
    whole = b"".join(members)
    log, note = read(tmp_path, whole[:at] + b"\xff" * 300 + whole[at + 300 :])
    assert log.startswith(parts[0] + zlib.decompressobj(31).decompress(whole[len(members[0]) : at]))
    assert log.endswith(parts[2] + parts[3])
    assert f"of its {len(whole)} bytes cannot be unpacked" in note


def test_a_zip_archive_without_directory_is_read_by_the_headers_of_its_files(tmp_path):
    archive = zipped(**{"flights/": b"", "__MACOSX/._a": b"x", "flights/a.bin": LOG})
    cut = archive[: archive.index(b"PK\1\2")]
    assert read(tmp_path, cut) == (
        LOG,
        "the zip archive is damaged: its directory is missing or wrong, so its first file is read",
    )
    stored = zipped(zipfile.ZIP_STORED)
    assert read(tmp_path, stored[:70_000])[0] == LOG[: 70_000 - ZIP_DATA_AT]


def test_a_directory_that_points_elsewhere_is_not_believed(tmp_path):
    entry = ZIPPED.index(b"PK\1\2")
    for at, byte in ((entry + 42, 1), (entry + 45, 0x7F), (len(ZIPPED) - 6, 0xFF), (len(ZIPPED) - 3, 0x7F)):
        log, note = read(tmp_path, rotten(ZIPPED, at, byte))
        assert log == LOG
        assert "its directory is missing or wrong" in note


@pytest.mark.parametrize("archive", [GZIPPED[:10], ZIPPED[:20], ZIPPED[:ZIP_DATA_AT], rotten(GZIPPED, 2), b"\x1f\x8b"])
def test_an_archive_of_which_nothing_can_be_unpacked_says_so(tmp_path, archive):
    with pytest.raises(UnreadableDataError, match="archive is damaged or of an unknown kind: nothing of it can be"):
        read(tmp_path, archive + b"\0")


def test_bytes_that_begin_a_member_everywhere_are_given_up(tmp_path, monkeypatch):
    looked = []
    data_at = gzip_archive.GzipArchive._data_at
    monkeypatch.setattr(gzip_archive.GzipArchive, "_data_at", lambda *one: looked.append(1) or data_at(*one))
    log, note = read(tmp_path, GZIPPED + b"\x1f\x8b\x08" * 100_000)
    assert log.startswith(LOG)
    assert f"300000 of its {len(GZIPPED) + 300_000} bytes cannot be unpacked" in note
    assert len(looked) < 100


@pytest.mark.parametrize("archive", [gzip.compress(bytes(30 << 20)), zipped(**{"a.bin": bytes(30 << 20)})])
def test_memory_does_not_grow_with_what_an_archive_unfolds_to(tmp_path, archive):
    path = tmp_path / "archive"
    path.write_bytes(archive[:-40])
    tracemalloc.start()
    try:
        with open_log(path) as log:
            peak = tracemalloc.get_traced_memory()[1]
            assert len(log) > 29 << 20
    finally:
        tracemalloc.stop()
    assert peak < 2 << 20
