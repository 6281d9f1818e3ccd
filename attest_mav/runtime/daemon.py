"""The daemon: real links and the real clock around ``Service``, on one event loop."""

import logging
import os
import socket
import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final

from attest_mav.config.calibration import calibrations_text
from attest_mav.config.live import differences, with_live_keys
from attest_mav.config.parsing import web_address
from attest_mav.config.records import Config
from attest_mav.config.text import printable
from attest_mav.errors import AttestMavError
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.runtime.journal import log_as
from attest_mav.runtime.keys import read_keys
from attest_mav.runtime.links.base import Link
from attest_mav.runtime.links.open import open_links
from attest_mav.runtime.links.served import ServedLink
from attest_mav.runtime.loop import Loop, Timer
from attest_mav.runtime.notify import Notifier
from attest_mav.runtime.reporter import Reporter
from attest_mav.runtime.state_keeper import StateKeeper, is_named, state_path
from attest_mav.service.assembly import service_settings
from attest_mav.service.field_lookup import FieldFinder
from attest_mav.service.link_records import Traffic
from attest_mav.service.service import Service
from attest_mav.service.snapshot import Snapshot

if TYPE_CHECKING:
    from attest_mav.runtime.recorder.recorder import Recorder
    from attest_mav.runtime.web.server import WebServer
    from attest_mav.service.tape import Tape

log = logging.getLogger("attest_mav.daemon")


