"""Logs in gzip or zip archives: unpacked into a temporary file without a name, of bounded size."""

import gzip
import os
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
MOST_RATIO: Final = 200
"""A log is packed into no less than a hundredth of its size, or nearly so: an archive that holds more is no log."""
FREE_BYTES: Final = 1 << 25
"""So many bytes are unpacked whatever the ratio."""
PIECE_BYTES: Final = 1 << 18
DIRECTORY_END: Final = b"PK\x05\x06"
DIRECTORY_END_BYTES: Final = 22
LARGE_DIRECTORY: Final = b"PK\x06\x07"
"""Stands this far before the end of a directory that has more or larger files than fit a common one."""
LARGE_DIRECTORY_BYTES: Final = 20
MOST_COMMENT: Final = 1 << 16
MOST_DIRECTORY: Final = 1 << 20
"""Bytes of a zip archive's directory: ten thousand files, all of which would be held in memory."""
METHODS: Final = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
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
                    _copy(packed, log, path, os.fstat(file.fileno()).st_size)
            else:
                _copy_member(file, log, path)
        except (EOFError, gzip.BadGzipFile, zipfile.BadZipFile, zlib.error, NotImplementedError, ValueError) as error:
            raise UnreadableDataError(f"{path}: the {kind} archive is damaged or of an unknown kind: {error}") from None
        except OSError as error:
            reason = error.strerror or str(error)
            raise UnreadableDataError(f"{path}: the {kind} archive cannot be unpacked: {reason}") from None
        log.flush()
        yield log


def _copy_member(file: IO[bytes], log: IO[bytes], path: object) -> None:
    """Unpack the only file of a zip archive."""
    _require_small_directory(file, path)
    with zipfile.ZipFile(file) as archive:
        members = [one for one in archive.infolist() if not one.is_dir() and not one.filename.startswith("__MACOSX/")]
        if len(members) != 1:
            names = ", ".join(one.filename for one in members[:SHOWN])
            some = f"{len(members)} files ({names}{', ...' if len(members) > SHOWN else ''})" if members else "no file"
            raise UnreadableDataError(f"{path}: the zip archive holds {some}; expected one log")
        if members[0].flag_bits & ENCRYPTED:
            raise UnreadableDataError(f"{path}: the zip archive is encrypted: unpack it first")
        if members[0].compress_type not in METHODS:
            raise UnreadableDataError(f"{path}: the zip archive is packed in a way that is unknown: unpack it first")
        with archive.open(members[0]) as packed:
            _copy(packed, log, path, members[0].compress_size)


def _require_small_directory(file: IO[bytes], path: object) -> None:
    """An error for a directory of very many files, before all of it is read."""
    length = file.seek(0, os.SEEK_END)
    file.seek(max(0, length - DIRECTORY_END_BYTES - LARGE_DIRECTORY_BYTES - MOST_COMMENT))
    tail = file.read()
    file.seek(0)
    at = tail.rfind(DIRECTORY_END)
    large = tail[max(0, at - LARGE_DIRECTORY_BYTES) : at].startswith(LARGE_DIRECTORY)
    if at >= 0 and (large or int.from_bytes(tail[at + 12 : at + 16], "little") > MOST_DIRECTORY):
        raise UnreadableDataError(f"{path}: the zip archive holds very many or very large files; expected one log")


def _copy(packed: IO[bytes] | gzip.GzipFile, log: IO[bytes], path: object, packed_bytes: int) -> None:
    """Copy all bytes; an error where they are too many, in all or for those that they were packed into."""
    size = 0
    while piece := packed.read(PIECE_BYTES):
        size += len(piece)
        if size > FREE_BYTES and size > MOST_RATIO * packed_bytes:
            raise UnreadableDataError(f"{path}: the archive holds over {MOST_RATIO} times its own size, as no log does")
        if size > MOST_BYTES:
            limit = f"{MOST_BYTES >> 20} MiB"
            raise UnreadableDataError(f"{path}: the archive holds more than {limit}: unpack it first")
        log.write(piece)
