"""The work of ``attest-mav replay`` on its logs in this process, and the outcomes of all, shown in order."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Final

import click

from attest_mav.cli.calibration_file import CalibrationOutput
from attest_mav.cli.progress import ProgressBar
from attest_mav.errors import UnreadableDataError
from attest_mav.replay.batch import Outcome, Report, replay_file, replay_files
from attest_mav.replay.limits import Checked, Limit, LogResult, check
from attest_mav.replay.observer import FlightObserver, ObserverTee
from attest_mav.replay.request import Outputs, Request
from attest_mav.runtime.files import atomic_write, check_writable, open_log

if TYPE_CHECKING:
    from attest_mav.cli.replay_tables import Tables
    from attest_mav.cli.report_page import ReportPage
    from attest_mav.runtime.results import Results

MANY = 8
"""Of more logs than this the summary is printed alone."""


class Work:
    """The work on each log of a command: with a progress bar, and with the files that are written beside the report."""

    def __init__(
        self,
        request: Request,
        tables: "Tables | None",
        annotated: IO[bytes] | None,
        page: "ReportPage | None",
        calibration: CalibrationOutput | None,
    ) -> None:
        self.request: Final = request
        self.tables: Final = tables
        self.annotated: Final = annotated
        self.page: Final = page
        self.calibration: Final = calibration

    def __call__(self, path: str) -> Report:
        """Replay one log in this process."""
        observers: list[FlightObserver] = [] if self.page is None else [self.page.recorder]
        if self.tables is not None:
            observers.append(self.tables.rows_of(path))
        with ProgressBar(path) as bar:
            observer = ObserverTee(observers) if observers else None
            learned = None if self.calibration is None else self.calibration.take
            outputs = Outputs(None, self.annotated, bar.show, observer, learned)
            report = replay_file(path, self.request, open_log, outputs)
        if self.page is not None:
            self.page.write(report)
        return report


class Showing:
    """The way in which outcomes are shown, the limits that are held against them, and the sum of them all.

    is_brief: the summary in the end is all that is shown.
    """

    def __init__(self, limits: tuple[Limit, ...], json_lines: bool, is_brief: bool) -> None:
        self.limits: Final = limits
        self.json_lines: Final = json_lines
        self.is_brief: Final = is_brief
        self.exit_code = 0
        """That of the last log that could not be read, else 1 if a limit was missed."""
        self.results: Final[list[LogResult]] = []
        self.outcomes: Final[list[Outcome]] = []

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
        from attest_mav.cli.summary_table import print_summary  # noqa: PLC0415 - of several logs only
        from attest_mav.replay.summary import summary_of  # noqa: PLC0415

        print_summary(summary_of(self.outcomes))

    @property
    def nothing_was_read(self) -> bool:
        """Whether no log could be read."""
        return all(one.error for one in self.results)

    def _show(self, report: Report, checked: list[Checked]) -> None:
        if self.json_lines:
            import json  # noqa: PLC0415 - for --json only

            click.echo(json.dumps({**report, "limits": [one.as_json() for one in checked]}, allow_nan=False))
            return
        if not self.is_brief:
            from attest_mav.cli.replay_table import print_report  # noqa: PLC0415 - for people only

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


Replayed = Callable[[list[str]], Iterator[Outcome]]
"""Replays logs, in order."""


def resumed(logs: list[str], results: "Results", replayed: Replayed) -> Iterator[Outcome]:
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
    """Write the results in the end, where a path is given; also if no log could be read.

    UnwritableError at the begin where they cannot be written.
    """
    if path is not None:
        check_writable(path)
    try:
        yield
    finally:
        if path is not None and results:
            from attest_mav.replay.junit import junit_xml  # noqa: PLC0415 - for --junit only

            with atomic_write(path) as file:
                file.write(junit_xml(results))


@contextmanager
def report_file(path: str) -> Iterator["ReportPage"]:
    """A page in a file that appears when it is written."""
    from attest_mav.cli.report_page import ReportPage  # noqa: PLC0415 (costs 60 ms)

    with atomic_write(path) as file:
        yield ReportPage(file)
