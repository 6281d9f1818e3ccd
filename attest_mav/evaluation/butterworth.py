"""A fourth-order Butterworth high-pass run forwards and backwards, so that it shifts no phase.

Two second-order sections by the bilinear transform; the ends are extended by reflection through the end point, and
each pass starts in the steady state of its first value. This is what the usual signal libraries do by default.
"""

from math import pi, sin, tan
from typing import Final

import numpy as np

from attest_mav.evaluation.motion import Array

QUALITIES: Final = (0.5 / sin(pi / 8.0), 0.5 / sin(3.0 * pi / 8.0))
"""Quality factors of the two pole pairs of a fourth-order Butterworth filter."""

PADDING: Final = 15
"""Samples by which each end is extended: three times the number of coefficients of the whole filter."""


def highpass(values: Array, cutoff_hz: float, rate_hz: float) -> Array:
    """Each column of ``values``, shape (n, m) with n > 15, with what is slower than the cutoff removed."""
    return np.column_stack([_zero_phase(column, tan(pi * cutoff_hz / rate_hz)) for column in values.T])


def _zero_phase(x: Array, warped: float) -> Array:
    """One column, forwards and then backwards. ``warped``: tan(pi cutoff / rate)."""
    start = 2.0 * x[0] - x[PADDING:0:-1]
    end = 2.0 * x[-1] - x[-2 : -PADDING - 2 : -1]
    extended: list[float] = np.concatenate((start, x, end)).tolist()
    for _ in range(2):
        for quality in QUALITIES:
            extended = _section(extended, warped, quality)
        extended.reverse()
    return np.array(extended[PADDING:-PADDING])


def _section(x: list[float], warped: float, quality: float) -> list[float]:
    """g (1 - 2/z + 1/z^2) / (1 + a1/z + a2/z^2), transposed direct form II."""
    g = 1.0 / (1.0 + warped / quality + warped * warped)
    a1 = 2.0 * g * (warped * warped - 1.0)
    a2 = g * (1.0 - warped / quality + warped * warped)
    z1, z2 = -g * x[0], g * x[0]
    y = []
    for value in x:
        out = g * value + z1
        z1 = z2 - 2.0 * g * value - a1 * out
        z2 = g * value - a2 * out
        y.append(out)
    return y