class Daemon:
    """Opens the links, LinkError when one cannot be had, and runs until SIGINT or SIGTERM.

    read_again: reads the configuration anew, for SIGHUP; AttestMavError where it cannot be used.
    """

    def __init__(self, config: Config, find_field: FieldFinder, read_again: Callable[[], Config] | None = None) -> None:
        now_ns = time.monotonic_ns()
        self._config = config
        self._keys: Final = read_keys(config.link)
        self._read_again: Final = read_again
        settings = service_settings(config, self._keys)
        dialect = load_dialect()
        self.loop: Final = Loop()
        """Other handlers may be added before ``run``."""
        self.links: Final = open_links(config.link, dialect, now_ns)
        self._tape: Final = self._new_tape(config, dialect, now_ns)
        names = [link.url for link in self.links]
        self.service: Final = Service(settings, names, dialect, find_field, now_ns, self._tape)
        self._keeper: Final = self._state_keeper(config, now_ns)
        self._recorder: Final = self._new_recorder(config)
        self._notifier: Final = Notifier(os.environ)
        for number, link in enumerate(self.links):
            restarted = partial(self.service.link_restarted, number)
            self.loop.add(ServedLink(link, partial(self._receive, number), restarted))
        self.loop.add(Timer(lambda: self.service.due_ns, self._poll))
        self._web: Final = self._web_server(config, now_ns)
        self._reporter: Final = Reporter(self.service, self._notifier, self.snapshot, config.log.status_s, now_ns)
        self.loop.add(self._reporter)

    def snapshot(self, now_ns: int) -> Snapshot:
        """Everything that may be seen of the daemon, the links' counters included."""
        recording = None if self._recorder is None else self._recorder.snapshot
        return self.service.snapshot(now_ns, [_traffic(link) for link in self.links], recording)

    def run(self, stop: socket.socket) -> None:
        """Work until ``stop`` becomes readable (see ``stop_signals``); then say goodbye and close.

        SIGHUP lets it read its configuration again.
        """
        try:
            self.loop.run(stop, self._reload)
        finally:
            self._end()

    def _reload(self, now_ns: int) -> None:
        """Read the configuration again; one that cannot be used changes nothing, and the log says why."""
        if self._read_again is None:
            log.info("SIGHUP: there is no configuration to be read again")
            return
        self._notifier.reloading(now_ns)
        try:
            self._use(self._read_again())
        except AttestMavError as error:
            log.error("reload: %s; the configuration in force stays", printable(str(error)))  # noqa: TRY400  (no traceback for users)
        self._notifier.ready()

    def _use(self, wanted: Config) -> None:
        """Put in force what can change while the daemon runs, and name the keys that need a new start."""
        config = with_live_keys(self._config, wanted)
        changed, left = differences(self._config, config), differences(config, wanted)
        self.service.use(service_settings(config, self._keys))
        log_as(config.log.level, config.log.format)
        if config.log.status_s != self._config.log.status_s:
            self._reporter.report_every(config.log.status_s)
        self._config = config
        for key, (before, now) in changed.items():
            log.info("reload: %s = %s (was %s)", key, now or "absent", before or "absent")
        for key, (before, now) in left.items():
            log.warning("reload: %s = %s needs a restart; %s stays", key, now or "absent", before or "absent")
        if not changed and not left:
            log.info("reload: nothing has changed")

    def _state_keeper(self, config: Config, now_ns: int) -> StateKeeper | None:
        """The keeper of the state on disk, None where nothing must be kept."""
        learns = config.state.calibration and is_named(config.state.folder, os.environ)
        if not (config.keeps_state or learns):
            return None
        path = state_path(config.state.folder, os.environ)
        keeper = StateKeeper(self.service.persistence, path, now_ns, keeps_time=config.keeps_time)
        self.loop.add(keeper)
        return keeper

    def _new_tape(self, config: Config, dialect: Dialect, now_ns: int) -> "Tape | None":
        """The tape, with times of day by the clock of now; None where nothing is recorded."""
        if not config.record.folder:
            return None
        from attest_mav.service.tape import Tape  # noqa: PLC0415  (costs nothing while it is off)

        return Tape(dialect, time.time_ns() - now_ns, config.output.component_id)

    def _new_recorder(self, config: Config) -> "Recorder | None":
        """The recorder of the tape."""
        if self._tape is None:
            return None
        from attest_mav.runtime.recorder.recorder import Recorder  # noqa: PLC0415  (costs nothing while it is off)

        return Recorder(config.record, self._tape, self._calibration_text)

    def _calibration_text(self) -> bytes:
        """The errors of the sensors with which the vehicle's filters began, as a file has them; empty for none."""
        given = self.service.persistence.calibrations.given
        return calibrations_text(given) if given else b""

    def _web_server(self, config: Config, now_ns: int) -> "WebServer | None":
        """The live page, None where it is off."""
        if not config.web.listen:
            return None
        from attest_mav.runtime.web.server import WebServer  # noqa: PLC0415  (costs nothing while it is off)

        url = web_address(config.web.listen, "web.listen")
        server = WebServer(self.loop, url, config.web.hosts, self.snapshot, now_ns)
        self.loop.add(server)
        return server

    def _receive(self, number: int, data: bytes, now_ns: int) -> None:
        """Take bytes of a link; an estimate made of them leaves in the same turn."""
        link = self.links[number]
        if self.service.receive(number, data, now_ns, link.stream):
            link.confirm(now_ns)
        self._put_out(now_ns)

    def _poll(self, now_ns: int) -> None:
        self.service.poll(now_ns)
        self._put_out(now_ns)

    def _put_out(self, now_ns: int) -> None:
        """Write the service's frames to the links, and its notes to the log."""
        for number, link in enumerate(self.links):
            for frame in self.service.take_frames(number):
                link.send(frame, now_ns)
                if self._tape is not None:
                    self._tape.say(frame, now_ns)
        for note in self.service.take_notes():
            log.log(note.level, "%s", note.text)
            if self._tape is not None:
                self._tape.note(note, now_ns)
        if self._recorder is not None:
            self._recorder.pass_on(now_ns, self.service.is_armed)

    def _end(self) -> None:
        """Send the last frames on every link that still takes them, and close everything."""
        log.info("stopping")
        self._notifier.stopping()
        self.service.stop()
        self._put_out(time.monotonic_ns())
        if self._keeper is not None:
            self._keeper.finish()
        if self._recorder is not None:
            self._recorder.finish()
        if self._web is not None:
            self._web.close()
        for link in self.links:
            link.close()
        self.loop.close()
        self._notifier.close()


def _traffic(link: Link) -> Traffic:
    return Traffic(link.is_up, link.is_open, link.epoch, link.received_bytes, link.sent_bytes, link.dropped_messages)
