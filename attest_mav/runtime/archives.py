"""Logs in gzip or zip archives: unpacked into a temporary file without a name, of bounded size."""

import gzip
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Final

from attest_mav.errors import UnreadableDataError

GZIP: Final = b"\x1f\x8b"
ZIP: Final = b"PK\x03\x04"
MOST_BYTES: Final = 1 << 31
"""A log that is larger is not unpacked: a small archive can hold as much as it likes."""
PIECE_BYTES: Final = 1 << 18
ENCRYPTED: Final = 1
"""Bit of a zip member's flags."""
SHOWN: Final = 3
"""So many members are named."""


@contextmanager
def unpacked(file: IO[bytes], path: object) -> Iterator[IO[bytes]]:
    """The file itself, or the log in the archive that it is; UnreadableDataError if that cannot be unpacked."""
    magic = file.read(len(ZIP))
    file.seek(0)
    if not magic.startswith((GZIP, ZIP)):
        yield file
        return
    with tempfile.TemporaryFile() as log:
        kind = "gzip" if magic.startswith(GZIP) else "zip"
        try:
            if kind == "gzip":
                with gzip.open(file) as packed:
                    _copy(packed, log, path)
            else:
                _copy_member(file, log, path)
        except (EOFError, gzip.BadGzipFile, zipfile.BadZipFile, zlib.error, NotImplementedError) as error:
            raise UnreadableDataError(f"{path}: the {kind} archive is damaged or of an unknown kind: {error}") from None
        except OSError as error:
            raise UnreadableDataError(f"{path}: the {kind} archive cannot be unpacked: {error.strerror}") from None
        log.flush()
        yield log


def _copy_member(file: IO[bytes], log: IO[bytes], path: object) -> None:
    """Unpack the only file of a zip archive."""
    with zipfile.ZipFile(file) as archive:
        members = [one for one in archive.infolist() if not one.is_dir() and not one.filename.startswith("__MACOSX/")]
        if len(members) != 1:
            names = ", ".join(one.filename for one in members[:SHOWN])
            some = f"{len(members)} files ({names}{', ...' if len(members) > SHOWN else ''})" if members else "no file"
            raise UnreadableDataError(f"{path}: the zip archive holds {some}; expected one log")
        if members[0].flag_bits & ENCRYPTED:
            raise UnreadableDataError(f"{path}: the zip archive is encrypted: unpack it first")
        with archive.open(members[0]) as packed:
            _copy(packed, log, path)


def _copy(packed: IO[bytes] | gzip.GzipFile, log: IO[bytes], path: object) -> None:
    """Copy all bytes; an error where they are too many."""
    size = 0
    while piece := packed.read(PIECE_BYTES):
        size += len(piece)
        if size > MOST_BYTES:
            limit = f"{MOST_BYTES >> 20} MiB"
            raise UnreadableDataError(f"{path}: the archive holds more than {limit}: unpack it first")
        log.write(piece)
