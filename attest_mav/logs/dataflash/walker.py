"""Walks over a binary DataFlash log: records by their length, and the next intact one behind damage.

A record has no checksum. It counts as intact when the magic of the next one, or the end of the log, stands right behind
it; where a type is described twice, or its length is not that of its columns, that decides between the two lengths.
Bytes may be missing inside a record: then another one begins within its length, and the cut one is given up. Otherwise
it is damage that stands behind it. A record between damage on both sides, or inside a cut one, counts when its time
goes on from the newest one, and a description (FMT) by its content.

Most records are plain: no magic stands inside them, and one stands right behind. The look inside costs as much as all
else, so a second walk over the same bytes leaves it out as far as the first one has found no damage.
"""

from typing import Final

from mypy_extensions import i64

from attest_mav.logs.damage import Damage
from attest_mav.logs.dataflash.bounds import MAGIC, Bounds
from attest_mav.logs.dataflash.record_format import FORMAT_TYPE, HEADER_BYTES
from attest_mav.logs.dataflash.record_types import RecordTypes
from attest_mav.logs.dataflash.routes import Router
from attest_mav.samples import Sample

MARGIN: Final = 1024
"""More than the longest stretch that deciding on one record looks ahead: three records of at most 255 bytes."""
STRETCH: Final = 8192
"""Bytes in which the magics are counted at once: one number in 65,536 looks like one, and costs a search a record."""


class RecordWalker:
    """The samples of the wanted records, from windows of the log.

    router: makes the readers. intact_to: up to this byte another walk over the log has found no damage.
    """

    def __init__(self, router: Router, intact_to: int = 0) -> None:
        self.records = 0
        """Intact records, wanted or not."""
        self.damage: Final = Damage()
        self._clock: Final = router.clock
        self._types: Final = RecordTypes(router)
        self._bounds: Final = Bounds(self._types, router.clock)
        self._data = b""
        self._size: i64 = 0
        self._position = 0
        self._in_damage = False
        self._doubted_ns = 0
        """Time after the newest record with damage behind it, which may have damaged the time too."""
        self._intact_to: Final = intact_to
        self._known_to: i64 = 0
        """The same, counted from the begin of the window."""

    @property
    def position(self) -> int:
        """Where the next window has to begin."""
        return self._position

    def walk(self, window: bytes, final: bool) -> list[Sample]:
        """The samples of the window that begins at ``position``. final: it reaches to the end of the log."""
        self._data, self._size = window, len(window)
        self._bounds.begin(window, final)
        self._known_to = max(self._intact_to - self._position, 0)
        samples: list[Sample] = []
        stop: i64 = self._size if final else self._size - MARGIN
        at: i64 = 0
        while at < stop:
            plain_to = self._take_plain(at, stop, samples)
            if plain_to > at:
                at = plain_to
                continue
            length = self._intact(at)
            if length == 0:
                following = self._bounds.next_magic(at + 1, stop)
                self.damage.add(self._position + at, following - at)
                self._in_damage = True
                at = following
                continue
            self._in_damage = False
            self.records += 1
            if self._bounds.is_followed(at + length):
                self._take(at, samples)
            else:
                self._take_doubted(at, samples)
            at += length
        self._position += at
        return samples

    def _take_plain(self, at: i64, stop: i64, samples: list[Sample]) -> i64:
        """Take the plain records from ``at`` on, but for descriptions; where the first other one begins."""
        data, lengths, wanted, routes = self._data, self._types.lengths, self._types.wanted, self._types.routes
        if not self._bounds.has_magic(at):
            return at
        last: i64 = self._size - HEADER_BYTES
        begin, plain_to = at, self._known_to
        records: i64 = 0
        while at < stop:
            kind: i64 = data[at + 2]
            length: i64 = lengths[kind]
            end = at + length
            if length == 0 or end > last or data[end] != 0xA3 or data[end + 1] != 0x95:
                break
            if end > plain_to:
                plain_to = self._plain_to(at, stop)
                if end > plain_to:
                    break
            records += 1
            if wanted[kind] != 0:
                route = routes[kind]
                if route is not None:
                    route.take(data, at, samples)
            at = end
        self.records += records
        self._in_damage = self._in_damage and at == begin
        return at

    def _plain_to(self, begin: i64, stop: i64) -> i64:
        """End of the records from ``begin`` on that have no magic inside, as far as one count of it reaches."""
        data, lengths = self._data, self._types.lengths
        stretch: i64 = min(stop, begin + STRETCH, self._size - HEADER_BYTES)
        at = begin
        records: i64 = 0
        while at < stretch:
            length: i64 = lengths[data[at + 2]]
            if length == 0 or data[at] != 0xA3 or data[at + 1] != 0x95:
                break
            at += length
            records += 1
        return at if data.count(MAGIC, begin, at) == records else self._first_with_magic(begin)

    def _first_with_magic(self, at: i64) -> i64:
        """The first record from ``at`` on that has a magic inside."""
        bounds = self._bounds
        length = bounds.length(at)
        while length > 0 and bounds.next_magic(at + 1, at + length) == at + length:
            at += length
            length = bounds.length(at)
        return at

    def _take(self, at: i64, samples: list[Sample]) -> None:
        """Count the record at this place, and read it if it is wanted."""
        kind = self._data[at + 2]
        if kind == FORMAT_TYPE:
            self._types.describe(self._data, at)
        route = self._types.routes[kind]
        if route is not None:
            route.take(self._data, at, samples)

    def _take_doubted(self, at: i64, samples: list[Sample]) -> None:
        """The same for a record with damage behind it."""
        if self._clock.now_ns != self._doubted_ns:
            self._bounds.sure_ns = self._clock.now_ns
        self._take(at, samples)
        self._doubted_ns = self._clock.now_ns

    def _intact(self, at: i64) -> i64:
        """Length of the intact record that begins here, 0 if none does."""
        bounds = self._bounds
        length = bounds.length(at)
        if length == 0:
            return 0
        kind = self._data[at + 2]
        end = at + length
        if bounds.is_followed(end):
            return length if end <= self._known_to or not bounds.hides_end(at, end) else 0
        former = self._types.former[kind]
        if former is not None and bounds.is_followed(at + former.length) and not bounds.is_cut(at, at + former.length):
            self._types.exchange(kind)
            return former.length
        if bounds.is_cut(at, end):
            return 0
        return length if not self._in_damage or bounds.is_certain(at) else 0
