"""Scratch files: in memory while they are small, then without a name in the folder for temporary files.

A file without a name is gone when it is closed, and when the process ends in any way.
"""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from attest_mav.errors import UnwritableError
from attest_mav.runtime.files import reason_of

MEMORY_BYTES: Final = 2 << 20
"""A larger file is no longer held in memory."""


class ScratchFile:
    """A file whose errors say where it is. See ``attest_mav.smoothing.tables.ScratchFile``."""

    def __init__(self) -> None:
        self._file: Final = tempfile.SpooledTemporaryFile(MEMORY_BYTES)  # noqa: SIM115 (closed by ``close``)

    def seek(self, offset: int, /) -> int:
        """Go to a byte."""
        with _explained():
            return self._file.seek(offset)

    def read(self, size: int, /) -> bytes:
        """The next bytes."""
        with _explained():
            return self._file.read(size)

    def write(self, data: bytes, /) -> int:
        """Put all these bytes here."""
        with _explained():
            return self._file.write(data)

    def close(self) -> None:
        """Delete it."""
        with _explained():
            self._file.close()


@contextmanager
def _explained() -> Iterator[None]:
    """An OSError of this block becomes one line about the folder."""
    try:
        yield
    except OSError as error:
        folder = tempfile.tempdir or "any of the usual folders"
        raise UnwritableError(
            f"cannot keep a long flight in a temporary file in {folder}: {reason_of(error)}; expected 0.3 kB a "
            "sample of space there, or another folder by the environment variable TMPDIR"
        ) from None
