"""Scenarios of the papers, with their trials spread over processes.

A scenario has an id, bounds for what it measures, and a function that measures it. To add the scenarios of a paper:

1. Write a module like ``paper1``: a picklable record of one trial (seed and run number included), a module-level
   function that runs one, a ``measure`` function for each scenario that maps trials and returns named figures, and a
   tuple ``SCENARIOS``.
2. Add that tuple in ``scenarios.all_scenarios``. The command, its table and its JSON need nothing else.

A trial draws all its random numbers from ``np.random.default_rng([seed, run])``, so that it depends neither on how
many runs there are nor on the process that it lands in.
"""

import os
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from math import isfinite
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Final, Protocol, TypeVar

from attest_mav.errors import UsageError

AHEAD: Final = 16
"""Tasks of each process that are given out before they are needed."""

Bound = tuple[float, float]
"""Lowest and highest value that passes."""

Task = TypeVar("Task")
Result = TypeVar("Result")


class TrialMap(Protocol):
    """The built-in ``map`` over one iterable, or the same over processes; results come in the order of the tasks."""

    def __call__(self, function: Callable[[Task], Result], tasks: Iterable[Task], /) -> Iterator[Result]:
        """Results of the function for each task."""


Measure = Callable[[int, int, TrialMap], dict[str, float]]
"""Measures a scenario: number of runs, seed and map in, named figures out."""


@dataclass(frozen=True)
class Outcome:
    """Figures of a scenario, with their bounds and the paper's figures (None where the paper printed none)."""

    id: str
    title: str
    measured: Mapping[str, float]
    bounds: Mapping[str, Bound]
    paper: Mapping[str, float] | None
    runs: int
    seed: int

    def within(self, name: str) -> bool:
        """Whether one figure is within its bound; a figure that is not a number never is."""
        low, high = self.bounds[name]
        return low <= self.measured[name] <= high

    @property
    def passed(self) -> bool:
        """Whether every bounded figure is within its bound."""
        return all(self.within(name) for name in self.bounds)

    def as_json(self) -> dict[str, object]:
        """The record that ``evaluate --json`` prints; figures that are not numbers become null."""
        return {
            "id": self.id,
            "measured": {name: value if isfinite(value) else None for name, value in self.measured.items()},
            "bounds": {name: list(bound) for name, bound in self.bounds.items()},
            "paper": None if self.paper is None else dict(self.paper),
            "runs": self.runs,
            "seed": self.seed,
            "pass": self.passed,
        }


@dataclass(frozen=True)
class Scenario:
    """A condition of a paper with what must hold in it.

    default_runs: Monte Carlo runs for which the bounds are meant; fewer are quicker and may miss one by chance.
    """

    id: str
    title: str
    default_runs: int
    bounds: Mapping[str, Bound]
    measure: Measure
    paper: Mapping[str, float] | None = None

    def evaluate(self, runs: int | None, seed: int, trial_map: TrialMap) -> Outcome:
        """Measure with that many runs (None: the default number)."""
        runs = self.default_runs if runs is None else runs
        measured = self.measure(runs, seed, trial_map)
        return Outcome(self.id, self.title, measured, self.bounds, self.paper, runs, seed)


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
def processes(workers: int | None) -> Iterator[TrialMap]:
    """A map over that many processes (None: one a core); with one worker, the built-in map. UsageError below one."""
    if workers is not None and workers < 1:
        raise UsageError(f"{workers} workers: expected 1 or more processes")
    if workers == 1:
        yield map
        return
    count = workers or os.cpu_count() or 1
    with ProcessPoolExecutor(count, mp_context=Helpers()) as pool:
        try:
            yield partial(map_over, pool, AHEAD * count)
        except BaseException:  # Ctrl-C: what waits would otherwise be worked off first
            pool.shutdown(cancel_futures=True)
            raise


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
