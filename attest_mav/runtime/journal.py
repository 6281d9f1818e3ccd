"""Log lines on stderr: with the time of day on a terminal, with a priority prefix for systemd's journal.

Whoever reads stderr may stop reading: a stalled collector, a terminal after Ctrl-S. The lines are therefore written by
a thread of their own, from a bounded queue; a line that finds no room is dropped and counted.
"""

import json
import logging
import os
import queue
import re
import sys
import threading
import time
from contextlib import suppress
from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit

_PRIORITIES = {logging.DEBUG: 7, logging.INFO: 6, logging.WARNING: 4, logging.ERROR: 3, logging.CRITICAL: 2}
"""syslog's priorities; systemd reads ``<4>`` at the start of a line (sd-daemon(3))."""

QUEUED_LINES: Final = 1000
"""Lines that wait for a reader."""
FAREWELL_S: Final = 0.5
"""How long the last lines are waited for at the end."""
LINES_A_MINUTE: Final = 20
"""Lines of one kind, alike but for their numbers, that are written in a minute."""
STATUS_LOGGER: Final = "attest_mav.status"
"""The logger of the status line, whose period is configured: it is no flood."""
_NUMBER: Final = re.compile(r"[0-9a-f.:]*[0-9][0-9a-f.:]*")


class _JournalFormatter(logging.Formatter):
    """Puts the priority in front of what another formatter makes; the journal has its own clock."""

    def __init__(self, inner: logging.Formatter) -> None:
        super().__init__()
        self._inner: Final = inner

    def format(self, record: logging.LogRecord) -> str:
        return f"<{_PRIORITIES.get(record.levelno, 6)}>{self._inner.format(record)}"


class _JsonFormatter(logging.Formatter):
    """One JSON object a line: the time of day (UTC), the level, the part of the program and the text."""

    def format(self, record: logging.LogRecord) -> str:
        seconds = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created))
        part = record.name.removeprefix("attest_mav.")
        fields = {"time": f"{seconds}.{int(record.msecs):03d}Z", "level": record.levelname.lower(), "part": part}
        return json.dumps(fields | {"text": record.getMessage()})


class FloodFilter(logging.Filter):
    """Lets few lines of one kind through in a minute, whatever made them; the next one tells how many were left out."""

    def __init__(self) -> None:
        super().__init__()
        self._lines: Final = LineLimit(LINES_A_MINUTE)

    def filter(self, record: logging.LogRecord) -> bool:
        """See ``logging.Filter``."""
        if record.name == STATUS_LOGGER:
            return True
        text = record.getMessage()
        suffix = self._lines.suffix(_NUMBER.sub("#", text), int(record.created * 1e9))
        if suffix is None:
            return False
        record.msg, record.args = text + suffix, ()
        return True


class ThreadedHandler(logging.Handler):
    """Writes lines to a file descriptor from a thread, so that a reader who does not read blocks nobody else."""

    def __init__(self, fd: int) -> None:
        super().__init__()
        self.dropped = 0
        """Lines that found no room since the last one that did."""
        self._fd: Final = fd
        self._queue: Final[queue.Queue[bytes | None]] = queue.Queue(QUEUED_LINES)
        self._thread: Final = threading.Thread(target=self._write_all, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:
        """See ``logging.Handler``."""
        text = self.format(record)
        if self.dropped:
            text = f"{text} ({self.dropped} lines before this one were dropped: nobody read stderr)"
        try:
            self._queue.put_nowait(text.encode(errors="backslashreplace") + b"\n")
            self.dropped = 0
        except queue.Full:
            self.dropped += 1

    def close(self) -> None:
        """See ``logging.Handler``. The last lines are waited for, but not for long."""
        with suppress(queue.Full):
            self._queue.put_nowait(None)
        self._thread.join(FAREWELL_S)
        super().close()

    def _write_all(self) -> None:
        while (line := self._queue.get()) is not None:
            with suppress(OSError):  # nobody can be told
                while line:
                    line = line[os.write(self._fd, line) :]


def log_to_stderr(level: str, form: str = "text") -> None:
    """Send the package's log lines of this level and above to stderr; nowhere where it is closed.

    form: "text" for people, "json" for programs.
    """
    logger = logging.getLogger("attest_mav")
    handler = _handler()
    handler.addFilter(FloodFilter())
    logger.handlers[:] = [handler]
    logger.propagate = False
    log_as(level, form)


def log_as(level: str, form: str) -> None:
    """Write lines of this level and above in this form from now on."""
    logger = logging.getLogger("attest_mav")
    logger.setLevel(level.upper())
    for handler in logger.handlers:
        handler.setFormatter(_formatter(form))


def _handler() -> logging.Handler:
    try:
        fd = sys.stderr.fileno()
    except (AttributeError, OSError, ValueError):  # closed, or replaced by something without a descriptor
        return logging.NullHandler() if sys.stderr is None else logging.StreamHandler(sys.stderr)
    return ThreadedHandler(fd)


def _formatter(form: str) -> logging.Formatter:
    is_journal = "JOURNAL_STREAM" in os.environ  # set by systemd where stderr goes to the journal
    timed = logging.Formatter("%(message)s" if is_journal else "%(asctime)s %(message)s", "%H:%M:%S")
    formatter = _JsonFormatter() if form == "json" else timed
    return _JournalFormatter(formatter) if is_journal else formatter
