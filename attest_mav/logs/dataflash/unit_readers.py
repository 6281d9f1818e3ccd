"""The readers of the units that a log tells: UNIT, MULT and FMTU. They make no samples."""

from typing import Final

from attest_mav.logs.dataflash.reader import RecordReader
from attest_mav.logs.dataflash.units import Column, UnitTable
from attest_mav.samples import Sample


class UnitReader(RecordReader):
    """UNIT: a letter and its label."""

    def __init__(self, units: UnitTable) -> None:
        super().__init__([Column("Id")], ["Label"])
        self._units: Final = units

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """Learn the unit."""
        self._units.learn_unit(numbers[1], texts[0])
        return []


class MultiplierReader(RecordReader):
    """MULT: a letter and its multiplier."""

    def __init__(self, units: UnitTable) -> None:
        super().__init__([Column("Id"), Column("Mult")])
        self._units: Final = units

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """Learn the multiplier."""
        self._units.learn_multiplier(numbers[1], numbers[2])
        return []


class ColumnUnitsReader(RecordReader):
    """FMTU: the letters of the columns of one type of record."""

    def __init__(self, units: UnitTable) -> None:
        super().__init__([Column("FmtType")], ["UnitIds", "MultIds"])
        self._units: Final = units

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """Learn the letters."""
        self._units.learn_columns(numbers[1], texts[0], texts[1])
        return []


def unit_readers(units: UnitTable) -> dict[str, RecordReader]:
    """The readers by the names of their records."""
    return {"UNIT": UnitReader(units), "MULT": MultiplierReader(units), "FMTU": ColumnUnitsReader(units)}
