"""The work of ``attest-mav replay`` on several logs at once: in processes of this machine, or on a cluster."""

import os
import platform
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from attest_mav.cli.collector import seldom_collected
from attest_mav.cli.progress import ProgressBar
from attest_mav.cli.replay_tables import Tables, drop, part_of, parts_folder
from attest_mav.cli.version import version_text
from attest_mav.errors import AttestMavError, UnreadableDataError
from attest_mav.replay.batch import Outcome, Report, replay_file, replay_files
from attest_mav.replay.request import Outputs, Request
from attest_mav.runtime.files import open_log

if TYPE_CHECKING:
    from attest_mav.runtime.processes import TaskMap

Helped = tuple[Report | None, AttestMavError | None]
"""The outcome of one log in a form that pickle takes."""


@dataclass(frozen=True)
class Task:
    """The work of a helping process on one log. folder: where a relative path begins. part: of the tables, or ""."""

    path: str
    folder: str
    part: str = ""
    kinds: tuple[bool, bool] = (False, False)


@dataclass(frozen=True)
class Parts:
    """Tables that helping processes write in parts, and the folder of the parts."""

    tables: Tables
    folder: str

    def of(self, task: Task, number: int) -> Task:
        """The task with its part of the tables."""
        return replace(task, part=str(Path(self.folder, str(number)).absolute()), kinds=self.tables.kinds)


@contextmanager
def opened_parts(tables: Tables | None, csv_path: str | None, parquet_path: str | None) -> Iterator[Parts | None]:
    """Parts of the tables, in a folder beside these; None where there are no tables."""
    if tables is None:
        yield None
        return
    with parts_folder(csv_path, parquet_path) as folder:
        yield Parts(tables, folder)


def replay_spread(
    logs: list[str], request: Request, workers: int | None, parts: Parts | None = None
) -> Iterator[Outcome]:
    """The outcome of every log in order, made by several processes (None: one a core)."""
    from attest_mav.runtime.processes import processes  # noqa: PLC0415 - with it comes multiprocessing

    count = min(workers or os.cpu_count() or 1, len(logs))
    return _replay_over(processes(count, _given_up), logs, request, parts)


def replay_on_cluster(logs: list[str], request: Request, address: str, parts: Parts | None = None) -> Iterator[Outcome]:
    """The outcome of every log in order, made by the workers of a Dask cluster, which see our files where we do."""
    from attest_mav.runtime.cluster import cluster  # noqa: PLC0415 - Dask is an extra

    if not logs:
        return iter(())
    log = next((path for path in logs if Path(path).exists()), None)
    seen = [str(Path(path).absolute()) for path in (log, None if parts is None else parts.folder) if path is not None]
    return _replay_over(cluster(address, partial(described, seen), _given_up, _remark), logs, request, parts)


def _replay_over(
    opened: "AbstractContextManager[TaskMap]", logs: list[str], request: Request, parts: Parts | None = None
) -> Iterator[Outcome]:
    """The outcome of every log in order, made by a map over processes or workers."""
    tasks = [Task(path, str(Path.cwd())) for path in logs]
    if parts is not None:
        tasks = [parts.of(task, number) for number, task in enumerate(tasks)]
    with opened as task_map, ProgressBar(f"{len(logs)} logs") as bar:
        helped = task_map(partial(_replayed, request=request), tasks)
        for done, (task, (report, error)) in enumerate(zip(tasks, helped, strict=True), 1):
            bar.show(done / len(logs))
            if parts is not None:
                parts.tables.append(task.part, is_whole=report is not None)
            yield Outcome(task.path, report, error)


def _replayed(task: Task, request: Request) -> Helped:
    """The outcome of one log in a helping process."""

    def replay_one(path: str) -> Report:
        open_there = partial(open_log, folder=task.folder)
        if not task.part:
            return replay_file(path, request, open_there)
        with part_of(task.part, task.kinds) as tables:
            return replay_file(path, request, open_there, Outputs(observer=tables.rows_of(path)))

    with seldom_collected():
        (outcome,) = replay_files([task.path], replay_one)
    return outcome.report, outcome.error


def described(seen: Sequence[str]) -> str:
    """The program and Python of this process; UnreadableDataError unless log and folder are in their place here too."""
    for path in seen:
        if not Path(path).exists():
            raise UnreadableDataError(
                f"it has no {path}; expected the logs and the folder of a table under the same paths on each worker"
            )
    return f"{version_text()}, Python {platform.python_version()}"


def _given_up(task: Task, reason: str) -> Helped:
    """The outcome of a log that no process has replayed; the rows that one may have written are dropped."""
    if task.part:
        drop(task.part)
    return None, UnreadableDataError(f"{task.path}: given up: {reason}")


def _remark(text: str) -> None:
    click.echo(f"attest-mav: {text}", err=True)
