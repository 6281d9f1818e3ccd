"""Walks over a binary DataFlash log: records by their length, and the next intact one behind damage.

A record has no checksum. It counts as intact when the magic of the next one, or the end of the log, stands right behind
it; where a type is described twice, or its length is not that of its columns, that decides between the two lengths.
Bytes may be missing inside a record: then another one begins within its length, and the cut one is given up. Otherwise
it is damage that stands behind it. A record between damage on both sides, or inside a cut one, counts when its time
goes on from the newest one, and a description (FMT) by its content.

Most records are plain: no magic stands inside them, and one stands right behind. The look inside costs as much as all
else, so a second walk over the same bytes leaves it out as far as the first one has found no damage.
"""

from math import isfinite
from struct import Struct
from typing import Final

from mypy_extensions import i64

from attest_mav.logs.damage import Damage
from attest_mav.logs.dataflash.record_format import FORMAT_BYTES, FORMAT_TYPE, HEADER_BYTES, parse_format
from attest_mav.logs.dataflash.routes import Route, Router
from attest_mav.logs.dataflash.selection import time_column
from attest_mav.samples import Sample

MAGIC: Final = b"\xa3\x95"
MAGIC_BYTES: Final = 2
MARGIN: Final = 1024
"""More than the longest stretch that deciding on one record looks ahead: three records of at most 255 bytes."""
STRETCH: Final = 8192
"""Bytes in which the magics are counted at once: one number in 65,536 looks like one, and costs a search a record."""
LONGEST_GAP_NS: Final = 60_000_000_000
"""A record between damage on both sides is no more than this away from the newest one in time."""
_NUMBERS: Final = {"Q": Struct("<Q"), "I": Struct("<I")}


