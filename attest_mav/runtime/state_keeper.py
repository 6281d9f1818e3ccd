"""Keeps the state on disk: the time of our signatures, parameters that stations have set, and sensors' errors."""

import logging
import os
import time
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Final

from attest_mav.errors import ConfigError, UnwritableError
from attest_mav.runtime.files import DISK_FAULTS, atomic_write, reason_of
from attest_mav.runtime.loop import Handler
from attest_mav.service.kept_state import KeptState, Persistence, parse_state, parse_without_calibrations, state_text

log = logging.getLogger("attest_mav.daemon")

FILE_NAME: Final = "state.json"
PERIOD_NS: Final = 30_000_000_000
"""The time of the signatures is kept this often: a start counts on less than a minute."""
LOOK_NS: Final = 5_000_000_000
"""Parameters are looked at this often, and written where one was set."""


def state_path(folder: str, environment: Mapping[str, str]) -> Path:
    """The file of the state. folder: the configured one, "" for systemd's, else the user's own."""
    if folder:
        return Path(folder) / FILE_NAME
    given = environment.get("STATE_DIRECTORY", "").split(":")[0]
    if given:
        return Path(given) / FILE_NAME
    home = environment.get("XDG_STATE_HOME", "") or str(Path.home() / ".local" / "state")
    return Path(home) / "attest-mav" / FILE_NAME


def is_named(folder: str, environment: Mapping[str, str]) -> bool:
    """Whether the configuration or systemd names a folder for the state."""
    return bool(folder or environment.get("STATE_DIRECTORY"))


class StateKeeper(Handler):
    """Restores the state of a service, and writes it from time to time.

    keeps_time: whether the time of signatures must be kept; else the file is written when something else has changed.

    ConfigError where it cannot be written; a disk that is full or read-only is told, and tried again. A thread of its
    own writes: a memory card may take seconds, and the loop waits for nothing.
    """

    def __init__(self, persistence: Persistence, path: Path, now_ns: int, keeps_time: bool = True) -> None:
        self._persistence: Final = persistence
        self._path: Final = path
        self._keeps_time: Final = keeps_time
        self._disk: Final = ThreadPoolExecutor(1, "state")
        self._writing: tuple[KeptState, Future[None]] | None = None
        self._due_ns = now_ns + LOOK_NS
        self._time_due_ns = now_ns + PERIOD_NS
        self._is_failing = False
        self._written = _read(path)
        persistence.restore(self._written, time.time_ns(), now_ns)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(path, persistence.state)
        except OSError as error:
            if error.errno not in DISK_FAULTS:
                raise ConfigError(f"state.folder: cannot make {path.parent}: {reason_of(error)}") from None
            self._fail(f"cannot make {path.parent}: {reason_of(error)}")
        except UnwritableError as error:
            if not isinstance(error.__cause__, OSError) or error.__cause__.errno not in DISK_FAULTS:
                raise ConfigError(f"state.folder: {error}; name a folder that may be written") from None
            self._fail(str(error))

    @property
    def next_deadline_ns(self) -> int | None:
        """See ``Handler``."""
        return self._due_ns

    def due(self, now_ns: int) -> None:
        """Tell the service the time of day, which may have been set, and begin to write what is due."""
        self._due_ns = now_ns + LOOK_NS
        self._persistence.set_time(time.time_ns(), now_ns)
        if self._writing is not None and self._writing[1].done():
            self.settle()
        state, written = self._persistence.state, self._written
        is_due = now_ns >= self._time_due_ns and (self._keeps_time or state.calibrations != written.calibrations)
        if self._writing is None and (is_due or state.parameters != written.parameters):
            self._time_due_ns = now_ns + PERIOD_NS
            self._begin()

    def settle(self) -> None:
        """Wait until the file is written. A failure is told once, and so is its end."""
        if self._writing is None:
            return
        state, outcome = self._writing
        self._writing = None
        try:
            outcome.result()
        except UnwritableError as error:
            self._fail(str(error))
            return
        self._written = state
        if self._is_failing:
            log.info("%s is written again", self._path)
        self._is_failing = False

    def finish(self) -> None:
        """Write the last state, and wait for it."""
        self.settle()
        self._begin()
        self.settle()
        self._disk.shutdown()

    def _fail(self, complaint: str) -> None:
        if not self._is_failing:
            lost = "parameters that were set, the time of signatures, and errors of sensors"
            log.warning("%s; a restart would lose %s", complaint, lost)
        self._is_failing = True

    def _begin(self) -> None:
        state = self._persistence.state
        self._writing = state, self._disk.submit(_write, self._path, state)


def _write(path: Path, state: KeptState) -> None:
    """Write the file so that it is on the disk when this returns."""
    with suppress(OSError):  # where the disk could not have it at the start; writing says what is wrong
        path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as file:
        file.write(state_text(state))
        file.flush()
        os.fsync(file.fileno())


def _read(path: Path) -> KeptState:
    """The state that was kept, or a new one; a file that holds none is told and replaced."""
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        return KeptState()
    except OSError as error:
        raise ConfigError(f"state.folder: cannot read {path}: {reason_of(error)}") from None
    try:
        return parse_state(text)
    except (ValueError, RecursionError) as error:
        complaint = str(error)
    try:
        state = parse_without_calibrations(text)
    except (ValueError, RecursionError):
        log.warning("%s holds no state (%s): beginning anew", path, complaint)
        return KeptState()
    log.warning("%s: the calibrations make no sense (%s): beginning without them", path, complaint)
    return state
