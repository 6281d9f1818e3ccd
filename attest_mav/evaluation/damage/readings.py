"""The records that the readers of each format find, by what stands in them."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan
from typing import Final

from attest_mav.evaluation.damage.records import Record
from attest_mav.logs.damage import Damage
from attest_mav.logs.dataflash.reader import RecordReader
from attest_mav.logs.dataflash.routes import Router
from attest_mav.logs.dataflash.streams import SENSORS
from attest_mav.logs.dataflash.text_walker import TextWalker
from attest_mav.logs.dataflash.units import Column, UnitTable
from attest_mav.logs.dataflash.walker import RecordWalker
from attest_mav.logs.detect import LogFormat
from attest_mav.logs.source import LogBytes
from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.logs.ulog.reader import TopicReader
from attest_mav.logs.ulog.roles import stream_of
from attest_mav.logs.ulog.topics import Topics
from attest_mav.logs.ulog.walker import UlogWalker
from attest_mav.logs.windows import read_windows
from attest_mav.mavlink.dialect import Dialect
from attest_mav.samples import Sample

Content = tuple[str, tuple[float | str | bytes, ...]]
"""Kind and values of a record."""


@dataclass(frozen=True)
class Reading:
    """The records found, in order, and the bytes that the reader counts as lost."""

    found: list[Content]
    lost_bytes: int
    places: Sequence[tuple[int, int]] = ()
    """Offset and length of the first stretches of lost bytes, where the reader keeps them."""


class Reader:
    """Reads logs of one format. kinds: names and columns (DataFlash) or names (ULog) of the records that are read."""

    def __init__(self, log_format: LogFormat, dialect: Dialect, log: bytes, records: Sequence[Record]) -> None:
        self._format: Final[LogFormat] = log_format
        self._dialect: Final = dialect
        self._columns: Final = _columns(log_format, log, records)

    def read(self, log: LogBytes) -> Reading:
        """The reading of a log, damaged or not."""
        if self._format == "dataflash":
            return self._dataflash(log, text=False)
        if self._format == "dataflash-text":
            return self._dataflash(log, text=True)
        return self._ulog(log) if self._format == "ulog" else self._frames(log)

    def _frames(self, log: LogBytes) -> Reading:
        reader = TlogReader(log, self._dialect, None, self._format == "mavlink")
        found: list[Content] = [
            (str(frame.message_id), (int(frame.system), int(frame.component), int(frame.sequence), frame.payload))
            for frame in reader
        ]
        return Reading(found, reader.bad_bytes)

    def _dataflash(self, log: LogBytes, text: bool) -> Reading:
        found: list[Content] = []
        readers: dict[str, RecordReader] = {}
        for name, columns in self._columns.items():
            for stream in SENSORS.get(name, (name,)):
                readers[stream] = _Records(name, columns, found)
        router = Router(readers, UnitTable())
        walker: TextWalker | RecordWalker = TextWalker(router) if text else RecordWalker(router)
        for _ in read_windows(log, walker):
            pass
        return _reading(found, walker.damage)

    def _ulog(self, log: LogBytes) -> Reading:
        found: list[Content] = []
        readers: dict[str, TopicReader] = {}
        for kind in self._columns:
            topic, _, instance = kind.partition("/")
            readers[stream_of(topic, int(instance))] = _Messages(kind, found)
        walker = UlogWalker(Topics(readers))
        for _ in read_windows(log, walker):
            pass
        return _reading(found, walker.damage)


class _Records(RecordReader):
    """Keeps the records of one type."""

    def __init__(self, name: str, columns: Sequence[str], found: list[Content]) -> None:
        super().__init__([Column(one) for one in columns], columns)
        self._name: Final = name
        self._found: Final = found

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        self._found.append((self._name, (*[str(one) if isnan(one) else one for one in numbers[1:]], *texts)))
        return []


class _Messages(TopicReader):
    """Keeps the times of one topic's messages."""

    def __init__(self, name: str, found: list[Content]) -> None:
        super().__init__()
        self._name: Final = name
        self._found: Final = found

    def read(self, t_ns: int, numbers: list[float]) -> list[Sample]:
        self._found.append((self._name, tuple(numbers)))
        return []


def _reading(found: list[Content], damage: Damage) -> Reading:
    return Reading(found, damage.total, tuple(damage.first))


def _columns(log_format: LogFormat, log: bytes, records: Sequence[Record]) -> dict[str, tuple[str, ...]]:
    """The columns of each kind of record, by the descriptions in the undamaged log."""
    if log_format == "ulog":
        return {one.kind: () for one in records if one.is_data}
    found: dict[str, tuple[str, ...]] = {}
    for one in records:
        if one.descriptions and one.kind not in found:
            begin, end = one.descriptions[0]
            if log_format == "dataflash":
                labels = log[begin + 25 : end].rstrip(b"\0").split(b",")
            else:
                labels = log[begin:end].strip().split(b",")[5:]
            found[one.kind] = tuple(label.strip().decode("ascii", "replace") for label in labels)
    return found
