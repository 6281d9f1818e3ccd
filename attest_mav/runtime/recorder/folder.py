"""The folder of recordings: numbered files, of which the oldest make room."""

import errno
import os
import re
import time
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple

_NAME: Final = re.compile(r"attest-mav-(\d{5,})-\d{8}T\d{6}Z\.tlog")
MODE: Final = 0o640
"""Permissions of a recording: it tells where the vehicle was."""


class Recording(NamedTuple):
    """One file of the folder."""

    number: int
    path: Path
    size: int


class RecordFolder:
    """Numbered recordings; other files of the folder are left alone. ``make`` comes first."""

    def __init__(self, path: Path, total_bytes: int, reserve_bytes: int) -> None:
        self._path: Final = path
        self._total_bytes: Final = total_bytes
        self._reserve_bytes: Final = reserve_bytes

    def make(self) -> None:
        """Make the folder where there is none; OSError where nothing can be written into it."""
        self._path.mkdir(mode=0o750, parents=True, exist_ok=True)
        if not os.access(self._path, os.W_OK | os.X_OK):
            if os.statvfs(self._path).f_flag & os.ST_RDONLY:
                raise OSError(errno.EROFS, os.strerror(errno.EROFS))
            raise PermissionError

    def recordings(self) -> list[Recording]:
        """The recordings, oldest first: their numbers grow, whatever the time of day was."""
        found = []
        with os.scandir(self._path) as entries:
            for entry in entries:
                match = _NAME.fullmatch(entry.name)
                if match and entry.is_file(follow_symlinks=False):
                    found.append(Recording(int(match[1]), Path(entry.path), entry.stat().st_size))
        return sorted(found)

    def open_next(self) -> tuple[int, Path]:
        """The descriptor and the path of a new file."""
        number = max((one.number for one in self.recordings()), default=0) + 1
        path = self._path / f"attest-mav-{number:05d}-{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}.tlog"
        return _create(path), path

    def write_beside(self, recording: Path, calibration: bytes) -> None:
        """Write the calibration that a recording began with; OSError where the disk does not take all of it."""
        path = beside(recording)
        with open(_create(path), "wb") as file:
            try:
                file.write(calibration)
                file.flush()
            except OSError:
                path.unlink(missing_ok=True)
                raise

    def has_room(self, current: Path | None) -> bool:
        """Delete the oldest files while limits are exceeded, never the current one; whether that was enough."""
        found = self.recordings()
        total = sum(one.size for one in found)
        for one in found:
            if total <= self._total_bytes and self._free_bytes() >= self._reserve_bytes:
                return True
            if one.path != current:
                self._delete(one.path)
                total -= one.size
        return total <= self._total_bytes and self._free_bytes() >= self._reserve_bytes

    def _delete(self, recording: Path) -> None:
        for path in (recording, beside(recording)):
            with suppress(FileNotFoundError):
                path.unlink()

    def _free_bytes(self) -> int:
        state = os.statvfs(self._path)
        return state.f_bavail * state.f_frsize


def beside(path: Path) -> Path:
    """The file with the calibration that a recording began with."""
    return path.with_suffix(".calibration.json")


def _create(path: Path) -> int:
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC, MODE)
