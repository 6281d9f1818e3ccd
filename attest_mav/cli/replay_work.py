"""The work of ``attest-mav replay`` on its logs: one after the other or in several processes, shown in order."""

import json
import os
import platform
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING

import click

from attest_mav.cli.collector import seldom_collected
from attest_mav.cli.progress import ProgressBar
from attest_mav.cli.replay_tables import Tables, drop, part_of
from attest_mav.cli.version import version_text
from attest_mav.errors import AttestMavError, UnreadableDataError
from attest_mav.replay.batch import Outcome, Report, replay_file, replay_files
from attest_mav.replay.junit import LogResult, junit_xml
from attest_mav.replay.limits import Checked, Limit, check
from attest_mav.replay.observer import FlightObserver, ObserverTee
from attest_mav.replay.request import Outputs, Request
from attest_mav.replay.summary import summary_of
from attest_mav.runtime.files import atomic_write, open_log
from attest_mav.runtime.results import Results

if TYPE_CHECKING:
    from attest_mav.cli.report_page import ReportPage
    from attest_mav.runtime.processes import TaskMap

MANY = 8
"""Of more logs than this the summary is printed alone."""


@dataclass(frozen=True)
class Work:
    """The work on each log of a command: with a progress bar, and with the files that are written beside the report."""

    request: Request
    tables: Tables | None = None
    annotated: IO[bytes] | None = None
    page: "ReportPage | None" = None

    def __call__(self, path: str) -> Report:
        """Replay one log in this process."""
        observers: list[FlightObserver] = [] if self.page is None else [self.page.recorder]
        if self.tables is not None:
            observers.append(self.tables.rows_of(path))
        with ProgressBar(path) as bar:
            outputs = Outputs(None, self.annotated, bar.show, ObserverTee(observers) if observers else None)
            report = replay_file(path, self.request, open_log, outputs)
        if self.page is not None:
            self.page.write(report)
        return report


@dataclass
class Showing:
    """The way in which outcomes are shown, the limits that are held against them, and the sum of them all.

    is_brief: the summary in the end is all that is shown.
    """

    limits: tuple[Limit, ...]
    json_lines: bool
    is_brief: bool
    exit_code: int = 0
    """That of the last log that could not be read, else 1 if a limit was missed."""
    results: list[LogResult] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)

    def take(self, outcome: Outcome) -> None:
        """Show one outcome."""
        self.outcomes.append(outcome)
        if outcome.error is not None:
            click.echo(f"attest-mav: error: {outcome.error}", err=True)
            self.exit_code = outcome.error.exit_code
            self.results.append(LogResult(outcome.path, error=str(outcome.error)))
        elif outcome.report is not None:
            checked = check(outcome.report, self.limits)
            self.results.append(LogResult(outcome.path, checked))
            self.exit_code = self.exit_code or int(any(not one.passes for one in checked))
            self._show(outcome.report, checked)

    def finish(self) -> None:
        """Print the summary of several logs."""
        if len(self.outcomes) < 2 or self.json_lines:
            return
        from attest_mav.cli.summary_table import print_summary  # noqa: PLC0415 (costs 100 ms)

        print_summary(summary_of(self.outcomes))

    @property
    def nothing_was_read(self) -> bool:
        """Whether no log could be read."""
        return all(one.error for one in self.results)

    def _show(self, report: Report, checked: list[Checked]) -> None:
        if self.json_lines:
            click.echo(json.dumps({**report, "limits": [one.as_json() for one in checked]}, allow_nan=False))
            return
        if not self.is_brief:
            # Costs 100 ms, which a script that reads JSON does not need.
            from attest_mav.cli.replay_table import print_report  # noqa: PLC0415

            print_report(report)
        for one in checked:
            if not (self.is_brief and one.passes):
                where = f"{click.format_filename(report['log'])}: " if self.is_brief else ""
                click.echo(f"  {where}limit {'kept  ' if one.passes else 'MISSED'} {one}")


def replay_here(logs: list[str], work: Work) -> Iterator[Outcome]:
    """The outcome of every log, one after the other."""
    for outcome in replay_files(logs, work):
        if work.tables is not None:
            work.tables.end_log()
        yield outcome


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


Replayed = Callable[[list[str]], Iterator[Outcome]]
"""Replays logs, in order."""


def resumed(logs: list[str], results: Results, replayed: Replayed) -> Iterator[Outcome]:
    """The outcomes that are kept, and those of the other logs, which are kept too; in order of the logs."""
    kept = {path: known for path in logs if (known := results.known(path)) is not None}
    fresh = replayed([path for path in logs if path not in kept])
    for path in logs:
        if path in kept:
            yield _kept(path, kept[path])
            continue
        outcome = next(fresh)
        error = None if outcome.error is None else str(outcome.error)
        results.add(path, {"report": outcome.report, "error": error})
        yield outcome


def _kept(path: str, result: Report) -> Outcome:
    if result["error"] is not None:
        return Outcome(path, None, UnreadableDataError(result["error"]))
    return Outcome(path, result["report"], None)


@contextmanager
def junit_file(path: str | None, results: list[LogResult]) -> Iterator[None]:
    """Write the results in the end, where a path is given; also if no log could be read."""
    try:
        yield
    finally:
        if path is not None and results:
            with atomic_write(path) as file:
                file.write(junit_xml(results))


@contextmanager
def report_file(path: str) -> Iterator["ReportPage"]:
    """A page in a file that appears when it is written."""
    from attest_mav.cli.report_page import ReportPage  # noqa: PLC0415 (costs 60 ms)

    with atomic_write(path) as file:
        yield ReportPage(file)
