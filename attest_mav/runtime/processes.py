"""A map over several processes that Ctrl-C ends quietly, and that end when the process that started them does."""

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import parent_process
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Final, Protocol, TypeVar

from attest_mav.errors import UsageError

AHEAD: Final = 16
"""Tasks of each process that are given out before they are needed."""

Task = TypeVar("Task")
Result = TypeVar("Result")


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
def processes(workers: int | None) -> Iterator[TaskMap]:
    """A map over that many processes (None: one a core); with one worker, the built-in map. UsageError below one."""
    if workers is not None and workers < 1:
        raise UsageError(f"{workers} workers: expected 1 or more processes")
    if workers == 1:
        yield map
        return
    count = workers or os.cpu_count() or 1
    with ProcessPoolExecutor(count, mp_context=Helpers(), initializer=end_with_starter) as pool:
        try:
            yield partial(map_over, pool, AHEAD * count)
        except BaseException:  # Ctrl-C: what waits would otherwise be worked off first
            pool.shutdown(cancel_futures=True)
            raise


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


def map_over(
    pool: ProcessPoolExecutor, ahead: int, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Iterator[Result]:
    """The built-in ``map`` over a pool, with at most that many tasks given out ahead of the result that is next."""
    given: deque[Future[Result]] = deque()
    for task in tasks:
        with interrupts_held():
            given.append(pool.submit(function, task))
        if len(given) >= ahead:
            yield given.popleft().result()
    while given:
        yield given.popleft().result()


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
