"""A low-pass for vectors whose samples come at any interval: Butterworth, second order.

    y'' + 2 y'/T + 2 (y - u)/T^2 = 0

Its poles are (-1 +- i)/T, its corner is sqrt(2)/T rad/s, and a constant input is reached without ringing to speak of
(4 %). Between two samples the input is taken for constant; the solution is then exact for any interval, so that a gap
does no more than its length deserves.
"""

from math import cos, exp, sin
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.record import Record
from attest_mav.types import Vec3


@mypyc_attr(acyclic=True)
class Smoothed(Record):
    """The low-pass after a sample. value: y. slope: T y', in the unit of y."""

    def __init__(self, value: Vec3, slope: Vec3) -> None:
        self.value: Final = value
        self.slope: Final = slope


def steady(value: Vec3) -> Smoothed:
    """The low-pass of an input that has always been this."""
    return Smoothed(value, (0.0, 0.0, 0.0))


def smoothed(before: Smoothed, reading: Vec3, dt_s: float, time_s: float) -> Smoothed:
    """The low-pass after ``dt_s`` more seconds with this input; time_s: T.

    With d = y - u and times in T: d = e^-t (d0 (cos t + sin t) + v0 sin t), v = e^-t (v0 (cos t - sin t) - 2 d0 sin t).
    """
    t = dt_s / time_s
    fading = exp(-t)
    c, s = fading * cos(t), fading * sin(t)
    both, less, twice = c + s, c - s, 2.0 * s
    y, v = before.value, before.slope
    d_x, d_y, d_z = y[0] - reading[0], y[1] - reading[1], y[2] - reading[2]
    return Smoothed(
        (
            reading[0] + both * d_x + s * v[0],
            reading[1] + both * d_y + s * v[1],
            reading[2] + both * d_z + s * v[2],
        ),
        (less * v[0] - twice * d_x, less * v[1] - twice * d_y, less * v[2] - twice * d_z),
    )


def aliased_share(cutoff_hz: float, dt_s: float) -> float:
    """The part of a signal's motion between two samples that the samples may miss, 0 to 1.

    x^4 / (1 + x^4) with x = cutoff_hz dt_s, the power that a second-order Butterworth low-pass leaves of a motion at
    the rate of the samples: one far below that rate leaves nothing to miss. 1 where there is no low-pass (cutoff_hz
    = 0).
    """
    if cutoff_hz <= 0.0:
        return 1.0
    x = cutoff_hz * dt_s
    fourth = x * x * x * x
    return fourth / (1.0 + fourth)
