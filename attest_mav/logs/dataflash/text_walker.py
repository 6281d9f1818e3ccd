"""Walks over a DataFlash log in text, as ground stations write it: a line is a record, ``NAME, VALUE, VALUE, ...``.

The numbers are scaled already. Lines before the first description (FMT) are the firmware's banner.
"""

from codecs import IncrementalDecoder, getincrementaldecoder
from collections.abc import Sequence
from typing import Final

from attest_mav.logs.damage import Damage
from attest_mav.logs.dataflash.record_format import made_format
from attest_mav.logs.dataflash.routes import Route, Router
from attest_mav.logs.detect import BYTE_ORDER_MARKS
from attest_mav.samples import Sample

FORMAT: Final = "FMT"
COLUMNS_AT: Final = 5
"""Place of the first column's name in a line of FMT; type, length, name and letters stand before it."""
LONGEST_LINE: Final = 1 << 16
"""A line that is longer is none."""


class TextWalker:
    """The samples of the wanted records, from windows of the log. ``router``: makes the readers."""

    def __init__(self, router: Router) -> None:
        self.records = 0
        """Intact records, wanted or not."""
        self.damage: Final = Damage()
        self._router: Final = router
        self._routes: Final[dict[str, Route]] = {}
        self._decoder: IncrementalDecoder | None = None
        self._width = 1
        self._position = 0
        self._line_at = 0
        self._rest = ""

    @property
    def position(self) -> int:
        """Where the next window has to begin."""
        return self._position

    def walk(self, window: bytes, final: bool) -> list[Sample]:
        """The samples of the lines that end in the window that begins at ``position``. final: it is the last one."""
        if self._decoder is None:
            self._decoder = self._decoder_for(window)
        lines = (self._rest + self._decoder.decode(window, final)).split("\n")
        self._rest = "" if final or len(lines[-1]) > LONGEST_LINE else lines.pop()
        self._position += len(window)
        samples: list[Sample] = []
        for line in lines:
            self._take(line, samples)
        return samples

    def _decoder_for(self, begin: bytes) -> IncrementalDecoder:
        """The decoder by the byte-order mark; without one the text is taken for ASCII, and other bytes are replaced."""
        for mark, encoding in BYTE_ORDER_MARKS:
            if begin.startswith(mark):
                self._width = 1 if encoding == "utf-8" else 2
                return getincrementaldecoder(encoding)("replace")
        return getincrementaldecoder("latin-1")("replace")

    def _take(self, line: str, samples: list[Sample]) -> None:
        """Count the line, and read it if it is a wanted record."""
        size = (len(line) + 1) * self._width
        at = self._line_at
        self._line_at += size
        fields = [field.strip() for field in line.lstrip("\ufeff").split(",")]
        route = self._described(fields) if fields[0] == FORMAT else self._routes.get(fields[0])
        if route is None or len(fields) <= len(route.record_format.codes):
            if self._routes and line.strip():
                self.damage.add(at, size)
            return
        self.records += 1
        number_at = route.number_column + 1
        binding = route.binding(_number(fields[number_at]) if number_at else 0)
        if binding is not None:
            samples.extend(binding.take_line(fields[1:]))

    def _described(self, fields: Sequence[str]) -> Route | None:
        """The route of FMT itself, after taking the description in its line; None if that is none."""
        if len(fields) <= COLUMNS_AT or not (fields[1].isdecimal() and fields[2].isdecimal() and fields[3]):
            return None
        name = fields[3]
        described = made_format(int(fields[1]), int(fields[2]), name, fields[4], ",".join(fields[COLUMNS_AT:]))
        route = self._router.route(described)
        if route is not None:
            self._routes[name] = route
        return self._router.route(FORMAT_OF_FORMATS) if FORMAT not in self._routes else self._routes[FORMAT]


FORMAT_OF_FORMATS: Final = made_format(128, 89, FORMAT, "BBnNZ", "Type,Length,Name,Format,Columns")


def _number(text: str) -> int:
    """The whole number that a text is; -1 for none."""
    return int(text) if text.isdecimal() else -1
