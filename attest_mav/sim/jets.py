"""The small calculus that makes the motions exact.

A *jet* is a value together with its first three time derivatives. Sums and products of jets are jets, so a path
written as jets has its velocity, acceleration and jerk without a numerical derivative, at any time, in any order.
"""

from math import cos, sin
from typing import Final

Jet = tuple[float, float, float, float]
"""(x, dx/dt, d2x/dt2, d3x/dt3)."""

ZERO: Final[Jet] = (0.0, 0.0, 0.0, 0.0)


def constant(value: float) -> Jet:
    """A value that never changes."""
    return (value, 0.0, 0.0, 0.0)


def plus(a: Jet, b: Jet) -> Jet:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3])


def times(a: Jet, b: Jet) -> Jet:
    """a b, by Leibniz's rule."""
    return (
        a[0] * b[0],
        a[1] * b[0] + a[0] * b[1],
        a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2],
        a[3] * b[0] + 3.0 * a[2] * b[1] + 3.0 * a[1] * b[2] + a[0] * b[3],
    )


def scaled(a: Jet, k: float) -> Jet:
    """k a, k constant."""
    return (k * a[0], k * a[1], k * a[2], k * a[3])


def sine(t: float, amplitude: float, omega: float, phase: float) -> Jet:
    """amplitude sin(omega t + phase)."""
    s = amplitude * sin(omega * t + phase)
    c = amplitude * omega * cos(omega * t + phase)
    return (s, c, -omega * omega * s, -omega * omega * c)


def smooth_step(t: float, start: float, duration: float) -> Jet:
    """From 0 to 1 between ``start`` and ``start + duration``; the first three derivatives are zero at both ends.

    S(x) = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7, the polynomial of least degree that does so.
    """
    x = (t - start) / duration
    if x <= 0.0:
        return ZERO
    if x >= 1.0:
        return (1.0, 0.0, 0.0, 0.0)
    u = x * (1.0 - x)
    slope = 1.0 - 2.0 * x
    return (
        x**4 * (35.0 - x * (84.0 - x * (70.0 - 20.0 * x))),
        140.0 * u**3 / duration,
        420.0 * u * u * slope / duration**2,
        840.0 * u * (slope * slope - u) / duration**3,
    )


def smooth_ramp(t: float, start: float, duration: float) -> Jet:
    """The integral of ``smooth_step``: at rest before ``start``, slope 1 after ``start + duration``."""
    step = smooth_step(t, start, duration)
    x = (t - start) / duration
    if x <= 0.0:
        return ZERO
    value = duration * x**5 * (7.0 - x * (14.0 - x * (10.0 - 2.5 * x))) if x < 1.0 else t - start - 0.5 * duration
    return (value, step[0], step[1], step[2])
