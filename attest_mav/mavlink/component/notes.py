"""Lines for the log from code that does no I/O: it leaves them here, and the host fetches and logs them."""

from typing import Final

INFO: Final = 20
WARNING: Final = 30
ERROR: Final = 40
"""The numbers of Python's logging levels."""

MAX_NOTES: Final = 100
"""Notes beyond this are dropped until they are fetched: a flood is no information."""


class Note:
    """One line for the log."""

    def __init__(self, level: int, text: str) -> None:
        self.level: Final = level
        self.text: Final = text


class Notebook:
    """Keeps notes until they are fetched."""

    def __init__(self) -> None:
        self.warnings = 0
        """Warnings so far."""
        self.errors = 0
        """Errors so far."""
        self.dropped = 0
        """Notes of any level that there was no room for."""
        self._notes: list[Note] = []

    def info(self, text: str) -> None:
        """Leave a note that needs no action."""
        self._add(Note(INFO, text))

    def warning(self, text: str) -> None:
        """Leave a note that a person should act on."""
        self.warnings += 1
        self._add(Note(WARNING, text))

    def error(self, text: str) -> None:
        """Leave a note of a fault that stops the service until a person acts."""
        self.errors += 1
        self._add(Note(ERROR, text))

    def _add(self, note: Note) -> None:
        if len(self._notes) < MAX_NOTES:
            self._notes.append(note)
        else:
            self.dropped += 1

    def take(self) -> list[Note]:
        """All notes since the last call, oldest first."""
        notes = self._notes
        if notes:
            self._notes = []
        return notes
