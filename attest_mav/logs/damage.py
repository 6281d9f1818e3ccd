"""The bytes of a log that belong to no intact record: how many, and where."""

from typing import Final

SHOWN: Final = 3
"""The places of so many damages are kept."""


class Damage:
    """Bytes of a log that belong to no intact record."""

    def __init__(self) -> None:
        self.total = 0
        self.places = 0
        self.first: Final[list[tuple[int, int]]] = []
        """Offset and length of the first ``SHOWN`` of them."""
        self._end = -1

    def add(self, offset: int, size: int) -> None:
        """Take the next damage; one that goes on from the last one is the same."""
        self.total += size
        if offset == self._end:
            if self.places <= SHOWN:
                begin, length = self.first[-1]
                self.first[-1] = (begin, length + size)
        else:
            self.places += 1
            if self.places <= SHOWN:
                self.first.append((offset, size))
        self._end = offset + size

    def intact_to(self, size: int) -> int:
        """Place of the first damage in a log of this size; the size if there is none."""
        return self.first[0][0] if self.first else size

    def note(self) -> str:
        """The remark for people."""
        places = ", ".join(f"{size} at byte {offset}" for offset, size in self.first)
        rest = " and others" if self.places > len(self.first) else ""
        return f"bytes that belong to no intact record: {self.total} ({places}{rest})"
