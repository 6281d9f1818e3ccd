"""A progress bar for work that turns out to be long."""

import sys
from time import monotonic
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

if TYPE_CHECKING:
    from rich.progress import Progress

QUIET_S: Final = 1.0
"""Work that is over by then shows none, and does not pay for the import."""


class ProgressBar:
    """Shows the share of the work done on standard error, where that is a terminal; elsewhere nothing."""

    def __init__(self, title: str) -> None:
        self._title: Final = title
        self._is_shown: Final = sys.stderr.isatty()
        self._since: Final = monotonic()
        self._bar: Progress | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def show(self, share: float) -> None:
        """So much is done, 0 to 1."""
        if not self._is_shown or monotonic() - self._since < QUIET_S:
            return
        if self._bar is None:
            self._bar = self._open()
        self._bar.update(self._bar.task_ids[0], completed=share)

    def _open(self) -> "Progress":
        from rich.console import Console  # noqa: PLC0415  (imported when shown)
        from rich.progress import Progress  # noqa: PLC0415

        bar = Progress(console=Console(stderr=True, markup=False), transient=True)
        bar.add_task(self._title, total=1.0)
        bar.start()
        return bar
