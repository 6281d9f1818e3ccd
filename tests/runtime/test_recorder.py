"""Recordings on disk: files end and make room, a full or broken disk is told once and costs nothing else."""

import logging
import os
import stat
import time
from types import SimpleNamespace

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.errors import ConfigError
from attest_mav.mavlink.component.notes import WARNING, Note
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.runtime.recorder import folder as folder_module
from attest_mav.runtime.recorder import writer as writer_module
from attest_mav.runtime.recorder.folder import RecordFolder
from attest_mav.runtime.recorder.recorder import Recorder
from attest_mav.runtime.recorder.writer import QUEUED_PARTS, Part, Writer
from attest_mav.service.tape import Tape

SECOND = 1_000_000_000
DIALECT = load_dialect()


def recorder_of(folder, text=""):
    tape = Tape(DIALECT, 0, 193)
    return Recorder(parse_config(f"[record]\nfolder = '{folder}'\n{text}", "test").record, tape), tape


def files(folder):
    return sorted(folder.glob("attest-mav-*.tlog"))


def test_every_frame_is_in_a_file_that_the_group_may_read_and_others_may_not(tmp_path):
    recorder, tape = recorder_of(tmp_path / "new" / "folder")
    whole = b""
    for k in range(300):
        tape.note(Note(WARNING, f"line {k}"), k * 1000)
        data, _ = tape.take()
        whole += data
        tape.note(Note(WARNING, f"line {k}"), k * 1000)
        recorder.pass_on(k * 1000, None)
    recorder.finish()
    (path,) = files(tmp_path / "new" / "folder")
    assert len(path.read_bytes()) == len(whole)
    assert stat.S_IMODE(path.stat().st_mode) & 0o137 == 0
    assert recorder.snapshot.lost_frames == 0
    assert recorder.snapshot.written_bytes == len(whole)
    assert recorder.snapshot.file == path.name


def test_files_end_by_size_by_age_and_when_arming_changes(tmp_path):
    recorder, tape = recorder_of(tmp_path, "file_mb = 1\nfile_s = 60\n")
    ends = []

    def record(now_s, is_armed=None, lines=1):
        for _ in range(lines):
            tape.note(Note(WARNING, "x" * 40), now_s * SECOND)
        recorder.pass_on(now_s * SECOND, is_armed)
        ends.append(now_s)

    record(0)
    record(59, False)
    record(61, False)
    record(62, True)
    record(63, None)
    for _ in range(30):
        record(64, True, 1000)
    record(65, False)
    recorder.finish()
    sizes = [path.stat().st_size for path in files(tmp_path)]
    assert len(sizes) == 5, "start, age, armed, size, disarmed"
    assert max(sizes) < 1_100_000
    numbers = [path.name[11:16] for path in files(tmp_path)]
    assert numbers == [f"{k:05d}" for k in range(1, 6)]


def test_the_oldest_files_make_room_and_others_are_left_alone(tmp_path):
    mine = [tmp_path / f"attest-mav-{k:05d}-20260101T000000Z.tlog" for k in (3, 12, 7)]
    others = [tmp_path / "flight.tlog", tmp_path / "attest-mav-00001-20260101T000000Z.tlog.keep"]
    for path in (*mine, *others):
        path.write_bytes(bytes(1000))
    folder = RecordFolder(tmp_path, 2000, 0)
    assert folder.has_room(None)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in (*others, mine[1], mine[2]))
    fd, path = folder.open_next()
    os.close(fd)
    assert path.name.startswith("attest-mav-00013-")
    assert not RecordFolder(tmp_path, 10, 0).has_room(mine[1]), "the present file is not deleted"
    assert mine[1].exists()


def test_the_calibration_of_a_recording_comes_and_goes_with_it(tmp_path):
    text = b'{"calibrations": {}}\n'
    folder = RecordFolder(tmp_path, 10, 0)
    fd, path = folder.open_next()
    os.close(fd)
    folder.write_beside(path, text)
    companion = path.with_suffix(".calibration.json")
    assert companion.read_bytes() == text
    assert companion.stat().st_mode & 0o777 == path.stat().st_mode & 0o777
    path.write_bytes(bytes(1000))
    assert RecordFolder(tmp_path, 10, 0).has_room(None)
    assert files(tmp_path) == []


def test_a_recording_goes_on_where_its_calibration_finds_no_room(tmp_path, monkeypatch, caplog):
    """Two recordings lack it, and one line tells of it."""
    create = folder_module._create
    no_room = os.open("/dev/full", os.O_WRONLY)
    monkeypatch.setattr(
        folder_module, "_create", lambda path: os.dup(no_room) if path.suffix == ".json" else create(path)
    )
    writer = Writer(RecordFolder(tmp_path, 10_000, 0))
    for data in (b"first", b"second"):
        writer.put(Part(data, 1, b"", b"{}"))
        writer.put(Part(b" more", 1, None))
    writer.finish()
    assert [path.read_bytes() for path in files(tmp_path)] == [b"first more", b"second more"]
    os.close(no_room)
    assert writer.lost_frames == 0
    (line,) = caplog.messages
    path = files(tmp_path)[0].with_suffix(".calibration.json")
    assert (
        line
        == f"cannot write {path}: No space left on device; a replay of the recording begins without the calibration"
    )


