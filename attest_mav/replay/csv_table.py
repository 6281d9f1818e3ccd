"""Compared attitudes as comma-separated values, one row each."""

import csv
from typing import Final, Protocol

from attest_mav.replay.columns import COLUMNS, Kind, Row, Value


class TextSink(Protocol):
    """Takes text, for example a file object."""

    def write(self, text: str, /) -> object:
        """Take more text."""


class CsvTable:
    """One table for the attitudes of several logs. Fields without a value are empty.

    has_header: False for a part that is appended to a table.
    """

    def __init__(self, sink: TextSink, has_header: bool = True) -> None:
        self._csv: Final = csv.writer(sink, lineterminator="\n")
        self._formats: Final = [f".{one.decimals}f" if one.kind == Kind.REAL else "" for one in COLUMNS]
        if has_header:
            self._csv.writerow([one.name for one in COLUMNS])

    def write(self, row: Row) -> None:
        """Write one row."""
        formats = self._formats
        self._csv.writerow([_text(value, formats[index]) for index, value in enumerate(row)])


def _text(value: Value, form: str) -> str:
    return "" if value is None else format(value, form)
