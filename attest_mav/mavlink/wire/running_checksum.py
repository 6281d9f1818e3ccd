"""The checksum of any stretch of one buffer in constant time, after one pass over the buffer.

The CRC is linear: with P(k) the register after the first k bytes, started from zero, the register after the bytes
``start`` to ``stop``, started from I, is P(stop) ^ S(P(start) ^ I), where S lets ``stop - start`` zero bytes pass. S is
two look-ups in tables, one for each byte of the register; the tables of a length are made when it is first met.

A plain pass over each candidate is quicker as long as candidates are few. Bytes that are made to be candidates
everywhere would cost 260 passes a byte.
"""

from typing import Final

from fastcrc.crc16 import mcrf4xx
from mypy_extensions import i64

from attest_mav.mavlink.wire.checksum import stepped

START: Final = 0xFFFF
MAX_LENGTH: Final = 280
"""Above the number of bytes that a checksum covers."""


class ZeroTables:
    """Registers after so many zero bytes, for each value of one byte of the register before them."""

    def __init__(self, length: int) -> None:
        zeros = bytes(length)
        bits = [mcrf4xx(zeros, 1 << bit) for bit in range(16)]
        self.low: Final = _combinations(bits[:8])
        self.high: Final = _combinations(bits[8:])


class RunningChecksum:
    """Checksums in one buffer."""

    def __init__(self, data: bytes, tables: list[ZeroTables | None]) -> None:
        """``tables``: by length, ``MAX_LENGTH`` of them; filled as needed, to be kept for the next buffer."""
        self._tables: Final = tables
        register: i64 = 0
        registers = [0]
        for byte in data:
            register = stepped(register, byte)
            registers.append(register)
        self._registers: Final = registers

    def crc(self, start: i64, stop: i64, extra: i64) -> i64:
        """The same as ``checksum.checksum`` of this buffer."""
        length: i64 = stop - start
        tables = self._tables[length]
        if tables is None:
            tables = self._tables[length] = ZeroTables(length)
        register: i64 = self._registers[start]
        register ^= START
        passed: i64 = tables.low[register & 0xFF] ^ tables.high[register >> 8]
        return stepped(self._registers[stop] ^ passed, extra)


def _combinations(bits: list[int]) -> list[int]:
    """The sums (exclusive or) of all subsets of eight values, by the subset's bits."""
    sums = [0]
    for value in bits:
        sums += [one ^ value for one in sums]
    return sums
