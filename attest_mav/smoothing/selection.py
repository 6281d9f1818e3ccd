"""The median of more values than are held at a time, exactly: by counting the values that share leading bits.

The bits of a floating-point number, with the sign bit turned around and those of a negative number complemented, are in
the order of the numbers. Each pass over the values counts 16 bits more of those that begin like the one that is sought
(radix selection: Knuth, The Art of Computer Programming, vol. 3, sections 5.2.5 and 5.3.3).
"""

from collections.abc import Callable, Iterable
from math import nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.smoothing.rotations import Array

DIGIT_BITS: Final = 16
SIGN: Final = np.uint64(1 << 63)
Runs = Callable[[], Iterable[Array]]
"""Gives the values anew for each pass, in arrays of any length."""


def median(runs: Runs) -> float:
    """The median of all values; NaN where there are none."""
    count = sum(len(run) for run in runs())
    if not count:
        return nan
    low = _ordered(runs, (count - 1) // 2)
    return low if count % 2 else 0.5 * (low + _ordered(runs, count // 2))


def _ordered(runs: Runs, rank: int) -> float:
    """The value that has so many others before it."""
    key = 0
    for shift in range(64 - DIGIT_BITS, -1, -DIGIT_BITS):
        counts = np.zeros(1 << DIGIT_BITS, np.int64)
        for run in runs():
            counts += np.bincount(_digits(_keys(run), shift, key), minlength=len(counts))
        until = np.cumsum(counts)
        digit = int(np.searchsorted(until, rank, side="right"))
        rank -= int(until[digit] - counts[digit])
        key = key << DIGIT_BITS | digit
    bits = np.array([key], np.uint64)
    return float(np.where(bits & SIGN, bits ^ SIGN, ~bits).view(np.float64)[0])


def _keys(values: Array) -> NDArray[np.uint64]:
    """Integers in the order of the values."""
    bits = np.ascontiguousarray(values).view(np.uint64)
    out: NDArray[np.uint64] = np.where(bits & SIGN, ~bits, bits | SIGN)
    return out


def _digits(keys: NDArray[np.uint64], shift: int, leading: int) -> NDArray[np.int64]:
    """The next bits of the keys that have these leading ones."""
    begun = keys >> np.uint64(shift)
    mine = begun >> np.uint64(DIGIT_BITS) == leading
    out: NDArray[np.int64] = (begun[mine] & np.uint64((1 << DIGIT_BITS) - 1)).astype(np.int64)
    return out
