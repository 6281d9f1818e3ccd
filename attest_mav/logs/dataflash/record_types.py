"""The types of record that a log has described so far, by their numbers."""

from typing import Final

from attest_mav.logs.dataflash.record_format import FORMAT_BYTES, FORMAT_TYPE, HEADER_BYTES, parse_format
from attest_mav.logs.dataflash.routes import Route, Router

TYPES: Final = 256
LONGEST: Final = 255
"""Bytes of a record: a description tells its length in one byte."""


class RecordTypes:
    """Takes descriptions. router: makes the readers."""

    def __init__(self, router: Router) -> None:
        self.routes: Final[list[Route | None]] = [None] * TYPES
        """By type the route of its records."""
        self.former: Final[list[Route | None]] = [None] * TYPES
        """By type the route that another description has replaced: either of the two may be damaged."""
        self.lengths = bytes(TYPES)
        """By type the bytes of a record; 0 for a type without a description, and for descriptions themselves."""
        self.wanted = bytes(TYPES)
        """By type 1 where its records are read or counted, else 0."""
        self._router: Final = router

    def describe(self, data: bytes, at: int) -> None:
        """Take the description at this place, unless it is known."""
        described = parse_format(data[at + HEADER_BYTES : at + FORMAT_BYTES])
        if described is None:
            return
        self._believe(self._router.route(described))
        if described.length != described.columns_length <= LONGEST:
            self._believe(self._router.route(described.of_columns()))

    def exchange(self, kind: int) -> None:
        """Believe the former description of a type."""
        route = self.former[kind]
        self.former[kind] = self.routes[kind]
        self._use(kind, route)

    def _believe(self, route: Route | None) -> None:
        """Take a route for its type, and keep the one before for the case that this description is the damaged one."""
        if route is None:
            return
        kind = route.record_format.record_type
        if route is not self.routes[kind]:
            self.former[kind] = self.routes[kind]
            self._use(kind, route)

    def _use(self, kind: int, route: Route | None) -> None:
        self.routes[kind] = route
        length = 0 if route is None or kind == FORMAT_TYPE else int(route.length)
        is_wanted = route is not None and (self._router.counts_all or route.is_wanted)
        self.lengths = self.lengths[:kind] + bytes((length,)) + self.lengths[kind + 1 :]
        self.wanted = self.wanted[:kind] + bytes((is_wanted,)) + self.wanted[kind + 1 :]
