"""Unpacks deflated bytes into a log as far as they are intact: piece by piece, and at damage byte by byte.

zlib keeps what it has unpacked of a piece for itself when a later byte of the piece is wrong. So its state before each
piece is kept, from which the bytes are given to it once more, one at a time.
"""

import zlib
from typing import IO, Final

from attest_mav.errors import UnreadableDataError

GZIP: Final = b"\x1f\x8b"
ZIP: Final = b"PK\x03\x04"
"""The first bytes of an archive of each kind."""
MOST_BYTES: Final = 1 << 31
"""A log that is larger is not unpacked: a small archive can hold as much as it likes."""
MOST_RATIO: Final = 200
"""A log is packed into no less than a hundredth of its size, or nearly so: an archive that holds more is no log."""
FREE_BYTES: Final = 1 << 25
"""So many bytes are unpacked whatever the ratio."""
PIECE_BYTES: Final = 1 << 16
"""Packed bytes read at once."""
MOST_AT_ONCE: Final = 1 << 18
"""Unpacked bytes held at once."""
UNSURE: Final = "records without a checksum of their own may be wrong"
"""A remark on damaged bytes: the damage is noticed behind the first bytes that it has made wrong."""


class Unpacker:
    """Unpacks the members of one archive, of so many bytes, into a log."""

    def __init__(self, file: IO[bytes], log: IO[bytes], path: object, packed_bytes: int) -> None:
        self.size = 0
        """Bytes of the log so far."""
        self.member_size = 0
        """Those of the newest member."""
        self.checksum = 0
        """Its CRC-32."""
        self.packed_bytes: Final = packed_bytes
        self._file: Final = file
        self._log: Final = log
        self._path: Final = path

    def read(self, at: int, size: int) -> bytes:
        """Bytes of the archive."""
        self._file.seek(at)
        return self._file.read(size)

    def copy(self, at: int, end: int) -> tuple[int, bool]:
        """Take a member that is not packed; where it ends, and whether it is complete."""
        self._begin_member()
        while at < end and (piece := self.read(at, min(PIECE_BYTES, end - at))):
            self._write(piece)
            at += len(piece)
        return at, at == end

    def inflate(self, at: int) -> tuple[int, bool]:
        """Unpack the member that begins here; where it ends, or its damage begins, and whether it is complete."""
        self._begin_member()
        inflater = zlib.decompressobj(-zlib.MAX_WBITS)
        packed, found = b"", b""
        while not inflater.eof:
            if not packed and len(found) < MOST_AT_ONCE:
                packed = self.read(at, PIECE_BYTES)
                if not packed:
                    return at, False
                at += len(packed)
            before = inflater.copy()
            try:
                found = inflater.decompress(packed, MOST_AT_ONCE)
            except zlib.error:
                return at - len(packed) + self._inflate_singly(before, packed), False
            self._write(found)
            packed = inflater.unconsumed_tail
        return at - len(inflater.unused_data), True

    def _inflate_singly(self, inflater: "zlib._Decompress", packed: bytes) -> int:
        """Unpack the bytes before the one that cannot be unpacked; the number of them."""
        for index in range(len(packed)):
            try:
                self._write(inflater.decompress(packed[index : index + 1]))
            except zlib.error:
                return index
        return len(packed)

    def _begin_member(self) -> None:
        self.member_size, self.checksum = 0, 0

    def _write(self, piece: bytes) -> None:
        """Add to the log; an error where it becomes too long, in all or for the bytes that it was packed into."""
        self.size += len(piece)
        self.member_size += len(piece)
        self.checksum = zlib.crc32(piece, self.checksum)
        if self.size > FREE_BYTES and self.size > MOST_RATIO * self.packed_bytes:
            raise UnreadableDataError(
                f"{self._path}: the archive holds over {MOST_RATIO} times its own size, as no log does"
            )
        if self.size > MOST_BYTES:
            limit = f"{MOST_BYTES >> 20} MiB"
            raise UnreadableDataError(f"{self._path}: the archive holds more than {limit}: unpack it first")
        self._log.write(piece)
