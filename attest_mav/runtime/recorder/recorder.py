"""Recordings of a service: what it heard and said, in files that end by size, age and arming."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from attest_mav.config.records import RecordConfig
from attest_mav.errors import ConfigError
from attest_mav.runtime.files import DISK_FAULTS, reason_of
from attest_mav.runtime.recorder.folder import RecordFolder
from attest_mav.runtime.recorder.writer import Part, Writer
from attest_mav.service.snapshot import RecordingSnapshot
from attest_mav.service.tape import Tape

MEGABYTE: Final = 1_000_000


class Recorder:
    """Passes a tape on to the disk. ConfigError where the folder cannot be had, unless that is the disk's fault.

    calibration: gives the text of the sensors' errors that the flight began with, which a replay needs too; empty for
    none.
    """

    def __init__(self, config: RecordConfig, tape: Tape, calibration: Callable[[], bytes] = bytes) -> None:
        total, reserve = int(config.total_mb * MEGABYTE), int(config.reserve_mb * MEGABYTE)
        folder = RecordFolder(Path(config.folder), total, reserve)
        try:
            folder.make()
        except OSError as error:
            if error.errno not in DISK_FAULTS:
                raise ConfigError(f"record.folder: cannot write into {config.folder}: {reason_of(error)}") from None
        self._tape: Final = tape
        self._calibration: Final = calibration
        self._writer: Final = Writer(folder)
        self._file_bytes: Final = int(config.file_mb * MEGABYTE)
        self._file_ns: Final = int(config.file_s * 1e9)
        self._is_armed: bool | None = None
        self._ends_ns = -1
        self._in_file = 0

    def pass_on(self, now_ns: int, is_armed: bool | None) -> None:
        """Pass on what is on the tape; a new file begins where the present one is full or old, or arming changed."""
        data, frames = self._tape.take()
        if not data:
            return
        is_changed = is_armed is not None and self._is_armed is not None and is_armed != self._is_armed
        begins = is_changed or self._in_file >= self._file_bytes or now_ns >= self._ends_ns
        part = Part(data, frames, None)
        if begins:
            part = Part(data, frames, self._tape.opening(now_ns), self._calibration())
        if not self._writer.put(part):
            return
        self._is_armed = self._is_armed if is_armed is None else is_armed
        if begins:
            self._ends_ns = now_ns + self._file_ns
            self._in_file = 0
        self._in_file += len(data)

    @property
    def snapshot(self) -> RecordingSnapshot:
        """The state of the recording."""
        writer = self._writer
        name = "" if writer.path is None else writer.path.name
        return RecordingSnapshot(name, writer.written_bytes, writer.lost_frames + self._tape.lost, writer.complaint)

    def finish(self) -> None:
        """Write what waits, and close the file."""
        self._writer.finish()
