"""The thread that writes recordings: a memory card may take seconds, and the event loop waits for nothing.

Each record is written as it comes, and reaches the disk a second later: a process that is killed loses none, a power
cut a second. What the disk does not take in time is dropped and counted.
"""

import logging
import os
import queue
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple

from attest_mav.runtime.files import reason_of
from attest_mav.runtime.recorder.folder import RecordFolder, beside

log = logging.getLogger("attest_mav.record")

QUEUED_PARTS: Final = 2000
"""Parts that wait for the disk: ten seconds of two sensors at 50 Hz."""
SYNC_S: Final = 1.0
"""Period at which the disk is made to keep what was written, and the limits are looked at."""
RETRY_S: Final = 5.0
"""A disk that failed or is full is tried again after this time."""
FAREWELL_S: Final = 3.0
"""How long the end of the writing is waited for."""


class Part(NamedTuple):
    """Records on their way to the disk.

    opening: what a new file begins with; None goes on with the present one. calibration: text of the file beside a new
    one, empty for none.
    """

    data: bytes
    frames: int
    opening: bytes | None
    calibration: bytes = b""


class Writer:
    """Takes parts and never waits."""

    def __init__(self, folder: RecordFolder) -> None:
        self.complaint = ""
        """Why nothing is written at present, "" while all is well."""
        self.written_bytes = 0
        """Bytes written so far."""
        self.lost_frames = 0
        """Frames that were not written."""
        self.path: Path | None = None
        """The present file."""
        self._folder: Final = folder
        self._queue: Final[queue.Queue[Part | None]] = queue.Queue(QUEUED_PARTS)
        self._fd: int | None = None
        self._opening = self._calibration = b""
        self._lacks_calibration = False
        self._sync_s = 0.0
        self._retry_s = 0.0
        self._thread: Final = threading.Thread(target=self._work, name="record", daemon=True)
        self._thread.start()

    def put(self, part: Part) -> bool:
        """Take a part; False where the disk is too far behind."""
        try:
            self._queue.put_nowait(part)
        except queue.Full:
            self.lost_frames += part.frames
            return False
        return True

    def finish(self) -> None:
        """Write what waits, and close; not for ever."""
        with suppress(queue.Full):
            self._queue.put(None, timeout=FAREWELL_S)
        self._thread.join(FAREWELL_S)

    def _work(self) -> None:
        while (part := self._next()) is not None:
            try:
                self._take(part)
            except OSError as error:
                self._fail(f"cannot write {self.path or 'a recording'}: {reason_of(error)}", part.frames)
        self._close()

    def _next(self) -> Part | None:
        """The next part, an empty one when it is time to look at the disk; None at the end."""
        try:
            return self._queue.get(timeout=SYNC_S)
        except queue.Empty:
            return Part(b"", 0, None)

    def _take(self, part: Part) -> None:
        now_s = time.monotonic()
        if part.opening is not None:
            self._opening, self._calibration = part.opening, part.calibration
            self._close()
        if now_s < self._retry_s:
            self.lost_frames += part.frames
            return
        if now_s >= self._sync_s:
            self._sync_s = now_s + SYNC_S
            if self._fd is not None:
                os.fdatasync(self._fd)
            self._folder.make()
            if not self._folder.has_room(self.path if self._fd is not None else None):
                self._fail("the disk is full but for the reserve; free some space", part.frames)
                return
        if not part.data:
            return
        is_new = self._fd is None
        if is_new:
            self._fd, self.path = self._folder.open_next()
            self._write(self._opening)
        self._write(part.data)
        if is_new and self.path is not None and self._calibration:
            self._write_beside(self.path)
        if self.complaint:
            log.info("recording again, into %s", self.path)
            self.complaint = ""

    def _write(self, data: bytes) -> None:
        fd = self._fd
        while data and fd is not None:
            count = os.write(fd, data)
            self.written_bytes += count
            data = data[count:]

    def _write_beside(self, path: Path) -> None:
        """Write the calibration beside a new recording, which goes on without one; a failure is told once."""
        try:
            self._folder.write_beside(path, self._calibration)
        except OSError as error:
            if not self._lacks_calibration:
                lost = "a replay of the recording begins without the calibration"
                log.warning("cannot write %s: %s; %s", beside(path), reason_of(error), lost)
            self._lacks_calibration = True
            return
        self._lacks_calibration = False

    def _fail(self, complaint: str, frames: int) -> None:
        """Tell a failure once, and try again later with a new file."""
        self.lost_frames += frames
        self._retry_s = time.monotonic() + RETRY_S
        self._sync_s = 0.0
        self._close()
        if not self.complaint:
            log.warning("nothing is recorded: %s", complaint)
        self.complaint = complaint

    def _close(self) -> None:
        if self._fd is not None:
            with suppress(OSError):
                os.fdatasync(self._fd)
            with suppress(OSError):
                os.close(self._fd)
        self._fd = None
