"""Reports on the daemon to systemd and the log: readiness, watchdog and the status line."""

import logging
import re
from collections.abc import Callable
from typing import Final

from attest_mav.runtime.journal import STATUS_LOGGER
from attest_mav.runtime.loop import Handler
from attest_mav.runtime.notify import Notifier
from attest_mav.service.service import Service
from attest_mav.service.snapshot import Snapshot
from attest_mav.service.status import status_line

log = logging.getLogger("attest_mav.daemon")
status_log = logging.getLogger(STATUS_LOGGER)

LOOK_NS: Final = 10_000_000_000
"""Period at which the state is looked at: a change is written after this time at the latest."""
_NUMBER: Final = re.compile(r"[-+]?[0-9][0-9.]*")


class Reporter(Handler):
    """Looks at the service when something is to be reported. ``snapshot``: makes one for an instant, ns."""

    def __init__(
        self, service: Service, notifier: Notifier, snapshot: Callable[[int], Snapshot], status_s: float, now_ns: int
    ) -> None:
        self._service: Final = service
        self._notifier: Final = notifier
        self._snapshot: Final = snapshot
        self._seen = snapshot(now_ns)
        self._status_ns: Final = int(status_s * 1e9)
        self._look_ns: Final = min(LOOK_NS, self._status_ns)
        self._next_look_ns = now_ns
        self._written = ""
        self._next_line_ns = now_ns
        self._next_alive_ns = now_ns
        self._ready = False

    @property
    def next_deadline_ns(self) -> int | None:
        """The next status line, the first estimate, or the watchdog while there are estimates."""
        due_ns = self._next_look_ns
        if self._service.estimate is None or (self._ready and self._notifier.watchdog_ns is None):
            return due_ns
        return min(due_ns, self._next_alive_ns)

    def due(self, now_ns: int) -> None:
        """Report. WATCHDOG=1 comes from here alone, and only while estimates are fresh."""
        fresh = self._service.fresh(now_ns)
        if fresh and not self._ready:
            self._ready = True
            self._next_look_ns = now_ns
            log.info("ready: the first estimate is there")
            self._notifier.ready()
        watchdog_ns = self._notifier.watchdog_ns
        if fresh and watchdog_ns is not None and now_ns >= self._next_alive_ns:
            self._next_alive_ns = now_ns + watchdog_ns
            self._notifier.alive()
        if now_ns >= self._next_look_ns:
            self._next_look_ns = now_ns + self._look_ns
            self._report_status(now_ns)

    def _report_status(self, now_ns: int) -> None:
        """Tell systemd the state, and the log where it differs by more than its numbers or has been silent for long."""
        before, self._seen = self._seen, self._snapshot(now_ns)
        text = status_line(self._seen, before)
        self._notifier.status(text)
        words = _NUMBER.sub("#", text)
        if words != self._written or now_ns >= self._next_line_ns:
            self._written = words
            self._next_line_ns = now_ns + self._status_ns
            status_log.info("%s", text)
