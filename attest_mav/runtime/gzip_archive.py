"""Logs in gzip archives: all members one behind the other, also those behind a damaged one."""

from typing import Final

from attest_mav.runtime.unpacking import PIECE_BYTES, UNSURE, Unpacker

MEMBER: Final = b"\x1f\x8b\x08"
"""Begin of a member: magic, and deflate, the one method there is."""
HEADER_BYTES: Final = 10
TRAILER_BYTES: Final = 8
MOST_HEADER: Final = 1 << 17
EXTRA: Final = 4
NAME: Final = 8
COMMENT: Final = 16
HEADER_CHECKSUM: Final = 2
RESERVED: Final = 0xE0
"""Bits of a member's flags."""
MOST_MEMBERS: Final = 1 << 16
MOST_FAULTS: Final = 64
"""After so many members, or damaged ones, no further one is looked for: bytes can be made to begin one everywhere."""


class GzipArchive:
    """Unpacks a gzip archive; ``faults`` says in which ways it is damaged."""

    def __init__(self, unpacker: Unpacker) -> None:
        self._unpacker: Final = unpacker
        self._length: Final = unpacker.packed_bytes
        self._lost = 0
        self._is_cut = False
        self._wrong = 0
        """Members with damaged bytes, a false header among them."""

    def unpack(self) -> None:
        """Unpack all members."""
        at = begin = members = 0
        while members < MOST_MEMBERS and self._wrong < MOST_FAULTS:
            begin = self._find_member(begin)
            if begin >= self._length:
                break
            data_at = self._data_at(begin)
            if data_at == 0:
                self._wrong += 1
                begin += 1
                continue
            self._lose(at, begin)
            begin = at = self._unpack_member(data_at)
            members += 1
        self._lose(at, self._length)

    def faults(self) -> list[str]:
        """The damage in words for people."""
        found = ["it is cut short"] if self._is_cut else []
        if self._lost:
            found.append(f"{self._lost} of its {self._length} bytes cannot be unpacked")
        return [*found, UNSURE] if self._wrong else found

    def _unpack_member(self, data_at: int) -> int:
        """Unpack a member, and compare it with its trailer; where it ends, or its damage begins."""
        at, is_complete = self._unpacker.inflate(data_at)
        if not is_complete and at < self._length:
            self._wrong += 1
            return at
        trailer = self._unpacker.read(at, TRAILER_BYTES)
        if len(trailer) < TRAILER_BYTES:
            self._is_cut = True
            return self._length
        told = int.from_bytes(trailer[:4], "little"), int.from_bytes(trailer[4:], "little")
        if told != (self._unpacker.checksum, self._unpacker.member_size % (1 << 32)):
            self._wrong += 1
        return at + TRAILER_BYTES

    def _find_member(self, at: int) -> int:
        """The next place where a member may begin; the length of the archive if there is none."""
        if self._unpacker.read(at, len(MEMBER)) == MEMBER:
            return at
        while piece := self._unpacker.read(at, PIECE_BYTES):
            found = piece.find(MEMBER)
            if found >= 0:
                return at + found
            if len(piece) < PIECE_BYTES:
                break
            at += len(piece) - len(MEMBER) + 1
        return self._length

    def _data_at(self, begin: int) -> int:
        """Place of the packed bytes of the member that begins here; 0 if its header is none."""
        head = self._unpacker.read(begin, MOST_HEADER)
        if len(head) < HEADER_BYTES or head[3] & RESERVED:
            return 0
        at = HEADER_BYTES
        if head[3] & EXTRA:
            at += 2 + int.from_bytes(head[at : at + 2], "little")
        for flag in (NAME, COMMENT):
            if head[3] & flag:
                end = head.find(b"\0", at)
                if end < 0:
                    return 0
                at = end + 1
        at += 2 if head[3] & HEADER_CHECKSUM else 0
        return begin + at if at <= len(head) else 0

    def _lose(self, begin: int, end: int) -> None:
        """Count the bytes between two members as lost; zeros are padding."""
        if self._unpacker.read(begin, min(end - begin, PIECE_BYTES)).strip(b"\0"):
            self._lost += end - begin
