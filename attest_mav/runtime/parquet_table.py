"""Compared attitudes as a Parquet file: typed columns with units, written in groups of rows at constant memory.

Needs pyarrow, which is imported here alone. The groups of one log do not depend on the logs before it.
"""

from importlib.util import find_spec
from typing import IO, Any, Final

from attest_mav.errors import UsageError
from attest_mav.replay.columns import COLUMNS, Column, Kind, Row

GROUP_ROWS: Final = 4096
"""Rows of a group, which are in memory together."""


class ParquetTable:
    """One table for the attitudes of several logs. UsageError without pyarrow."""

    def __init__(self, file: IO[bytes], group_rows: int | None = None) -> None:
        if find_spec("pyarrow") is None:
            raise UsageError("--parquet needs pyarrow: install the extra parquet: pip install 'attest-mav[parquet]'")
        import pyarrow as pa  # noqa: PLC0415  # an extra
        from pyarrow import parquet  # noqa: PLC0415  # an extra

        self._pa: Final = pa
        self._parquet: Final = parquet
        self._schema: Final = pa.schema([_field(pa, one) for one in COLUMNS])
        self._writer: Final = parquet.ParquetWriter(file, self._schema)
        self._group_rows: Final = group_rows or GROUP_ROWS
        self._rows: list[Row] = []

    def write(self, row: Row) -> None:
        """Take one row."""
        self._rows.append(row)
        if len(self._rows) >= self._group_rows:
            self.end_group()

    def end_group(self) -> None:
        """Write the rows that wait, at the end of a log."""
        if not self._rows:
            return
        columns = zip(COLUMNS, zip(*self._rows, strict=True), strict=True)
        arrays = [self._pa.array(_typed(one, values), type=_type(self._pa, one)) for one, values in columns]
        self._writer.write_batch(self._pa.RecordBatch.from_arrays(arrays, schema=self._schema))
        self._rows = []

    def append(self, part: str) -> None:
        """Take the groups of another file of this class."""
        self.end_group()
        with self._parquet.ParquetFile(part) as file:
            for group in range(file.num_row_groups):
                self._writer.write_table(file.read_row_group(group), row_group_size=self._group_rows)

    def close(self) -> None:
        """Write the rest and the index of the file."""
        self.end_group()
        self._writer.close()


def _field(pa: Any, column: Column) -> Any:
    metadata = {"unit": column.unit} if column.unit else None
    return pa.field(column.name, _type(pa, column), metadata=metadata)


def _type(pa: Any, column: Column) -> Any:
    types = {Kind.TEXT: pa.string(), Kind.REAL: pa.float64(), Kind.FLAG: pa.bool_()}
    return types[column.kind]


def _typed(column: Column, values: tuple[Any, ...]) -> list[Any]:
    """The values of a column; bytes of a name that are no text become question marks."""
    if column.kind == Kind.FLAG:
        return [bool(value) for value in values]
    if column.name == "log":
        return [value.encode(errors="replace").decode() for value in values]
    return list(values)
