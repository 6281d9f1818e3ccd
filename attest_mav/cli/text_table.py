"""Tables for people: columns of text under a bold heading and a rule, as wide as the terminal at most.

rich would cost a replay 30 ms, a tenth of the whole.
"""

import os
import sys
from textwrap import fill
from typing import Final

import click

PIPE_COLUMNS: Final = 80
"""Width where there is no terminal to ask."""
LEAST_WIDTH: Final = 8
"""A column of words is not made narrower than this."""


class Column:
    """One column. heading: its lines. is_figure: aligned to the right, and never folded."""

    def __init__(self, heading: str, is_figure: bool = False) -> None:
        self.heading: Final = heading
        self.is_figure: Final = is_figure


def words(heading: str) -> Column:
    """A column of words, folded where the table is too wide."""
    return Column(heading)


def figures(*headings: str) -> list[Column]:
    """Columns of figures."""
    return [Column(heading, is_figure=True) for heading in headings]


class TextTable:
    """Rows of cells under the headings of the columns. caption: a line below them, "" for none."""

    def __init__(self, *columns: Column) -> None:
        self.caption = ""
        self._columns: Final = columns
        self._rows: Final[list[tuple[tuple[str, ...], bool]]] = []

    def add_row(self, *cells: str, dim: bool = False) -> None:
        """Add a row with a cell for each column."""
        self._rows.append((cells, dim))

    def text(self, width: int) -> str:
        """The table in lines of at most ``width`` characters, or as many as the figures need, between empty lines."""
        widths = self._widths(width)
        headings = tuple(column.heading for column in self._columns)
        lines = ["", *(click.style(line, bold=True) for line in self._lines(headings, widths, rise=True))]
        lines.append(f" {'─' * (sum(widths) + 2 * len(widths) - 1)}")
        for cells, dim in self._rows:
            row = self._lines(cells, widths)
            lines += [click.style(line, dim=True) for line in row] if dim else row
        if self.caption:
            lines.append(click.style(f" {self.caption}", dim=True))
        return "\n".join([*lines, "", ""])

    def _widths(self, width: int) -> list[int]:
        """Width of each column; those of words give way where all are too wide together."""
        rows = [tuple(column.heading for column in self._columns), *(cells for cells, _ in self._rows)]
        widths = [max(len(line) for cell in cells for line in cell.split("\n")) for cells in zip(*rows, strict=True)]
        excess = 1 + sum(widths) + 2 * len(widths) - width
        while excess > 0:
            foldable = [k for k, one in enumerate(self._columns) if not one.is_figure and widths[k] > LEAST_WIDTH]
            if not foldable:
                break
            widths[max(foldable, key=widths.__getitem__)] -= 1
            excess -= 1
        return widths

    def _lines(self, cells: tuple[str, ...], widths: list[int], rise: bool = False) -> list[str]:
        """The lines of a row. rise: empty lines stand above short cells, as they do above figures."""
        parts = [_cell_lines(cell, width) for cell, width in zip(cells, widths, strict=True)]
        height = max(len(lines) for lines in parts)
        placed = []
        for lines, column, width in zip(parts, self._columns, widths, strict=True):
            spare = [""] * (height - len(lines))
            whole = [*spare, *lines] if rise or column.is_figure else [*lines, *spare]
            placed.append([line.rjust(width) if column.is_figure else line.ljust(width) for line in whole])
        return [f" {'  '.join(line)}".rstrip() for line in zip(*placed, strict=True)]


def screen_width() -> int:
    """Width of the terminal on standard output, characters; ``PIPE_COLUMNS`` where there is none."""
    try:
        return os.get_terminal_size(sys.stdout.fileno()).columns or PIPE_COLUMNS
    except (OSError, ValueError, AttributeError):  # no terminal, a closed file, or none at all
        return PIPE_COLUMNS


def folded(text: str, width: int, indent: str = "", hanging: str = "") -> str:
    """A text in lines of at most ``width`` characters, each behind the indent. hanging: before all but the first."""
    return fill(text, width, initial_indent=indent, subsequent_indent=indent + hanging, break_on_hyphens=False)


def _cell_lines(cell: str, width: int) -> list[str]:
    """The lines of a cell, none longer than the column is wide."""
    lines = [folded(line, width) if len(line) > width else line for line in cell.split("\n")]
    return "\n".join(lines).split("\n")