class RecordWalker:
    """The samples of the wanted records, from windows of the log.

    router: makes the readers. intact_to: up to this byte another walk over the log has found no damage.
    """

    def __init__(self, router: Router, intact_to: int = 0) -> None:
        self.records = 0
        """Intact records, wanted or not."""
        self.damage: Final = Damage()
        self._router: Final = router
        self._routes: Final[list[Route | None]] = [None] * 256
        self._former: Final[list[Route | None]] = [None] * 256
        """By type the route that another description has replaced: either of the two may be damaged."""
        self._data = b""
        self._size: i64 = 0
        self._position = 0
        self._final = False
        self._in_damage = False
        self._doubted_ns = 0
        """Time after the newest record with damage behind it, which may have damaged the time too."""
        self._sure_ns = 0
        """Time before that record."""
        self._intact_to: Final = intact_to
        self._known_to: i64 = 0
        """The same, counted from the begin of the window."""

    @property
    def position(self) -> int:
        """Where the next window has to begin."""
        return self._position

    def walk(self, window: bytes, final: bool) -> list[Sample]:
        """The samples of the window that begins at ``position``. final: it reaches to the end of the log."""
        self._data, self._size, self._final = window, len(window), final
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
                following = self._next_magic(at + 1, stop)
                self.damage.add(self._position + at, following - at)
                self._in_damage = True
                at = following
                continue
            self._in_damage = False
            self.records += 1
            if self._is_followed(at + length):
                self._take(at, samples)
            else:
                self._take_doubted(at, samples)
            at += length
        self._position += at
        return samples

    def _take_plain(self, at: i64, stop: i64, samples: list[Sample]) -> i64:
        """Take the plain records from ``at`` on, but for descriptions; where the first other one begins."""
        data, routes = self._data, self._routes
        if not self._has_magic(at):
            return at
        last: i64 = self._size - HEADER_BYTES
        begin, plain_to = at, self._known_to
        records = 0
        while at < stop:
            kind = data[at + 2]
            route = routes[kind]
            if route is None or kind == FORMAT_TYPE:
                break
            end = at + route.length
            if end > last or data[end] != 0xA3 or data[end + 1] != 0x95:
                break
            if end > plain_to:
                plain_to = self._plain_to(at, stop)
                if end > plain_to:
                    break
            records += 1
            route.take(data, at, samples)
            at = end
        self.records += records
        self._in_damage = self._in_damage and at == begin
        return at

    def _plain_to(self, begin: i64, stop: i64) -> i64:
        """End of the records from ``begin`` on that have no magic inside, as far as one count of it reaches."""
        data, routes = self._data, self._routes
        stretch: i64 = min(stop, begin + STRETCH, self._size - MAGIC_BYTES)
        at = begin
        records = 0
        while at < stretch:
            route = routes[data[at + 2]]
            if route is None or data[at + 2] == FORMAT_TYPE or data[at] != 0xA3 or data[at + 1] != 0x95:
                break
            at += route.length
            records += 1
        return at if data.count(MAGIC, begin, at) == records else self._first_with_magic(begin)

    def _first_with_magic(self, at: i64) -> i64:
        """The first record from ``at`` on that has a magic inside."""
        length = self._length(at)
        while length > 0 and self._next_magic(at + 1, at + length) == at + length:
            at += length
            length = self._length(at)
        return at

    def _take(self, at: i64, samples: list[Sample]) -> None:
        """Count the record at this place, and read it if it is wanted."""
        kind = self._data[at + 2]
        if kind == FORMAT_TYPE:
            self._describe(at)
        route = self._routes[kind]
        if route is not None:
            route.take(self._data, at, samples)

    def _take_doubted(self, at: i64, samples: list[Sample]) -> None:
        """The same for a record with damage behind it."""
        clock = self._router.clock
        if clock.now_ns != self._doubted_ns:
            self._sure_ns = clock.now_ns
        self._take(at, samples)
        self._doubted_ns = clock.now_ns

    def _describe(self, at: i64) -> None:
        """Take the description at this place, unless it is known."""
        described = parse_format(self._data[at + HEADER_BYTES : at + FORMAT_BYTES])
        if described is None:
            return
        self._believe(self._router.route(described))
        if described.length != described.columns_length:
            self._believe(self._router.route(described.of_columns()))

    def _believe(self, route: Route | None) -> None:
        """Take a route for its type, and keep the one before for the case that this description is the damaged one."""
        if route is None:
            return
        kind = route.record_format.record_type
        if route is not self._routes[kind]:
            self._former[kind] = self._routes[kind]
            self._routes[kind] = route

    def _intact(self, at: i64) -> i64:
        """Length of the intact record that begins here, 0 if none does."""
        length = self._length(at)
        if length == 0:
            return 0
        kind = self._data[at + 2]
        end = at + length
        if self._is_followed(end):
            return length if end <= self._known_to or not self._hides_end(at + HEADER_BYTES, end) else 0
        former = self._former[kind]
        if former is not None and self._is_followed(at + former.length) and not self._is_cut(at, at + former.length):
            self._exchange(kind)
            return former.length
        if self._is_cut(at, end):
            return 0
        return length if not self._in_damage or self._is_certain(at) else 0

    def _length(self, at: i64) -> i64:
        """Length of the record whose header stands here and that ends in the window, 0 if there is none."""
        data = self._data
        if not self._has_magic(at):
            return 0
        if data[at + 2] == FORMAT_TYPE:
            if at + FORMAT_BYTES > self._size or parse_format(data[at + HEADER_BYTES : at + FORMAT_BYTES]) is None:
                return 0
            return FORMAT_BYTES
        route = self._routes[data[at + 2]]
        if route is None or at + route.length > self._size:
            return 0
        return route.length

    def _is_followed(self, end: i64) -> bool:
        """Whether another record, of any type, begins here, or the log ends."""
        return self._has_magic(end) or (end == self._size and self._final)

    def _has_magic(self, at: i64) -> bool:
        """Whether the header of a record, of any type, stands here and ends in the window."""
        data = self._data
        return at + HEADER_BYTES <= self._size and data[at] == 0xA3 and data[at + 1] == 0x95

    def _exchange(self, kind: i64) -> None:
        """Believe the former description of a type."""
        self._routes[kind], self._former[kind] = self._former[kind], self._routes[kind]

    def _hides_end(self, at: i64, end: i64) -> bool:
        """Whether this record has lost bytes, and as many of other records stand in their place up to its end.

        Some numbers look like the header of a record; the time of that one tells.
        """
        inside = self._next_magic(at, end)
        while inside < end:
            if self._chain_end(inside, end) == end and self._is_certain(inside):
                return True
            inside = self._next_magic(inside + 1, end)
        return False

    def _chain_end(self, at: i64, stop: i64) -> i64:
        """Where the records from ``at`` on lead to, at ``stop`` or behind; 0 if they do not lead there."""
        while at < stop:
            length = self._length(at)
            if length == 0:
                return 0
            at += length
        return at

    def _is_cut(self, at: i64, end: i64) -> bool:
        """Whether another record begins inside this one: a further one stands behind it, or its content proves it."""
        inside = self._next_magic(at + 1, end)
        while inside < end:
            length = self._length(inside)
            if length > 0 and (self._is_followed(inside + length) or self._is_certain(inside)):
                return True
            inside = self._next_magic(inside + 1, end)
        return False

    def _is_certain(self, at: i64) -> bool:
        """Whether the content of the record shows that it is one: a description, or a time close to the newest one."""
        if self._data[at + 2] == FORMAT_TYPE:
            return True
        route = self._routes[self._data[at + 2]]
        if route is None or not route.record_format.is_readable:
            return False
        column, unit_ns = time_column(route.record_format)
        reader = _NUMBERS.get(route.record_format.codes[column]) if column >= 0 else None
        if reader is None:
            return False
        t_ns: float = reader.unpack_from(self._data, at + route.record_format.offsets[column])[0] * unit_ns
        away_ns = min(abs(t_ns - self._router.clock.now_ns), abs(t_ns - self._sure_ns))
        return isfinite(t_ns) and away_ns <= LONGEST_GAP_NS

    def _next_magic(self, at: i64, stop: i64) -> i64:
        """The next place before ``stop`` where a record may begin; ``stop`` if there is none."""
        found: i64 = self._data.find(MAGIC, at, stop + 1)
        return found if 0 <= found < stop else stop
