"""The wanted columns of one type of record: taken out of its bytes, or out of a line of text, as numbers in SI."""

from collections.abc import Sequence
from math import nan
from struct import Struct
from typing import Any, Final

from mypy_extensions import i64

from attest_mav.logs.dataflash.record_format import CODES, HEADER_BYTES, RecordFormat, text_of
from attest_mav.logs.dataflash.units import Column, UnitTable

MICRO_NS: Final = 1e3
MILLI_NS: Final = 1e6
FLOATS: Final = "fdg"
"""Letters of columns that hold floating-point numbers."""
UNSIGNED: Final = ("Q", "I")
"""Letters of columns that hold a time in all known logs."""


def time_column(record_format: RecordFormat) -> tuple[int, float]:
    """The column with the time since boot, and one unit of it in ns; (-1, 0) for a record without.

    Firmware before 3.3 gives milliseconds. Its GPS record has the time of the week there, and that since boot in T;
    before 3.1 the time of the week, called Time, is the only time in a log.
    """
    if record_format.index("TimeUS") >= 0:
        return record_format.index("TimeUS"), MICRO_NS
    names = ("T", "Time") if record_format.name.startswith("GPS") else ("TimeMS",)
    index = next((record_format.index(name) for name in names if record_format.index(name) >= 0), -1)
    return (index, MILLI_NS) if index >= 0 else (-1, 0.0)


class Selection:
    """Numbers and texts of a record, in the order of ``columns`` and ``texts``, with the time before the numbers."""

    def __init__(
        self, record_format: RecordFormat, columns: Sequence[Column], texts: Sequence[str], units: UnitTable
    ) -> None:
        time_at, unit_ns = time_column(record_format)
        places = [time_at, *[record_format.index(column.name) for column in columns]]
        factors = [unit_ns, *[_factor(record_format, column, units) for column in columns]]
        is_number = [at >= 0 and not CODES[record_format.codes[at]].is_text for at in places]
        self._places: Final = [at if fits else -1 for at, fits in zip(places, is_number, strict=True)]
        self._factors: Final[list[Any]] = list(factors)  # as objects: compiled, floats would be made anew each time
        self._last: Final = len(record_format.columns) - 1
        self._texts: Final = [record_format.index(name) for name in texts]
        self._line_factors: Final = [
            factor / CODES[record_format.codes[at]].scale if at >= 0 else 1.0
            for at, factor in zip(self._places, factors, strict=True)
        ]
        wanted = sorted({at for at in [*self._places, *self._texts] if at >= 0})
        self._unpack: Final = _struct(record_format, wanted).unpack_from
        self._time_at: Final[i64] = record_format.offsets[time_at] if time_at >= 0 else 0
        code = record_format.codes[time_at] if time_at >= 0 else ""
        self._time_bytes: Final[i64] = CODES[code].size if code in UNSIGNED else 0
        self._unit_ns: Final = unit_ns
        self._numbers_at: Final = [wanted.index(at) if at >= 0 else -1 for at in self._places]
        self._texts_at: Final = [wanted.index(at) if at >= 0 else -1 for at in self._texts]
        self._is_plain: Final = self._numbers_at == list(range(len(wanted))) and all(
            factor == 1.0 and record_format.codes[at] in FLOATS
            for at, factor in zip(self._places[1:], factors[1:], strict=True)
        )
        """Whether the record holds the numbers as they are wanted, but for the unit of the time."""
        missing = self._numbers_at.count(-1)
        self._missing: Final = [nan] * missing
        self._in_order: Final = self._numbers_at == [*range(len(wanted)), *[-1] * missing]
        """Whether it holds them in the wanted order, those that it lacks being the last."""

    def numbers(self, data: bytes, at: int) -> list[float]:
        """The numbers of the record that begins at ``at``; NaN for one that it lacks."""
        raw: tuple[Any, ...] = self._unpack(data, at + HEADER_BYTES)
        factors = self._factors
        if self._is_plain:
            numbers = list(raw)
            numbers[0] = raw[0] * factors[0]
            return numbers
        if self._in_order:
            found = [value * factors[index] for index, value in enumerate(raw)]
            found += self._missing
            return found
        return [raw[place] * factors[index] if place >= 0 else nan for index, place in enumerate(self._numbers_at)]

    def time_ns(self, data: bytes, at: int) -> float:
        """The time of the record that begins at ``at``, ns; NaN for one without."""
        if self._time_bytes == 0:
            return self.numbers(data, at)[0]
        return float(_whole_at(data, at + self._time_at, self._time_bytes)) * self._unit_ns

    def texts(self, data: bytes, at: int) -> list[str]:
        """The texts of the record that begins at ``at``; "" for one that it lacks."""
        raw = self._unpack(data, at + HEADER_BYTES)
        return [text_of(raw[place]) if place >= 0 and isinstance(raw[place], bytes) else "" for place in self._texts_at]

    def line_numbers(self, fields: Sequence[str]) -> list[float]:
        """The same from a line of text, whose numbers are scaled already by their letters."""
        values = zip(self._places, self._line_factors, strict=True)
        return [_number(fields[at]) * factor if 0 <= at < len(fields) else nan for at, factor in values]

    def line_texts(self, fields: Sequence[str]) -> list[str]:
        """The texts of a line; the last column takes the rest of it, commas and all."""
        last = self._last
        return [", ".join(fields[at : None if at == last else at + 1]) if at >= 0 else "" for at in self._texts]


def _factor(record_format: RecordFormat, column: Column, units: UnitTable) -> float:
    index = record_format.index(column.name)
    return units.factor(record_format, index, column) if index >= 0 else 1.0


def _struct(record_format: RecordFormat, wanted: Sequence[int]) -> Struct:
    """The layout of the wanted columns behind the header, with gaps in the place of all others."""
    layout = "<"
    end = HEADER_BYTES
    for index in wanted:
        code = CODES[record_format.codes[index]]
        layout += f"{record_format.offsets[index] - end}x{code.kind}"
        end = record_format.offsets[index] + code.size
    return Struct(layout)


def _whole_at(data: bytes, at: i64, size: i64) -> i64:
    """The whole number of so many bytes that stands there: compiled, quicker than the call of a ``Struct``."""
    value: i64 = 0
    place = at + size
    while place > at:
        place -= 1
        value = (value << 8) | data[place]
    return value


def _number(text: str) -> float:
    """The number that a text begins with; NaN for none."""
    try:
        return float(text)
    except ValueError:
        return nan
