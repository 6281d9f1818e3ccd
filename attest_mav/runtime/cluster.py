"""A map over the workers of a Dask cluster, which may be other computers.

The scheduler repeats the task of a worker that has ended on another one. A task on which several workers have ended,
the last of them with no other task, or which gives no result in time, is given up, and the others go on. Dask is
imported here alone.
"""

import logging
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.util import find_spec
from time import monotonic
from typing import TYPE_CHECKING, Any, Final, TypeVar

from attest_mav.errors import UsageError, WorkersError
from attest_mav.runtime.processes import AHEAD, GivenUp, TaskMap

if TYPE_CHECKING:
    from distributed import Client, Future

CONNECT_S: Final = 10.0
"""s. The scheduler must have answered by then."""
WORKERS_S: Final = 60.0
"""s. So long is waited for a first worker, and for a new one when all have left."""
ANSWER_S: Final = 60.0
"""s. A worker that is free must have answered the first question by then."""
TASK_S: Final = 3600.0
"""s. A task without a result for so long, after all results before it, is given up."""
POLL_S: Final = 1.0
"""s. Time between two looks at the state of the cluster."""

Task = TypeVar("Task")
Result = TypeVar("Result")
Probe = Callable[[], str]
"""Names the program of a worker, its version and its Python; an exception says why it cannot do the work."""


@contextmanager
def cluster(address: str, probe: Probe, given_up: GivenUp, say: Callable[[str], None]) -> Iterator[TaskMap]:
    """A map over the workers of the cluster with a scheduler at that address; results in the order of the tasks.

    probe: is called on each worker, and here, and the answers are compared. say: takes remarks for people.
    WorkersError without a scheduler or worker, UsageError without Dask.
    """
    if find_spec("distributed") is None:
        raise UsageError("--dask needs Dask: install the extra cluster, as with pip install 'attest-mav[cluster]'")
    client = _connected(address)
    try:
        _check_workers(client, address, probe, say)
        yield _ClusterMap(client, address, given_up)
    finally:
        client.close(timeout=CONNECT_S)


def _connected(address: str) -> "Client":
    import distributed  # noqa: PLC0415  # an extra

    # Dask's lines about workers and results that it repeats are no news here; each of its loggers has its own level.
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        # Other versions of libraries are a warning there; the probe compares what matters here.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = "nobody answers" if isinstance(error, OSError) else str(error)
        raise WorkersError(
            f"no Dask scheduler at {address}: {reason}; expected HOST:PORT of one that runs (dask scheduler)"
        ) from None


def _check_workers(client: "Client", address: str, probe: Probe, say: Callable[[str], None]) -> None:
    """WorkersError unless a worker can do the work; a remark on each whose program is another one."""
    try:
        client.wait_for_workers(1, timeout=WORKERS_S)
    except TimeoutError:
        raise WorkersError(
            f"the Dask scheduler at {address} has no workers after {WORKERS_S:g} s; start some (dask worker {address})"
        ) from None
    asked = {worker: client.submit(probe, workers=[worker], pure=False) for worker in _threads(client)}
    deadline, ours, answered = monotonic() + ANSWER_S, probe(), 0
    for worker, answer in asked.items():
        try:
            error = answer.exception(timeout=max(0.0, deadline - monotonic()))
        except TimeoutError:
            say(f"worker {worker} has not answered in {ANSWER_S:g} s")
            continue
        if error is not None:
            raise WorkersError(f"worker {worker} cannot do the work: {error}; expected {ours} there")
        answered += 1
        if (theirs := answer.result()) != ours:
            say(f"worker {worker} has {theirs}; here is {ours}: results may differ")
    if not answered:
        raise WorkersError(f"no worker of the Dask scheduler at {address} has answered; are they at other work?")


@dataclass(frozen=True)
class _NoResult:
    """A task has given no result."""

    reason: str
    """For people."""
    workers_ended: int = 0
    """Workers that ended while they had the task; 0 where another thing is the reason."""


class _ClusterMap:
    """The built-in ``map`` over the cluster, with a bounded number of tasks given out ahead of the next result."""

    def __init__(self, client: "Client", address: str, given_up: GivenUp) -> None:
        self._client = client
        self._address = address
        self._given_up = given_up

    def __call__(self, function: Callable[[Task], Result], tasks: Iterable[Task]) -> Iterator[Result]:
        given: deque[tuple[Task, Future]] = deque()
        for task in tasks:
            given.append((task, self._client.submit(function, task, pure=False)))
            if len(given) >= AHEAD * max(1, sum(_threads(self._client).values())):
                yield self._first(function, given)
        while given:
            yield self._first(function, given)

    def _first(self, function: Callable[[Task], Result], given: "deque[tuple[Task, Future]]") -> Any:
        """The result of the first of the tasks that are given out.

        The scheduler blames each task that a worker had when the worker ended, also those that waited there. A blamed
        task is tried once more, after all others have ended: then no other one can end its worker.
        """
        from distributed import wait  # noqa: PLC0415  # an extra

        task, future = given.popleft()
        outcome = self._outcome(future)
        if isinstance(outcome, _NoResult) and outcome.workers_ended:
            with self._client.as_current(), suppress(TimeoutError):
                wait([other for _, other in given], timeout=TASK_S)
            workers = list(_threads(self._client))
            alone = self._client.submit(function, task, pure=False, workers=workers[:1])
            outcome = self._outcome(alone, outcome.workers_ended, *workers[:1])
        return self._given_up(task, outcome.reason) if isinstance(outcome, _NoResult) else outcome

    def _outcome(self, future: "Future", ended_before: int = 0, only_worker: str = "") -> Any:
        """The result of a task as soon as it is there, or _NoResult; WorkersError when the cluster is gone.

        ended_before: workers that the task has outlived. only_worker: the task may run on this one alone, where given.
        """
        begun = alive = monotonic()
        while monotonic() - begun < TASK_S:
            try:
                error = future.exception(timeout=POLL_S)
                if future.status == "finished":
                    return future.result(timeout=POLL_S)
            except TimeoutError:
                error = None
            if error is not None:
                return _failed(error, ended_before)
            if self._client.status != "running" or future.cancelled():
                raise self._lost("the Dask scheduler at {} is gone; --results keeps what is done: start again")
            workers = _threads(self._client)
            if only_worker and only_worker not in workers:
                future.cancel()
                return _ended(ended_before + 1)
            alive = monotonic() if workers else alive
            if monotonic() - alive > WORKERS_S:
                raise self._lost("all workers of the Dask scheduler at {} are gone; start some and this again")
        future.cancel()
        return _NoResult(f"no result after {TASK_S:g} s")

    def _lost(self, reason: str) -> WorkersError:
        return WorkersError(reason.format(self._address))


def _failed(error: BaseException, ended_before: int) -> _NoResult:
    from distributed import KilledWorker  # noqa: PLC0415  # an extra

    if isinstance(error, KilledWorker):
        return _ended(ended_before + error.allowed_failures + 1)
    return _NoResult(f"a worker failed with {type(error).__name__}: {error}")


def _ended(workers: int) -> _NoResult:
    return _NoResult(f"{workers} workers ended while they had it", workers)


def _threads(client: "Client") -> dict[str, int]:
    """Threads of each worker, by its address, as the scheduler has told last."""
    workers = client.scheduler_info(n_workers=-1)["workers"]
    return {address: int(worker["nthreads"]) for address, worker in workers.items()}
