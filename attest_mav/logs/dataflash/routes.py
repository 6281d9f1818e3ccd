"""Routes: for each type of record of a log, the readers of its streams, bound to the columns that the log has."""

from collections.abc import Mapping, Sequence
from typing import Final

from mypy_extensions import i64

from attest_mav.logs.dataflash.reader import RecordReader
from attest_mav.logs.dataflash.record_clock import RecordClock
from attest_mav.logs.dataflash.record_format import RecordFormat
from attest_mav.logs.dataflash.selection import Selection, time_column
from attest_mav.logs.dataflash.streams import number_column, streams_of
from attest_mav.logs.dataflash.units import UnitTable
from attest_mav.samples import Sample

PACER: Final = "IMU"
"""The stream whose records, where they have no time, pace the clock."""
NO_SAMPLES: Final[list[Sample]] = []
NO_TEXTS: Final[list[str]] = []
MOST_ROUTES: Final = 4096
"""A log with more descriptions is damaged or made to be one: the others are not believed."""


class Binding:
    """A reader with the selection of its columns out of one type of record. paces: its records pace a clock."""

    def __init__(self, reader: RecordReader, selection: Selection, clock: RecordClock, paces: bool) -> None:
        self._reader: Final = reader
        self._selection: Final = selection
        self._clock: Final = clock
        self._paces: Final = paces
        self._has_texts: Final = bool(reader.texts)

    def take(self, data: bytes, at: int) -> list[Sample]:
        """The samples of the record at this place."""
        if self._paces:
            self._clock.tick()
        if self._reader.is_timed_alone:
            self._clock.at(self._selection.time_ns(data, at))
            return NO_SAMPLES
        numbers = self._selection.numbers(data, at)
        texts = self._selection.texts(data, at) if self._has_texts else NO_TEXTS
        return self._reader.read(self._clock.at(numbers[0]), numbers, texts)

    def take_line(self, fields: Sequence[str]) -> list[Sample]:
        """The samples of the record in these fields of a line."""
        if self._paces:
            self._clock.tick()
        numbers = self._selection.line_numbers(fields)
        texts = self._selection.line_texts(fields) if self._has_texts else []
        return self._reader.read(self._clock.at(numbers[0]), numbers, texts)


class Route:
    """The records of one type."""

    def __init__(self, record_format: RecordFormat, streams: tuple[str, ...], bindings: list[Binding | None]) -> None:
        number_at = number_column(record_format)
        self.record_format: Final = record_format
        self.length: i64 = record_format.length
        """Bytes of a record."""
        self.streams: Final = streams
        self.counts: Final = [0] * len(streams)
        """Records of each stream, those of ``of_one_stream`` aside."""
        self.of_one_stream: i64 = 0
        """Records of a type without a number that were taken from bytes: a plain number counts quickest."""
        self.other = 0
        """Records with a number that no stream has."""
        self.is_wanted: Final = any(one is not None for one in bindings)
        """Whether some of the records are read."""
        self.number_column: Final = number_at
        """The column with the number of the stream, -1 where there is one stream."""
        self.number_at: i64 = record_format.offsets[number_at] if number_at >= 0 else -1
        """Its place in the bytes of a record."""
        self.bindings: Final = bindings
        """By the number of the stream, None for one that is not wanted."""
        self._only: Final = bindings[0] if len(bindings) == 1 else None

    def take(self, data: bytes, at: i64, samples: list[Sample]) -> None:
        """Count the record at this place, and add its samples if it is wanted."""
        place = self.number_at
        if place < 0:
            self.of_one_stream += 1
            binding = self._only
        else:
            binding = self.binding(data[at + place])
        if binding is not None:
            found = binding.take(data, at)
            if found:
                samples.extend(found)

    def binding(self, number: int) -> Binding | None:
        """Count a record with this number; its reader, None where it is not wanted."""
        if number < 0 or number >= len(self.counts):
            self.other += 1
            return None
        self.counts[number] = self.counts[number] + 1  # quicker than += when it is compiled
        return self.bindings[number]


class Router:
    """Makes the routes of the types that a log describes.

    readers: by the names of the streams that are wanted. pace_ns: interval of inertial records without a time, ns.
    counts_all: whether the records of all other streams shall be counted too.
    """

    def __init__(
        self, readers: Mapping[str, RecordReader], units: UnitTable, pace_ns: float = 0.0, counts_all: bool = True
    ) -> None:
        self.clock: Final = RecordClock(pace_ns)
        self.units: Final = units
        self.counts_all: Final = counts_all
        self._readers: Final = dict(readers)
        self._routes: Final[dict[tuple[int, int, str, str, tuple[str, ...]], Route]] = {}

    def route(self, record_format: RecordFormat) -> Route | None:
        """The route of one type of record, the same for the same description; None behind ``MOST_ROUTES`` of them."""
        known = self._routes.get(record_format.key)
        if known is not None or len(self._routes) >= MOST_ROUTES:
            return known
        self.units.learn_name(record_format.record_type, record_format.name)
        streams = streams_of(record_format)
        bindings = [self._binding(stream, record_format) for stream in streams]
        made = Route(record_format, streams, bindings)
        self._routes[record_format.key] = made
        return made

    def counts(self) -> dict[str, int]:
        """Number of records by stream."""
        counts: dict[str, int] = {}
        for route in self._routes.values():
            for stream, counted in zip(route.streams, route.counts, strict=True):
                count = counted + route.of_one_stream
                if count:
                    counts[stream] = counts.get(stream, 0) + count
            if route.other:
                name = route.record_format.name
                counts[name] = counts.get(name, 0) + route.other
        return counts

    def _binding(self, stream: str, record_format: RecordFormat) -> Binding | None:
        reader = self._readers.get(stream)
        if reader is None or not record_format.is_readable:
            return None
        selection = Selection(record_format, reader.columns, reader.texts, self.units)
        return Binding(reader, selection, self.clock, stream == PACER and time_column(record_format)[0] < 0)
