"""A map over several processes that Ctrl-C ends quietly, and that end when the process that started them does.

The system may end a process, as when memory runs out. Its task and the others that are lost with it are done again.
"""

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import parent_process
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, Final, Protocol, TypeVar

from attest_mav.errors import UsageError, WorkersError

AHEAD: Final = 16
"""Tasks of each process that are given out before they are needed."""

Task = TypeVar("Task")
Result = TypeVar("Result")
GivenUp = Callable[[Any, str], Any]
"""The result of a task that was given up, with the reason for people."""


class TaskMap(Protocol):
    """The built-in ``map`` over one iterable, or the same over processes; results come in the order of the tasks."""

    def __call__(self, function: Callable[[Task], Result], tasks: Iterable[Task], /) -> Iterator[Result]:
        """Results of the function for each task."""


class Helper(SpawnProcess):
    """A process that Ctrl-C does not reach, not even while Python starts in it: ending is for the one that it helps.

    A blocked signal stays blocked in the process that is started; here a Ctrl-C in between waits until the end.
    """

    def start(self) -> None:
        """Start it with SIGINT blocked."""
        former = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, former)


class Helpers(SpawnContext):
    """How the helping processes are started.

    Processes are spawned, not forked: a fork would copy the threads and locks of whoever shows the progress.
    """

    Process = Helper


@contextmanager
def processes(workers: int | None, given_up: GivenUp | None = None) -> Iterator[TaskMap]:
    """A map over that many processes (None: one a core); with one worker, the built-in map. UsageError below one.

    given_up: makes the result of a task that ends its process twice; without it, that is a WorkersError.
    """
    if workers is not None and workers < 1:
        raise UsageError(f"{workers} workers: expected 1 or more processes")
    if workers == 1:
        yield map
        return
    helpers = _ProcessMap(workers or os.cpu_count() or 1, given_up)
    try:
        yield helpers
    except BaseException:  # Ctrl-C: what waits would otherwise be worked off first
        helpers.end(cancel_futures=True)
        raise
    helpers.end()


def end_with_starter() -> None:
    """In a helping process: end when the one that started it is gone, by SIGTERM or SIGKILL.

    Without this it would wait for ever: each helper holds the pipe of tasks open for all others.
    """
    starter = parent_process()
    if starter is not None:
        threading.Thread(target=_end_after, args=(starter.sentinel,), name="starter", daemon=True).start()


def _end_after(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


class _ProcessMap:
    """The built-in ``map`` over a pool, with a bounded number of tasks given out ahead of the result that is next."""

    def __init__(self, count: int, given_up: GivenUp | None) -> None:
        self._count = count
        self._given_up = given_up
        self._pool = _pool(count)

    def __call__(self, function: Callable[[Task], Result], tasks: Iterable[Task], /) -> Iterator[Result]:
        given: deque[tuple[Task, Future[Result]]] = deque()
        for task in tasks:
            given.append((task, self._submit(function, task)))
            if len(given) >= AHEAD * self._count:
                yield self._first(function, given)
        while given:
            yield self._first(function, given)

    def end(self, *, cancel_futures: bool = False) -> None:
        """Wait for the processes to end."""
        self._pool.shutdown(cancel_futures=cancel_futures)

    def _submit(self, function: Callable[[Task], Result], task: Task) -> Future[Result]:
        with interrupts_held():
            try:
                return self._pool.submit(function, task)
            except BrokenProcessPool:
                self._pool = _pool(self._count)
                return self._pool.submit(function, task)

    def _first(self, function: Callable[[Task], Result], given: deque[tuple[Task, Future[Result]]]) -> Any:
        """The result of the first of the tasks that are given out.

        With one process all tasks of the pool are lost. The first is done again in a process of its own, which no
        other can end; the others are given out again.
        """
        task, future = given.popleft()
        try:
            return future.result()
        except BrokenProcessPool:
            outcome = self._alone(function, task)
        for number, (other, lost) in enumerate(given):
            if lost.done() and isinstance(lost.exception(), BrokenProcessPool):
                given[number] = other, self._submit(function, other)
        return outcome

    def _alone(self, function: Callable[[Task], Result], task: Task) -> Any:
        try:
            with _pool(1) as own:
                with interrupts_held():
                    again = own.submit(function, task)
                return again.result()
        except BrokenProcessPool:
            reason = "the system ended its process twice, as it does when memory runs out"
            if self._given_up is None:
                raise WorkersError(f"a task is lost: {reason}; fewer processes need less (--workers)") from None
            return self._given_up(task, reason)


def _pool(count: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(count, mp_context=Helpers(), initializer=end_with_starter)


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the end of this block: a pool whose queue was interrupted half-way hangs. Main thread only."""
    held = []
    former = signal.signal(signal.SIGINT, lambda *_: held.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, former)
        if held:
            raise KeyboardInterrupt
