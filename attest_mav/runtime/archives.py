"""Logs in gzip or zip archives: unpacked into a temporary file without a name, of bounded size.

Of a damaged archive all is taken that can be unpacked, with a note that tells the loss.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import IO

from attest_mav.errors import UnreadableDataError
from attest_mav.runtime.gzip_archive import GZIP, GzipArchive
from attest_mav.runtime.unpacking import Unpacker
from attest_mav.runtime.zip_archive import ZIP, ZipArchive


@dataclass(frozen=True)
class Unpacked:
    """The log, and remarks on the archive that it comes from."""

    log: IO[bytes]
    notes: tuple[str, ...] = ()


@contextmanager
def unpacked(file: IO[bytes], path: object) -> Iterator[Unpacked]:
    """The file itself, or the log in the archive that it is; UnreadableDataError if nothing of it can be unpacked."""
    magic = file.read(len(ZIP))
    file.seek(0)
    if not magic.startswith((GZIP, ZIP)):
        yield Unpacked(file)
        return
    with tempfile.TemporaryFile() as log:
        kind = "gzip" if magic.startswith(GZIP) else "zip"
        try:
            unpacker = Unpacker(file, log, path, os.fstat(file.fileno()).st_size)
            archive = GzipArchive(unpacker) if kind == "gzip" else ZipArchive(file, unpacker, path)
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
