"""The units of columns: as the log tells them (UNIT, MULT and FMTU), else as they always were.

FMTU gives each column of a type a letter for its unit and one for its multiplier; UNIT and MULT explain the letters. A
multiplier is that of the number as it is stored: for a column of the letter c it is the hundredth that the letter
means anyway. Logs before 2018 have none of these records.
"""

from math import isfinite, pi
from typing import Final

from attest_mav.logs.dataflash.record_format import CODES, RecordFormat

DEGREE: Final = pi / 180.0
IN_SI: Final = {
    "rad": 1.0,
    "rad/s": 1.0,
    "deg": DEGREE,
    "degheading": DEGREE,
    "deg/s": DEGREE,
    "m": 1.0,
    "m/s": 1.0,
    "m/s/s": 1.0,
    "Gauss": 1.0,
    "mGauss": 1e-3,
    "deglatitude": 1.0,
    "deglongitude": 1.0,
}
"""Units by ArduPilot's labels, in those of ``types``; latitude and longitude stay in degrees."""


class Column:
    """A column that a reader wants.

    unit: its label in ``IN_SI`` where the log does not tell it, behind the letter's own scale; "" for a plain number,
    which stays as it is. per: the unit that the reader wants it in, in SI.
    """

    def __init__(self, name: str, unit: str = "", per: float = 1.0) -> None:
        self.name: Final = name
        self.unit: Final = unit
        self.per: Final = per


class UnitTable:
    """The units that a log tells."""

    def __init__(self) -> None:
        self._units: Final[dict[str, str]] = {}
        self._multipliers: Final[dict[str, float]] = {}
        self._columns: Final[dict[str, tuple[str, str]]] = {}
        self._names: Final[dict[int, str]] = {}

    def learn_unit(self, letter: float, label: str) -> None:
        """Take a UNIT record."""
        self._units[_letter(letter)] = label

    def learn_multiplier(self, letter: float, multiplier: float) -> None:
        """Take a MULT record."""
        self._multipliers[_letter(letter)] = multiplier

    def learn_name(self, record_type: int, name: str) -> None:
        """Take the name of a type of record."""
        self._names[record_type] = name

    def learn_columns(self, record_type: float, units: str, multipliers: str) -> None:
        """Take an FMTU record: one letter a column, for the records of this type."""
        name = self._names.get(int(record_type)) if isfinite(record_type) else None
        if name is not None:
            self._columns[name] = (units, multipliers)

    def factor(self, record_format: RecordFormat, index: int, column: Column) -> float:
        """By which the stored number of a column is multiplied."""
        scale = CODES[record_format.codes[index]].scale
        if not column.unit:
            return scale
        told = self._told(record_format.name, index)
        return (scale * IN_SI[column.unit] if told is None else told) / column.per

    def _told(self, record: str, index: int) -> float | None:
        """The factor to SI as the log tells it; None where it does not, or not for a unit of the table."""
        units, multipliers = self._columns.get(record, ("", ""))
        if index >= len(units) or index >= len(multipliers):
            return None
        in_si = IN_SI.get(self._units.get(units[index], ""))
        multiplier = self._multipliers.get(multipliers[index], 0.0)
        return None if in_si is None or multiplier == 0.0 else multiplier * in_si


def _letter(code: float) -> str:
    """The letter with this number."""
    return chr(int(code)) if isfinite(code) and 0 <= code < 128 else ""
