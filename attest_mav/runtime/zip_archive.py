"""Logs in zip archives: the only file, by the directory at the end, or the first one where that is missing."""

import os
import zipfile
from dataclasses import dataclass
from struct import Struct
from typing import IO, Final

from attest_mav.errors import UnreadableDataError
from attest_mav.runtime.unpacking import UNSURE, ZIP, Unpacker

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
UNTOLD: Final = 8
"""Bits of a member's flags. UNTOLD: checksum and sizes stand behind it and not in its header."""
LARGE: Final = 0xFFFFFFFF
"""A size that stands elsewhere."""
SHOWN: Final = 3
"""So many members are named."""
RESOURCES: Final = "__MACOSX/"
_HEADER: Final = Struct("<4s2x2H4x3I2H")


@dataclass(frozen=True)
class Member:
    """A file in the archive."""

    name: str
    method: int
    flags: int
    at: int
    """Place of its bytes."""
    packed_size: int | None
    """None where the archive does not tell it; so ``size`` and ``checksum``."""
    size: int | None
    checksum: int | None

    @property
    def is_log(self) -> bool:
        """Whether it may be the log: no folder, and not what a Mac adds."""
        return not self.name.endswith("/") and not self.name.startswith(RESOURCES)


class ZipArchive:
    """Unpacks the log in a zip archive; ``faults`` says in which ways it is damaged."""

    def __init__(self, file: IO[bytes], unpacker: Unpacker, path: object) -> None:
        self._file: Final = file
        self._unpacker: Final = unpacker
        self._path: Final = path
        self._has_directory = True
        self._member: Member | None = None
        self._is_complete = False

    def unpack(self) -> None:
        """Unpack the only file of the archive, or the first one where the directory is missing."""
        self._member = member = self._listed() or self._first()
        if member is None:
            return
        if member.flags & ENCRYPTED:
            raise UnreadableDataError(f"{self._path}: the zip archive is encrypted: unpack it first")
        if member.method not in METHODS:
            raise UnreadableDataError(
                f"{self._path}: the zip archive is packed in a way that is unknown: unpack it first"
            )
        if member.method == zipfile.ZIP_DEFLATED:
            _, self._is_complete = self._unpacker.inflate(member.at)
        else:
            rest = self._unpacker.packed_bytes - member.at
            size = rest if member.packed_size is None else member.packed_size
            _, self._is_complete = self._unpacker.copy(member.at, member.at + size)

    def faults(self) -> list[str]:
        """The damage in words for people."""
        found = [] if self._has_directory else ["its directory is missing or wrong, so its first file is read"]
        member, read = self._member, self._unpacker.member_size
        if member is None:
            return found
        if not self._is_complete or member.size not in {None, read}:
            of_all = "" if member.size is None else f" of {member.size}"
            return [*found, f"{read}{of_all} bytes of the log can be unpacked", UNSURE]
        if member.checksum not in {None, self._unpacker.checksum}:
            return [*found, "its checksum does not fit", UNSURE]
        return found

    def _listed(self) -> Member | None:
        """The only file by the directory; None where that is missing or damaged."""
        self._require_small_directory()
        try:
            with zipfile.ZipFile(self._file) as archive:
                listed = archive.infolist()
        except (zipfile.BadZipFile, NotImplementedError, ValueError, EOFError, OSError):  # OSError: a place before 0
            return None
        members = [one for one in listed if not one.is_dir() and not one.filename.startswith(RESOURCES)]
        if len(members) != 1:
            names = ", ".join(one.filename for one in members[:SHOWN])
            some = f"{len(members)} files ({names}{', ...' if len(members) > SHOWN else ''})" if members else "no file"
            raise UnreadableDataError(f"{self._path}: the zip archive holds {some}; expected one log")
        one = members[0]
        header = self._header(one.header_offset)
        if header is None:
            return None
        flags = one.flag_bits & header.flags
        return Member(one.filename, one.compress_type, flags, header.at, one.compress_size, one.file_size, one.CRC)

    def _first(self) -> Member | None:
        """The first file that may be the log, by the files' own headers."""
        self._has_directory = False
        member = self._header(0)
        while member is not None and not member.is_log:
            member = None if member.packed_size is None else self._header(member.at + member.packed_size)
        return member

    def _header(self, at: int) -> Member | None:
        """The file whose header stands here; None if none does."""
        head = self._unpacker.read(at, _HEADER.size) if at >= 0 else b""
        if len(head) < _HEADER.size or not head.startswith(ZIP):
            return None
        _, flags, method, checksum, packed_size, size, name_bytes, extra_bytes = _HEADER.unpack(head)
        name = self._unpacker.read(at + _HEADER.size, name_bytes).decode("utf-8", "replace")
        data_at = at + _HEADER.size + name_bytes + extra_bytes
        if flags & UNTOLD or LARGE in {packed_size, size}:
            return Member(name, method, flags, data_at, None, None, None)
        return Member(name, method, flags, data_at, packed_size, size, checksum)

    def _require_small_directory(self) -> None:
        """An error for a directory of very many files, before all of it is read."""
        length = self._file.seek(0, os.SEEK_END)
        at = max(0, length - DIRECTORY_END_BYTES - LARGE_DIRECTORY_BYTES - MOST_COMMENT)
        tail = self._unpacker.read(at, length - at)
        at = tail.rfind(DIRECTORY_END)
        large = tail[max(0, at - LARGE_DIRECTORY_BYTES) : at].startswith(LARGE_DIRECTORY)
        if at >= 0 and (large or int.from_bytes(tail[at + 12 : at + 16], "little") > MOST_DIRECTORY):
            raise UnreadableDataError(
                f"{self._path}: the zip archive holds very many or very large files; expected one log"
            )
