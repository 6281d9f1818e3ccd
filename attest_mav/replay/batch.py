"""Replays of many logs: one log as a unit of work, and all of them whatever happens to one.

A process pool can be given ``partial(replay_file, request=..., open_log=...)``: request and report can be pickled.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from typing import Any, Final

from attest_mav.errors import AttestMavError, UnreadableDataError, UnwritableError
from attest_mav.logs.formats import open_source
from attest_mav.logs.source import LogBytes, NotedBytes
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request

Report = dict[str, Any]
"""The object that ``replay --json`` prints for one log."""

OpenLog = Callable[[str], AbstractContextManager[LogBytes]]
"""Opens the log at a path for the time of a ``with`` block, and gives its bytes."""


class Outcome:
    """The report on one log, or the error that prevented it."""

    def __init__(self, path: str, report: Report | None, error: AttestMavError | None) -> None:
        self.path: Final = path
        self.report: Final = report
        self.error: Final = error


def replay_file(path: str, request: Request, open_log: OpenLog, outputs: Outputs | None = None) -> Report:
    """The report on one log. Every error names the log."""
    with open_log(path) as data:
        notes = list(data.notes) if isinstance(data, NotedBytes) else []
        source = open_source(data, path)
        try:
            report = as_json(path, replay(source, request, outputs or Outputs()))
        except UnreadableDataError as error:
            raise UnreadableDataError("; ".join([f"{path}: {error}", *notes])) from None
    return {**report, "notes": [*notes, *report["notes"]]}


def replay_files(paths: Iterable[str], replay_one: Callable[[str], Report]) -> Iterator[Outcome]:
    """The outcome of each log in order. Only an output that cannot be written ends the work on all of them."""
    for path in paths:
        yield _outcome(path, replay_one)


def _outcome(path: str, replay_one: Callable[[str], Report]) -> Outcome:
    try:
        return Outcome(path, replay_one(path), None)
    except UnwritableError:
        raise
    except AttestMavError as error:
        return Outcome(path, None, error)
