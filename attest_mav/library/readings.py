"""Sensor readings in arrays, checked once."""

from collections.abc import Callable
from math import nan
from typing import Final

import numpy as np
import numpy.typing as npt

from attest_mav.errors import ArgumentError
from attest_mav.estimation.sequence import velocity_fix
from attest_mav.library.frames import Frames, frames_named
from attest_mav.samples import VelocitySample
from attest_mav.types import EarthField, Vec3

Array = npt.NDArray[np.float64]

NS: Final = 1e9
_AXES: Final[tuple[Vec3, ...]] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Readings:
    """The readings of one inertial sensor, with what aids it. Rows are in order of time.

    The axes are those of ``frames``: "FRD/NED", "FLU/ENU" or "FLU/NWU". The accelerometer measures specific force: at
    rest it shows g upwards, which is (0, 0, -9.8) in FRD and (0, 0, +9.8) in FLU. A row that is not finite is a missing
    reading; a ``velocity`` whose vertical component alone is NaN is a horizontal one.

    ::

        Readings(t, gyro, accel, mag, velocity)                  # a row of velocity for each of t
        Readings(t, gyro, accel, mag, fixes, velocity_t=t_fix)   # fixes at times of their own

    ArgumentError (a ValueError) names the argument that does not fit.
    """

    def __init__(
        self,
        t: npt.ArrayLike,
        gyro: npt.ArrayLike,
        accel: npt.ArrayLike,
        mag: npt.ArrayLike | None = None,
        velocity: npt.ArrayLike | None = None,
        *,
        velocity_t: npt.ArrayLike | None = None,
        velocity_sigma: npt.ArrayLike | None = None,
        declination: float = nan,
        inclination: float = nan,
        frames: str = "FRD/NED",
    ) -> None:
        self.frames: Final[Frames] = frames_named(frames)
        """The axes of the arrays as they were given; below, everything is in FRD and NED."""
        self.t: Final = _times("t", t)
        """Shape (n,), s, increasing."""
        count = len(self.t)
        body = self.frames.body_vector
        self.gyro: Final = _turned(_rows("gyro", gyro, count), body)
        """Shape (n, 3), rad/s, body."""
        self.accel: Final = _turned(_rows("accel", accel, count), body)
        """Shape (n, 3), specific force, m/s^2, body."""
        self.mag: Final = None if mag is None else _turned(_rows("mag", mag, count), body)
        """Shape (n, 3), gauss, body, or None. The gradient-descent filter takes any linear unit."""
        if velocity is None and (velocity_t is not None or velocity_sigma is not None):
            raise ArgumentError("velocity_t and velocity_sigma belong to a velocity; expected velocity too")
        self.velocity_t: Final = self.t if velocity_t is None else _times("velocity_t", velocity_t)
        """Shape (m,), s, the time of each fix on the clock of ``t``."""
        fixes = len(self.velocity_t)
        world = self.frames.world_vector
        self.velocity: Final = None if velocity is None else _turned(_rows("velocity", velocity, fixes), world)
        """Shape (m, 3), over ground, m/s, NED, or None."""
        self.velocity_sigma: Final = None if velocity_sigma is None else _sigmas(velocity_sigma, fixes)
        """Shape (m,), the receiver's own uncertainty, m/s an axis, or None."""
        self.field: Final = EarthField(declination, inclination)
        """Declination (east positive) and inclination (below the horizontal) of the Earth's field, rad."""

    def __len__(self) -> int:
        return len(self.t)

    def fixes(self) -> list[VelocitySample]:
        """The velocity as fixes, without the rows that are missing."""
        if self.velocity is None:
            return []
        usable = np.isfinite(self.velocity[:, :2]).all(axis=1)
        times = nanoseconds(self.velocity_t[usable])
        sigmas = [nan] * len(times) if self.velocity_sigma is None else self.velocity_sigma[usable].tolist()
        rows = self.velocity[usable].tolist()
        return [
            velocity_fix(t_ns, (x, y, z), sigma) for t_ns, (x, y, z), sigma in zip(times, rows, sigmas, strict=True)
        ]


def nanoseconds(t: Array) -> list[int]:
    """Times in seconds as whole nanoseconds."""
    found: list[int] = np.rint(t * NS).astype(np.int64).tolist()
    return found


def _turned(rows: Array, turn: Callable[[Vec3], Vec3]) -> Array:
    """Each row turned by an exchange of axes with signs, whose effect on the axes shows it; NaN stays in its place."""
    images = np.array([turn(axis) for axis in _AXES])
    sources = np.abs(images).argmax(axis=0)
    found: Array = np.ascontiguousarray(rows[:, sources] * images[sources, [0, 1, 2]])
    return found


def _numbers(name: str, values: npt.ArrayLike) -> Array:
    """The argument as floats."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name}: expected numbers ({error})") from None


def _times(name: str, values: npt.ArrayLike) -> Array:
    found = _numbers(name, values)
    if found.ndim != 1 or not len(found):
        raise ArgumentError(f"{name} has shape {found.shape}; expected (n,), seconds, at least one")
    if not np.isfinite(found).all():
        raise ArgumentError(f"{name}[{int(np.argmin(np.isfinite(found)))}] is not finite; expected seconds")
    steps = np.diff(found)
    if len(steps) and not steps.min() > 0.0:
        row = int(np.argmin(steps > 0.0)) + 1
        raise ArgumentError(
            f"{name}[{row}] = {found[row]:.9g} does not follow {found[row - 1]:.9g}; expected later times"
        )
    return found


def _rows(name: str, values: npt.ArrayLike, count: int) -> Array:
    found = _numbers(name, values)
    if found.shape != (count, 3):
        raise ArgumentError(f"{name} has shape {found.shape}; expected ({count}, 3), a row for each time")
    return found


def _sigmas(values: npt.ArrayLike, count: int) -> Array:
    found = _numbers("velocity_sigma", values)
    if found.shape != (count,):
        raise ArgumentError(f"velocity_sigma has shape {found.shape}; expected ({count},), a number for each fix")
    return found
