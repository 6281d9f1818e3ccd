"""A map over the workers of a Dask cluster, which may be other computers.

The scheduler repeats the task of a worker that has ended on another one. A task on which several workers have ended,
or which gives no result in time, is given up, and the others go on. Dask is imported here alone.
"""

import logging
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from time import monotonic
from typing import TYPE_CHECKING, Any, Final, TypeVar

from attest_mav.errors import ClusterError, UsageError
from attest_mav.runtime.processes import AHEAD, TaskMap

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
GivenUp = Callable[[Any, str], Any]
"""The result of a task that was given up, with the reason for people."""
Probe = Callable[[], str]
"""Names the program of a worker, its version and its Python; an exception says why it cannot do the work."""


@contextmanager
def cluster(address: str, probe: Probe, given_up: GivenUp, say: Callable[[str], None]) -> Iterator[TaskMap]:
    """A map over the workers of the cluster with a scheduler at that address; results in the order of the tasks.

    probe: is called on each worker, and here, and the answers are compared. say: takes remarks for people.
    ClusterError without a scheduler or worker, UsageError without Dask.
    """
    if find_spec("distributed") is None:
        raise UsageError("--dask needs Dask: install the extra cluster, as with pip install 'attest-mav[cluster]'")
    client = _connected(address)
    try:
        _check_workers(client, address, probe, say)
        yield partial(_map, client, address, given_up)
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
        raise ClusterError(
            f"no Dask scheduler at {address}: {reason}; expected HOST:PORT of one that runs (dask scheduler)"
        ) from None


def _check_workers(client: "Client", address: str, probe: Probe, say: Callable[[str], None]) -> None:
    """ClusterError unless a worker can do the work; a remark on each whose program is another one."""
    try:
        client.wait_for_workers(1, timeout=WORKERS_S)
    except TimeoutError:
        raise ClusterError(
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
            raise ClusterError(f"worker {worker} cannot do the work: {error}; expected {ours} there")
        answered += 1
        if (theirs := answer.result()) != ours:
            say(f"worker {worker} has {theirs}; here is {ours}: results may differ")
    if not answered:
        raise ClusterError(f"no worker of the Dask scheduler at {address} has answered; are they at other work?")


def _map(
    client: "Client", address: str, given_up: GivenUp, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Iterator[Result]:
    """The built-in ``map`` over the cluster, with a bounded number of tasks given out ahead of the next result."""
    given: deque[tuple[Task, Future]] = deque()
    for task in tasks:
        given.append((task, client.submit(function, task, pure=False)))
        if len(given) >= AHEAD * max(1, sum(_threads(client).values())):
            yield _result(client, address, given_up, *given.popleft())
    while given:
        yield _result(client, address, given_up, *given.popleft())


def _result(client: "Client", address: str, given_up: GivenUp, task: Task, future: "Future") -> Any:
    """The result of one task, as soon as it is there; ClusterError when the cluster is gone."""
    from distributed import KilledWorker  # noqa: PLC0415  # an extra

    begun = alive = monotonic()
    while monotonic() - begun < TASK_S:
        try:
            error = future.exception(timeout=POLL_S)
            if future.status == "finished":
                return future.result(timeout=POLL_S)
        except TimeoutError:
            error = None
        if isinstance(error, KilledWorker):
            return given_up(task, f"{error.allowed_failures + 1} workers ended while they had it")
        if error is not None:
            return given_up(task, f"a worker failed with {type(error).__name__}: {error}")
        if client.status != "running" or future.cancelled():
            raise ClusterError(f"the Dask scheduler at {address} is gone; --results keeps what is done: start again")
        alive = monotonic() if _threads(client) else alive
        if monotonic() - alive > WORKERS_S:
            raise ClusterError(f"all workers of the Dask scheduler at {address} are gone; start some and this again")
    future.cancel()
    return given_up(task, f"no result after {TASK_S:g} s")


def _threads(client: "Client") -> dict[str, int]:
    """Threads of each worker, by its address, as the scheduler has told last."""
    workers = client.scheduler_info(n_workers=-1)["workers"]
    return {address: int(worker["nthreads"]) for address, worker in workers.items()}
