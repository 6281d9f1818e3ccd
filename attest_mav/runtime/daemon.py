"""The daemon: one thread, one selector, real links and the real clock around ``Service``."""

import logging
import os
import selectors
import socket
import time

from attest_mav.config.records import Config
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.runtime.links.base import Link
from attest_mav.runtime.links.open import open_links
from attest_mav.runtime.notify import Notifier
from attest_mav.service.assembly import service_settings
from attest_mav.service.field_lookup import FieldFinder
from attest_mav.service.service import Service
from attest_mav.service.status import status_line

log = logging.getLogger("attest_mav.daemon")

STOP = -1
"""What the selector calls the stop signal; links are called by their numbers."""


class Daemon:
    """Opens the links and runs until SIGINT or SIGTERM.

    LinkError when a link cannot be had.
    """

    def __init__(self, config: Config, find_field: FieldFinder) -> None:
        now_ns = time.monotonic_ns()
        dialect = load_dialect()
        self.links = open_links(config.link, dialect, now_ns)
        self.service = Service(service_settings(config), [link.url for link in self.links], dialect, find_field, now_ns)
        self.notifier = Notifier(os.environ)
        self.selector = selectors.DefaultSelector()
        self._ready = False
        self._epochs = [link.epoch for link in self.links]
        self._watched: list[tuple[int, int, int] | None] = [None] * len(self.links)
        self._status_ns = int(config.log.status_s * 1e9)
        self._next_status_ns = now_ns
        self._shown = self.service.snapshot(now_ns)
        self._next_alive_ns = now_ns

    def run(self, stop: socket.socket) -> None:
        """Work until ``stop`` becomes readable (see ``stop_signals``); then say goodbye and close."""
        self.selector.register(stop, selectors.EVENT_READ, STOP)
        try:
            while self._turn():
                pass
        finally:
            self._end()

    def _turn(self) -> bool:
        """Wait for a link or a deadline, and do what follows; False when it is time to stop."""
        self._watch()
        wait_s = (self._next_deadline_ns() - time.monotonic_ns()) * 1e-9
        events = self.selector.select(max(0.0, wait_s))
        now_ns = time.monotonic_ns()
        for key, mask in events:
            if key.data == STOP:
                return False
            if mask & selectors.EVENT_WRITE:
                self.links[key.data].flush(now_ns)
            if mask & selectors.EVENT_READ:
                self._read(key.data, now_ns)
        for number, link in enumerate(self.links):
            due_ns = link.next_deadline_ns
            if due_ns is not None and due_ns <= now_ns:
                self._read(number, now_ns)
        self._write(now_ns)
        if self.service.due_ns <= now_ns:
            self.service.poll(now_ns)
            self._write(now_ns)
        self._log_notes()
        self._report(now_ns)
        return True

    def _log_notes(self) -> None:
        for note in self.service.take_notes():
            log.log(note.level, "%s", note.text)

    def _read(self, number: int, now_ns: int) -> None:
        """One read; if there is more, the selector says so at once."""
        link = self.links[number]
        data = link.receive(now_ns)
        if link.epoch != self._epochs[number]:
            self._epochs[number] = link.epoch
            self.service.link_restarted(number)
        if data:
            self.service.receive(number, data, now_ns)

    def _write(self, now_ns: int) -> None:
        for number, link in enumerate(self.links):
            for frame in self.service.take_frames(number):
                link.send(frame, now_ns)

    def _report(self, now_ns: int) -> None:
        """Tell systemd and the log. WATCHDOG=1 comes from here alone, and only while estimates are fresh."""
        if not self._ready and self.service.fresh(now_ns):
            self._ready = True
            self._next_status_ns = now_ns
            log.info("ready: the first estimate is there")
            self.notifier.ready()
        watchdog_ns = self.notifier.watchdog_ns
        if self._ready and watchdog_ns is not None and now_ns >= self._next_alive_ns and self.service.fresh(now_ns):
            self._next_alive_ns = now_ns + watchdog_ns
            self.notifier.alive()
        if now_ns >= self._next_status_ns:
            self._next_status_ns = now_ns + self._status_ns
            before, self._shown = self._shown, self.service.snapshot(now_ns)
            text = status_line(self._shown, before)
            log.info("%s", text)
            self.notifier.status(text)

    def _next_deadline_ns(self) -> int:
        deadlines = [self.service.due_ns, self._next_status_ns]
        deadlines += [due_ns for link in self.links if (due_ns := link.next_deadline_ns) is not None]
        if self._ready and self.notifier.watchdog_ns is not None and self.service.estimate is not None:
            deadlines.append(self._next_alive_ns)
        return min(deadlines)

    def _watch(self) -> None:
        """Keep the selector in step with the links: descriptors come and go, and numbers are used again."""
        wanted = [_watch_of(link) for link in self.links]
        if wanted == self._watched:
            return
        for old, new in zip(self._watched, wanted, strict=True):
            if old is not None and old != new:
                self.selector.unregister(old[0])
        for number, (old, new) in enumerate(zip(self._watched, wanted, strict=True)):
            if new is not None and old != new:
                self.selector.register(new[0], new[2], number)
        self._watched = wanted

    def _end(self) -> None:
        """The last words, on every link that still takes them."""
        log.info("stopping")
        self.notifier.stopping()
        self.service.stop()
        self._write(time.monotonic_ns())
        for link in self.links:
            link.close()
        self.selector.close()
        self.notifier.close()


def _watch_of(link: Link) -> tuple[int, int, int] | None:
    """Descriptor, epoch and events to watch a link for; None while it has no descriptor."""
    fd = link.fd
    if fd is None:
        return None
    return (fd, link.epoch, selectors.EVENT_READ | (selectors.EVENT_WRITE if link.wants_write else 0))
