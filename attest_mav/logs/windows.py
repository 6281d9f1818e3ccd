"""Reads a log in windows, so that the memory does not depend on its length."""

from collections.abc import Iterator
from typing import Final, Protocol, TypeVar

from attest_mav.logs.source import LogBytes

WINDOW_BYTES: Final = 1 << 18
"""Length of a window: large against the cost of one, small enough for the processor's cache."""

Found_co = TypeVar("Found_co", covariant=True)


class WindowWalker(Protocol[Found_co]):
    """Walks over a log, window by window."""

    @property
    def position(self) -> int:
        """Where the next window has to begin."""

    def walk(self, window: bytes, final: bool) -> Found_co:
        """The findings of the window that begins at ``position``. final: it reaches to the end of the log."""


def read_windows(data: LogBytes, walker: WindowWalker[Found_co]) -> Iterator[Found_co]:
    """The findings of the whole log, those of one window at a time."""
    length = len(data)
    final = False
    while not final:
        start = walker.position
        window = data[start : start + WINDOW_BYTES]
        final = start + len(window) >= length
        yield walker.walk(window, final)
