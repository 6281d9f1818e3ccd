"""Reports on the daemon to systemd and the log: readiness, watchdog and the status line."""

import logging
import re
from collections.abc import Callable
from typing import Final

from attest_mav.runtime.journal import STATUS_LOGGER
from attest_mav.runtime.loop import Handler
from attest_mav.runtime.notify import Notifier
from attest_mav.service.filter_watch import FilterWatch
from attest_mav.service.service import Service
from attest_mav.service.snapshot import Snapshot
from attest_mav.service.status import status_line

log = logging.getLogger("attest_mav.daemon")
status_log = logging.getLogger(STATUS_LOGGER)

LOOK_NS: Final = 1_000_000_000
"""The longest time between two looks at the service where there is a watchdog."""
CHANGE_NS: Final = 10_000_000_000
"""Period at which the status is compared: a change is written after this time at the latest."""
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
        self._line_ns = int(status_s * 1e9)
        self._next_line_ns = now_ns
        self._next_status_ns = now_ns
        self._written = ""
        watchdog_ns = notifier.watchdog_ns
        self._look_ns: Final = None if watchdog_ns is None else min(watchdog_ns, LOOK_NS)
        self._next_look_ns = now_ns
        self._watch: Final = FilterWatch()
        self._fails = False
        self._is_ready = False
        self._has_estimated = False

    @property
    def next_deadline_ns(self) -> int | None:
        """The next status line, the first estimate, or the next look for the watchdog."""
        due_ns = self._next_status_ns
        if self._look_ns is not None:
            due_ns = min(due_ns, self._next_look_ns)
        return due_ns if self._has_estimated or self._service.estimate is None else 0

    def report_every(self, status_s: float) -> None:
        """Write a status line with this period at least from now on, s; the next one at once."""
        self._line_ns = int(status_s * 1e9)
        self._next_status_ns = self._next_line_ns = 0

    def due(self, now_ns: int) -> None:
        """Report. READY=1 and WATCHDOG=1 come from here alone, out of the loop that filters."""
        if not self._is_ready:
            self._is_ready = True
            log.info("ready: the links are open")
            self._notifier.ready()
        if not self._has_estimated and self._service.estimate is not None:
            self._has_estimated = True
            self._next_status_ns = now_ns
            log.info("the first estimate is there")
        if self._look_ns is not None and now_ns >= self._next_look_ns:
            self._next_look_ns = now_ns + self._look_ns
            self._feed_watchdog(now_ns)
        if now_ns >= self._next_status_ns:
            self._next_status_ns = now_ns + min(CHANGE_NS, self._line_ns)
            self._report_status(now_ns)

    def _feed_watchdog(self, now_ns: int) -> None:
        """WATCHDOG=1, unless samples come and are not filtered."""
        fails = self._watch.fails(self._snapshot(now_ns), self._service.fresh(now_ns))
        if fails and not self._fails:
            log.error("samples come, but no estimate follows from them: left to the watchdog of systemd")
        self._fails = fails
        if not fails:
            self._notifier.alive()

    def _report_status(self, now_ns: int) -> None:
        """Tell systemd the state, and the log where it differs by more than its numbers or has been silent for long."""
        before, self._seen = self._seen, self._snapshot(now_ns)
        text = status_line(self._seen, before)
        self._notifier.status(text)
        words = _NUMBER.sub("#", text)
        if words != self._written or now_ns >= self._next_line_ns:
            self._written = words
            self._next_line_ns = now_ns + self._line_ns
            status_log.info("%s", text)
