"""The tables of a replay, CSV and Parquet: written here, or put together of parts that helping processes write."""

import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from shutil import copyfileobj
from typing import IO, TYPE_CHECKING, Final

from attest_mav.errors import UnwritableError
from attest_mav.replay.csv_table import CsvTable
from attest_mav.replay.table_rows import RowSink, TableRows
from attest_mav.runtime.files import atomic_write

if TYPE_CHECKING:
    from attest_mav.runtime.parquet_table import ParquetTable


class EncodedText:
    """Writes text to a file of bytes. The name of a log need not be text; its bytes come out as they are."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file: Final = file

    def write(self, text: str, /) -> None:
        """Write it in UTF-8."""
        self._file.write(text.encode(errors="surrogateescape"))


class Tables:
    """The tables that are wanted, None for others; a part has no header."""

    def __init__(self, csv: IO[bytes] | None, parquet: "ParquetTable | None", is_part: bool = False) -> None:
        self._csv_file: Final = csv
        self._parquet: Final = parquet
        self._sinks: Final[list[RowSink]] = [] if csv is None else [CsvTable(EncodedText(csv), not is_part)]
        if parquet is not None:
            self._sinks.append(parquet)

    def rows_of(self, log: str) -> TableRows:
        """Whoever writes the rows of the log of that name."""
        return TableRows(log, self._sinks)

    def end_log(self) -> None:
        """All rows of a log are written."""
        if self._parquet is not None:
            self._parquet.end_group()

    def append(self, part: str, is_whole: bool) -> None:
        """Take the rows of a part, and remove it.

        is_whole: the log was replayed, so that there must be a part; one that could not be opened has none.
        """
        csv, parquet = _part_paths(part)
        for path, is_wanted in zip((csv, parquet), self.kinds, strict=True):
            if is_whole and is_wanted and not path.exists():
                raise UnwritableError(f"the worker's rows did not come: no {path}; expected a folder that both see")
        if self._csv_file is not None and csv.exists():
            with csv.open("rb") as file:
                copyfileobj(file, self._csv_file)
            csv.unlink()
        if self._parquet is not None and parquet.exists():
            self._parquet.append(str(parquet))
            parquet.unlink()

    @property
    def kinds(self) -> tuple[bool, bool]:
        """Whether there is a CSV and a Parquet file."""
        return self._csv_file is not None, self._parquet is not None


@contextmanager
def tables(csv_path: str | None, parquet_path: str | None) -> Iterator[Tables | None]:
    """Tables in files that appear when all of their rows are written; None where none is wanted."""
    if csv_path is None and parquet_path is None:
        yield None
        return
    with ExitStack() as stack:
        csv = None if csv_path is None else stack.enter_context(atomic_write(csv_path))
        parquet = None if parquet_path is None else _parquet(stack.enter_context(atomic_write(parquet_path)))
        yield Tables(csv, parquet)
        if parquet is not None:
            parquet.close()


@contextmanager
def part_of(part: str, kinds: tuple[bool, bool]) -> Iterator[Tables]:
    """The tables of one log, in files of their own that another process appends to its tables."""
    with ExitStack() as stack:
        csv, parquet = _part_paths(part)
        files = [
            stack.enter_context(path.open("wb")) if is_wanted else None
            for path, is_wanted in zip((csv, parquet), kinds, strict=True)
        ]
        table = None if files[1] is None else _parquet(files[1])
        try:
            yield Tables(files[0], table, is_part=True)
        finally:
            if table is not None:
                table.close()


@contextmanager
def parts_folder(csv_path: str | None, parquet_path: str | None) -> Iterator[str]:
    """A folder for parts, beside the tables, where there is room for them; gone at the end."""
    target = Path(csv_path or parquet_path or ".")
    beside = None if target.exists() and not target.is_file() else target.parent
    with tempfile.TemporaryDirectory(dir=beside, prefix=".attest-mav-parts.") as folder:
        yield folder


def drop(part: str) -> None:
    """Remove a part that is not whole."""
    for path in _part_paths(part):
        path.unlink(missing_ok=True)


def _part_paths(part: str) -> tuple[Path, Path]:
    return Path(f"{part}.csv"), Path(f"{part}.parquet")


def _parquet(file: IO[bytes]) -> "ParquetTable":
    from attest_mav.runtime.parquet_table import ParquetTable  # noqa: PLC0415 - pyarrow is an extra

    return ParquetTable(file)
