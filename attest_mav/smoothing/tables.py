"""Tables that do not fit into memory: rows of one kind in a scratch file, read and written a run of rows at a time.

Everything of a flight that has a row for each reading or each node is kept in one. Below ``runtime`` nothing opens a
file, so whoever smooths gives the files; without any the tables stay in memory.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from io import BytesIO
from types import TracebackType
from typing import Any, Final, Protocol, Self

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.void]
"""Rows of a table, a record each."""
RUN: Final = 8192
"""Rows that are read at a time where a whole table is gone through."""
PENDING_BYTES: Final = 1 << 18
"""Appended rows are written when there are so many bytes of them."""


class ScratchFile(Protocol):
    """The part of a binary file that a table needs. Its errors are those of ``attest_mav.errors``."""

    def seek(self, offset: int, /) -> int:
        """Go to a byte."""

    def read(self, size: int, /) -> bytes:
        """The next bytes."""

    def write(self, data: bytes, /) -> int:
        """Put all these bytes here."""

    def close(self) -> None:
        """Delete it."""


class Table:
    """Rows of one kind, numbered from 0."""

    def __init__(self, kind: "np.dtype[np.void]", file: ScratchFile) -> None:
        self._kind: Final = kind
        self._file: Final = file
        self._pending = bytearray()
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, row: bytes) -> None:
        """Append the bytes of a row, or of several."""
        self._pending += row
        self._count += len(row) // self._kind.itemsize
        if len(self._pending) >= PENDING_BYTES:
            self._settle()

    def write(self, first: int, rows: Rows) -> None:
        """Put rows in the place of those from ``first`` on, or behind the last one."""
        self._settle()
        self._put(first, rows.tobytes())
        self._count = max(self._count, first + len(rows))

    def rows(self, first: int, end: int) -> Rows:
        """The rows from ``first`` to ``end`` - 1."""
        self._settle()
        self._file.seek(first * self._kind.itemsize)
        return np.frombuffer(self._file.read((end - first) * self._kind.itemsize), self._kind)

    def runs(self) -> Iterator[tuple[int, int]]:
        """First row and end of runs of rows that go through the whole table."""
        for first in range(0, self._count, RUN):
            yield first, min(first + RUN, self._count)

    def column(self, name: str) -> Iterator[NDArray[Any]]:
        """A column of the whole table, run by run."""
        for first, end in self.runs():
            yield self.rows(first, end)[name]

    def place(self, time_s: float, lag_s: float, *, behind_equal: bool) -> int:
        """The number of rows whose ``t_s`` less a lag is earlier than a time, or equal to it, in a table by time, s."""
        search = bisect_right if behind_equal else bisect_left
        return search(range(self._count), time_s, key=lambda row: float(self.rows(row, row + 1)["t_s"][0]) - lag_s)

    def _settle(self) -> None:
        """Write the appended rows."""
        if self._pending:
            self._put(self._count - len(self._pending) // self._kind.itemsize, bytes(self._pending))
            self._pending.clear()

    def _put(self, first: int, data: bytes) -> None:
        self._file.seek(first * self._kind.itemsize)
        self._file.write(data)


class Scratch:
    """The tables of one flight, which end together."""

    def __init__(self, open_file: Callable[[], ScratchFile] = BytesIO) -> None:
        """open_file: gives a new empty file."""
        self._open: Final = open_file
        self._files: Final = ExitStack()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._files.close()

    def table(self, kind: "np.dtype[np.void]") -> Table:
        """A new table."""
        file = self._open()
        self._files.callback(file.close)
        return Table(kind, file)
