"""Programs as processes: what they write is read as it comes, and waited for with a deadline."""

import os
import queue
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from .hub import Hub

PATIENCE_S = 30.0
"""Nothing here takes a tenth of this on a quiet machine."""


class Program:
    """A running command; ``lines`` is all that it has written to stderr."""

    def __init__(self, command: list[str], environment: dict[str, str]) -> None:
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | environment,
        )
        self.lines: list[str] = []
        self._new: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        for line in self.process.stderr:
            self._new.put(line.rstrip("\n"))
        self._new.put(None)

    def wait_for(self, pattern: str) -> re.Match[str]:
        """The next line that matches."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                line = self._new.get(timeout=max(0.0, deadline - time.monotonic()))
            except queue.Empty:
                pytest.fail(f"no line like {pattern!r} came; there were {self.lines}")
            if line is None:
                pytest.fail(f"it ended without a line like {pattern!r}: {self.lines}")
            self.lines.append(line)
            if found := re.search(pattern, line):
                return found

    def end(self, number: int = signal.SIGINT) -> int:
        """Send a signal; the exit code."""
        self.process.send_signal(number)
        return self.exit_code()

    def exit_code(self) -> int:
        """Wait for the end; the exit code."""
        code = self.process.wait(PATIENCE_S)
        self._reader.join(PATIENCE_S)
        while (line := self._new.get_nowait()) is not None:
            self.lines.append(line)
        return code


@pytest.fixture
def start(start_command: Callable[..., Program], command: list[str]) -> Callable[..., Program]:
    """Starts attest-mav with these arguments."""
    return lambda *arguments, **environment: start_command([*command, *arguments], environment)


@pytest.fixture
def hub() -> Iterator[Hub]:
    """A router that gives every datagram to all others."""
    router = Hub()
    yield router
    router.close()


@pytest.fixture
def start_command() -> Iterator[Callable[..., Program]]:
    """Starts any command; whatever still runs in the end is killed."""
    programs: list[Program] = []

    def make(whole: list[str], environment: dict[str, str]) -> Program:
        programs.append(Program(whole, environment))
        return programs[-1]

    yield make
    for program in programs:
        program.process.kill()
        program.process.wait()
        program.process.stderr.close()
