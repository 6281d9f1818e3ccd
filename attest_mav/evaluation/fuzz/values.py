"""Random payloads of messages: plausible, extreme, and not finite values."""

from math import inf, nan
from random import Random
from struct import Struct, calcsize
from typing import Final

from attest_mav.mavlink.dialect import Layout

FLOATS: Final = (0.0, -0.0, 1.0, -1.0, nan, inf, -inf, 3.4e38, -3.4e38, 1e-45, 1e10, 1e20, 9.80665, 6.3, 360.0)
TEXTS: Final = (b"INS_GYRO_FILTER", b"GPS1_DELAY_MS", b"AHRS_TRIM_X", b"COMPASS_DEC", b"EKF2_GPS_DELAY", b"\xff" * 16)


def payload(rng: Random, layout: Layout, share: float, base: bytes = b"") -> bytes:
    """``base`` with this share of its fields replaced."""
    data = bytearray(base.ljust(layout.size, b"\0"))
    offset = 0
    for code in layout.codes:
        size = calcsize("<" + code)
        if rng.random() < share:
            data[offset : offset + size] = _field(rng, code, size)
        offset += size
    return bytes(data)


def _field(rng: Random, code: str, size: int) -> bytes:
    """One field, or all elements of an array."""
    kind = code[-1]
    if kind == "s":
        return rng.choice((rng.choice(TEXTS)[:size].ljust(size, b"\0"), rng.randbytes(size)))
    structure = Struct("<" + kind)
    return b"".join(_number(rng, kind, structure) for _ in range(size // structure.size))


def _number(rng: Random, kind: str, structure: Struct) -> bytes:
    if kind in "fd":
        way = rng.random()
        if way < 0.2:
            return rng.randbytes(structure.size)
        return structure.pack(rng.choice(FLOATS) if way < 0.6 else rng.gauss(0.0, 10.0 ** rng.uniform(-3.0, 6.0)))
    if rng.random() < 0.4:
        return rng.choice((b"\0", b"\xff")) * structure.size
    if rng.random() < 0.5:
        return (rng.randrange(256)).to_bytes(structure.size, "little")
    return rng.randbytes(structure.size)
