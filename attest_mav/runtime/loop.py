"""The event loop: descriptors with handlers, deadlines, and the stop signal, in one thread with one selector.

Links, timers and whatever else waits for something are ``Handler``s of one loop. A turn waits until a descriptor is
ready or a deadline has come, then calls the handlers that are meant, first of descriptors, then of deadlines.
"""

import selectors
import signal
import socket
import time
from collections.abc import Callable
from typing import Final, NamedTuple

READ: Final = selectors.EVENT_READ
WRITE: Final = selectors.EVENT_WRITE

LONGEST_WAIT_S: Final = 3600.0
"""One wait of the selector, s: the system call takes milliseconds in 32 bits."""


SIGNALS_AT_ONCE: Final = 64
"""Signals that are taken in one turn."""


class Watch(NamedTuple):
    """A descriptor that the selector is to watch for a handler."""

    fd: int
    """The file descriptor."""
    stream: int
    """Tells a descriptor from a later one with the same number: the system gives a closed number out again at once."""
    events: int
    """``READ``, ``WRITE`` or both."""


class Handler:
    """Something that a loop serves: a descriptor, a deadline, or both. This one has neither."""

    @property
    def watch(self) -> Watch | None:
        """The descriptor to watch now, None while there is none. Asked before each wait: it may come and go."""
        return None

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``due`` is to be called, on the monotonic clock; None for never, a time in the past for at once."""
        return None

    def readable(self, now_ns: int) -> None:
        """The descriptor has something to read, or has ended."""

    def writable(self, now_ns: int) -> None:
        """The descriptor takes data again."""

    def due(self, now_ns: int) -> None:
        """The deadline has come."""


class Timer(Handler):
    """A deadline and the function to call at it."""

    def __init__(self, deadline_ns: Callable[[], int | None], due: Callable[[int], None]) -> None:
        self._deadline_ns: Final = deadline_ns
        self._due: Final = due

    @property
    def next_deadline_ns(self) -> int | None:
        """See ``Handler``."""
        return self._deadline_ns()

    def due(self, now_ns: int) -> None:
        """See ``Handler``."""
        self._due(now_ns)


class Loop:
    """Serves its handlers in the order in which they were added, until it is stopped."""

    def __init__(self) -> None:
        self._selector: Final = selectors.DefaultSelector()
        self._handlers: Final[list[Handler]] = []
        self._watched: dict[Handler, Watch] = {}
        self._stopped = False

    def add(self, handler: Handler) -> None:
        """Serve this one too."""
        self._handlers.append(handler)

    def remove(self, handler: Handler) -> None:
        """Serve this one no more; its descriptor may be closed at once."""
        self._handlers.remove(handler)

    def stop(self) -> None:
        """End ``run`` before the next handler is called."""
        self._stopped = True

    def run(self, stop: socket.socket, hang_up: Callable[[int], None] | None = None) -> None:
        """Serve until ``stop`` becomes readable (see ``stop_signals``) or ``stop()`` is called.

        hang_up: is called for SIGHUP instead.
        """
        self.add(_SignalHandler(stop, self, hang_up))
        while not self._stopped:
            self._turn()

    def close(self) -> None:
        """Give the selector back; descriptors stay as they are."""
        self._selector.close()

    def _turn(self) -> None:
        """Wait, and serve everything that is ready or due then."""
        self._watch()
        events = self._selector.select(self._wait_s(time.monotonic_ns()))
        now_ns = time.monotonic_ns()
        for key, mask in events:
            self._serve(key.data, mask, now_ns)
        for handler in self._handlers.copy():
            due_ns = handler.next_deadline_ns
            if due_ns is not None and due_ns <= now_ns and self._is_served(handler):
                handler.due(now_ns)

    def _serve(self, handler: Handler, mask: int, now_ns: int) -> None:
        if mask & WRITE and self._is_served(handler):
            handler.writable(now_ns)
        if mask & READ and self._is_served(handler):
            handler.readable(now_ns)

    def _is_served(self, handler: Handler) -> bool:
        """Whether the handler is still to be called: an earlier one of the same turn may have removed it."""
        return not self._stopped and handler in self._handlers

    def _wait_s(self, now_ns: int) -> float:
        """The time to the earliest deadline, at most ``LONGEST_WAIT_S``."""
        deadlines = [due_ns for handler in self._handlers if (due_ns := handler.next_deadline_ns) is not None]
        if not deadlines:
            return LONGEST_WAIT_S
        return min(max((min(deadlines) - now_ns) * 1e-9, 0.0), LONGEST_WAIT_S)

    def _watch(self) -> None:
        """Keep the selector in step with the handlers: descriptors come and go, and numbers are used again.

        Everything old is taken out before anything new is put in: a number that one handler has closed may already be
        another one's.
        """
        wanted = {handler: watch for handler in self._handlers if (watch := handler.watch) is not None}
        if wanted == self._watched:
            return
        for handler, old in self._watched.items():
            if wanted.get(handler) != old:
                self._selector.unregister(old.fd)
        for handler, new in wanted.items():
            if self._watched.get(handler) != new:
                self._selector.register(new.fd, new.events, handler)
        self._watched = wanted


class _SignalHandler(Handler):
    """Stops the loop when a socket becomes readable, unless all that comes is SIGHUP and there is a use for that."""

    def __init__(self, signals: socket.socket, loop: Loop, hang_up: Callable[[int], None] | None) -> None:
        self._watch: Final = Watch(signals.fileno(), 0, READ)
        self._signals: Final = signals
        self._loop: Final = loop
        self._hang_up: Final = hang_up

    @property
    def watch(self) -> Watch | None:
        return self._watch

    def readable(self, now_ns: int) -> None:
        numbers = self._signals.recv(SIGNALS_AT_ONCE) if self._hang_up is not None else b""
        if self._hang_up is None or set(numbers) != {signal.SIGHUP}:
            self._loop.stop()
        else:
            self._hang_up(now_ns)
