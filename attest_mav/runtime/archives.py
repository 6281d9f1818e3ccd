"""Logs in gzip or zip archives: unpacked into a temporary file without a name, of bounded size.

Of a damaged archive all is taken that can be unpacked, with a note that tells the loss.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Final

from attest_mav.errors import UnreadableDataError
from attest_mav.runtime.unpacking import GZIP, ZIP, Unpacker

if TYPE_CHECKING:
    from attest_mav.runtime.gzip_archive import GzipArchive
    from attest_mav.runtime.zip_archive import ZipArchive


class Unpacked:
    """The log, and remarks on the archive that it comes from."""

    def __init__(self, log: IO[bytes], notes: tuple[str, ...] = ()) -> None:
        self.log: Final = log
        self.notes: Final = notes


@contextmanager
def unpacked(file: IO[bytes], path: object) -> Iterator[Unpacked]:
    """The file itself, or the log in the archive that it is; UnreadableDataError if nothing of it can be unpacked."""
    magic = file.read(len(ZIP))
    file.seek(0)
    if not magic.startswith((GZIP, ZIP)):
        yield Unpacked(file)
        return
    from tempfile import TemporaryFile  # noqa: PLC0415 - for an archive only

    with TemporaryFile() as log:
        kind = "gzip" if magic.startswith(GZIP) else "zip"
        try:
            unpacker = Unpacker(file, log, path, os.fstat(file.fileno()).st_size)
            archive = _archive(kind, file, unpacker, path)
            archive.unpack()
            log.flush()
        except OSError as error:
            reason = error.strerror or str(error)
            raise UnreadableDataError(f"{path}: the {kind} archive cannot be unpacked: {reason}") from None
        faults = archive.faults()
        if faults and not unpacker.size:
            raise UnreadableDataError(
                f"{path}: the {kind} archive is damaged or of an unknown kind: nothing of it can be unpacked"
            )
        damage = f"the {kind} archive is damaged: {'; '.join(faults)}"
        yield Unpacked(log, (damage,) if faults else ())


def _archive(kind: str, file: IO[bytes], unpacker: Unpacker, path: object) -> "GzipArchive | ZipArchive":
    """The archive, with the module that unpacks its kind."""
    if kind == "gzip":
        from attest_mav.runtime.gzip_archive import GzipArchive  # noqa: PLC0415 - for an archive only

        return GzipArchive(unpacker)
    from attest_mav.runtime.zip_archive import ZipArchive  # noqa: PLC0415 - for an archive only

    return ZipArchive(file, unpacker, path)
