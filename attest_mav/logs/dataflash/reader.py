"""The base of all readers of records."""

from collections.abc import Sequence
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.logs.dataflash.units import Column
from attest_mav.samples import Sample

SYSTEM: Final = 1
COMPONENT: Final = 1
"""The ids of the vehicle: a log is that of one vehicle, and has none."""


@mypyc_attr(allow_interpreted_subclasses=True)
class RecordReader:
    """Makes samples of one kind of record. columns, texts: what it wants of it, besides its time."""

    def __init__(self, columns: Sequence[Column] = (), texts: Sequence[str] = ()) -> None:
        self.columns: Final = tuple(columns)
        self.texts: Final = tuple(texts)
        self.is_timed_alone = False
        """Whether only the time of its records shall be followed from now on."""

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """The samples of a record. numbers: those of ``columns`` from 1 on; NaN and "" for what the record lacks."""
        return []


class TimeReader(RecordReader):
    """Makes no samples: only the time of its records is followed."""

    def __init__(self) -> None:
        super().__init__()
        self.is_timed_alone = True