def test_a_reserve_is_kept_on_the_disk(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "statvfs", lambda _: SimpleNamespace(f_bavail=100, f_frsize=10))
    assert RecordFolder(tmp_path, 10_000, 1000).has_room(None)
    (tmp_path / "attest-mav-00001-20260101T000000Z.tlog").write_bytes(b"x")
    assert not RecordFolder(tmp_path, 10_000, 1001).has_room(None)
    assert files(tmp_path) == [], "the own files go first"


def test_a_full_disk_is_told_once_and_counted_and_recording_goes_on_later(tmp_path, monkeypatch, caplog):
    class Full(RecordFolder):
        """Full until twenty parts are lost."""

        user = None

        def has_room(self, current):
            return self.user is not None and self.user.lost_frames >= 40

    caplog.set_level(logging.INFO, "attest_mav")
    monkeypatch.setattr(writer_module, "SYNC_S", 0.001)
    monkeypatch.setattr(writer_module, "RETRY_S", 0.0)
    folder = Full(tmp_path, 10_000, 1000)
    writer = folder.user = Writer(folder)
    for k in range(20):
        writer.put(Part(b"x", 2, b"" if k == 0 else None))
    writer.put(Part(b"yy", 1, None))
    writer.finish()
    assert b"".join(path.read_bytes() for path in files(tmp_path)).endswith(b"yy")
    assert 40 <= writer.lost_frames <= 41
    told = [one for one in caplog.messages if "record" in one]
    assert len(told) == 2
    assert told[0].startswith("nothing is recorded: the disk is full but for the reserve")
    assert told[1].startswith("recording again, into ")


def test_a_disk_that_hangs_blocks_nobody_and_what_it_misses_is_counted(tmp_path, monkeypatch):
    hangs = writer_module.threading.Event()
    write = os.write

    def slow(fd, data):
        assert hangs.wait(30.0)
        return write(fd, data)

    monkeypatch.setattr(os, "write", slow)
    writer = Writer(RecordFolder(tmp_path, 10**9, 0))
    taken = [writer.put(Part(b"x", 1, None)) for _ in range(QUEUED_PARTS + 500)]
    assert taken.count(False) == writer.lost_frames
    assert 498 <= writer.lost_frames <= 500
    hangs.set()
    writer.finish()
    assert writer.written_bytes == taken.count(True)


def test_a_write_that_fails_begins_a_new_file_later(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(writer_module, "RETRY_S", 0.0)
    write = os.write

    def breaking(fd, data):
        if data == b"bad":
            raise OSError(5, "Input/output error")
        return write(fd, data)

    monkeypatch.setattr(os, "write", breaking)
    writer = Writer(RecordFolder(tmp_path, 10**9, 0))
    for data in (b"one", b"bad", b"two"):
        writer.put(Part(data, 1, b"<" if data == b"one" else None))
    writer.finish()
    assert [path.read_bytes() for path in files(tmp_path)] == [b"<one", b"<two"]
    assert writer.lost_frames == 1
    assert sum("Input/output error" in one for one in caplog.messages) == 1


def test_a_disk_that_is_read_only_at_the_start_costs_nothing_but_frames(tmp_path, monkeypatch, caplog):
    caplog.set_level(logging.INFO, "attest_mav")
    monkeypatch.setattr(writer_module, "RETRY_S", 0.0)
    folder = tmp_path / "flights"
    with monkeypatch.context() as patch:
        patch.setattr(os, "access", lambda *_: False)
        patch.setattr(os, "statvfs", lambda _: SimpleNamespace(f_flag=os.ST_RDONLY))
        recorder, tape = recorder_of(folder, "reserve_mb = 1")
        tape.note(Note(WARNING, "lost"), 0)
        recorder.pass_on(0, None)
        deadline = time.monotonic() + 30.0
        while not recorder.snapshot.lost_frames:
            assert time.monotonic() < deadline
            time.sleep(0.001)
        assert recorder.snapshot.complaint.endswith("Read-only file system")
    tape.note(Note(WARNING, "kept"), SECOND)
    recorder.pass_on(SECOND, None)
    recorder.finish()
    assert b"kept" in files(folder)[0].read_bytes()
    assert recorder.snapshot.lost_frames == 1
    assert next(one.partition(":")[0] for one in caplog.messages if "record" in one) == "nothing is recorded"


def test_a_folder_that_cannot_be_had_is_a_configuration_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match=r"record\.folder: cannot write into .*file"):
        recorder_of(tmp_path / "file")
