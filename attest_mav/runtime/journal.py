"""Log lines on stderr: with the time of day on a terminal, with a priority prefix for systemd's journal."""

import logging
import os
import sys

_PRIORITIES = {logging.DEBUG: 7, logging.INFO: 6, logging.WARNING: 4, logging.ERROR: 3, logging.CRITICAL: 2}
"""syslog's priorities; systemd reads ``<4>`` at the start of a line (sd-daemon(3))."""


class _JournalFormatter(logging.Formatter):
    """Puts the priority in front; the journal has its own clock."""

    def format(self, record: logging.LogRecord) -> str:
        return f"<{_PRIORITIES.get(record.levelno, 6)}>{super().format(record)}"


def log_to_stderr(level: str) -> None:
    """Send the package's log lines of this level and above to stderr."""
    handler = logging.StreamHandler(sys.stderr)
    if "JOURNAL_STREAM" in os.environ:  # set by systemd where stderr goes to the journal
        handler.setFormatter(_JournalFormatter("%(message)s"))
    else:
        handler.setFormatter(logging.Formatter("%(asctime)s %(message)s", "%H:%M:%S"))
    logger = logging.getLogger("attest_mav")
    logger.handlers[:] = [handler]
    logger.setLevel(level.upper())
    logger.propagate = False
