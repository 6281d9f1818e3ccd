"""All places of a mark in a window of a log, in order: one cut of the window is the quickest way to them."""

from typing import Final

from mypy_extensions import i64


class Marks:
    """The places of one short byte string."""

    def __init__(self, mark: bytes) -> None:
        self._mark: Final = mark
        self._mark_bytes: i64 = len(mark)
        self._data = b""
        self._pieces: list[bytes] = []
        """The window, cut at each mark. Empty until a place is asked for."""
        self._piece: i64 = 0
        self._place: i64 = 0

    def begin(self, window: bytes) -> None:
        """Look at this window from now on."""
        self._data = window
        self._pieces = []

    def behind(self, at: i64) -> i64:
        """The first place behind this one, which never goes back; the end of the window if there is none."""
        if not self._pieces:
            self._pieces = self._data.split(self._mark)
            self._piece = 0
            self._place = len(self._pieces[0])
        while self._place <= at:
            self._piece += 1
            if self._piece >= len(self._pieces):
                self._place = len(self._data)
                break
            self._place += self._mark_bytes + len(self._pieces[self._piece])
        return self._place
