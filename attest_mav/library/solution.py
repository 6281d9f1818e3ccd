"""The outcome of a filter over arrays."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from attest_mav.algebra import q_to_euler
from attest_mav.innovation import Aid, Fusion
from attest_mav.library.frames import Frames
from attest_mav.types import North

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Innovations:
    """The measurements of the aids, one row each time an aid had something to say; see ``attest_mav.innovation``.

    Vectors are in FRD and NED whatever the frames of the readings are, and have as many elements as the aid has scalar
    measurements; the rest of the row is NaN.
    """

    reading: Numbers
    """Shape (m,), the row of the readings at which it was used or rejected."""
    aid: Numbers
    """Shape (m,), values of ``Aid``."""
    fusion: Numbers
    """Shape (m,), values of ``Fusion``: used, or why not."""
    residual: Array
    """Shape (m, 3), measured minus predicted, in the unit that ``Aid`` names."""
    variance: Array
    """Shape (m, 3), innovation variances; NaN for a filter without covariance."""

    def of(self, aid: Aid) -> "Innovations":
        """Those of one aid."""
        chosen = self.aid == int(aid)
        return Innovations(
            self.reading[chosen], self.aid[chosen], self.fusion[chosen], self.residual[chosen], self.variance[chosen]
        )

    @property
    def used(self) -> Flags:
        """Shape (m,), whether the measurement changed the state."""
        found: Flags = self.fusion <= int(Fusion.INFLATED)
        return found

    @property
    def nis(self) -> Array:
        """Shape (m,), normalised innovation squared, mean over the elements: 1 where the variances are true."""
        ratio = self.residual**2 / self.variance
        counts = np.isfinite(ratio).sum(axis=1)
        found: Array = np.where(counts > 0, np.nansum(ratio, axis=1) / np.maximum(counts, 1), np.nan)
        return found


def joined(parts: list[Innovations]) -> Innovations:
    """Those of successive stretches as one."""
    columns = [[getattr(part, one.name) for part in parts] for one in fields(Innovations)]
    return Innovations(*[np.concatenate(column) for column in columns])


@dataclass(frozen=True, eq=False)
class Solution:
    """The attitude after each reading, in the frames of the readings. Rows are NaN while there is no attitude."""

    t: Array
    """Shape (n,), s, as given."""
    attitudes: Array
    """Shape (n, 4), unit Hamilton quaternions (w, x, y, z) that turn body vectors into the world, sign-continuous.

    ``scipy.spatial.transform.Rotation.from_quat(q, scalar_first=True)`` takes them as they are; ROS and scipy's default
    have w last: ``q[:, [1, 2, 3, 0]]``.
    """
    tilt_sigma: Array
    """Shape (n,), 1-sigma of the tilt, rad; NaN for a filter without covariance."""
    heading_sigma: Array
    """Shape (n,), 1-sigma of the heading, rad; NaN for a filter without covariance."""
    gyro_biases: Array
    """Shape (n, 3), rad/s, body; the gyro shows the rate and this."""
    aligned: Flags
    """Shape (n,), whether there is an attitude."""
    north: North
    """The north that headings refer to at the end: true, magnetic, or none (the heading at the start is zero)."""
    frames: Frames
    find_innovations: Callable[[], Innovations] = field(repr=False)
    """Runs the filter over the readings once more, for ``innovations``."""

    @cached_property
    def innovations(self) -> Innovations:
        """The measurements of the aids. The first who asks waits for a second run of the filter over the readings."""
        return self.find_innovations()

    @property
    def euler(self) -> Array:
        """Shape (n, 3), roll, pitch and yaw, rad: turns about x of the body, then y, then z of the world."""
        rows: list[list[float]] = self.attitudes.tolist()
        return np.array([q_to_euler((w, x, y, z)) for w, x, y, z in rows]).reshape(-1, 3)


def continuous(attitudes: Array) -> Array:
    """The same attitudes with signs such that neighbours are near; NaN rows are passed over."""
    known = np.isfinite(attitudes[:, 0])
    rows = attitudes[known]
    jumps = np.ones(len(rows))
    jumps[1:] = np.where(np.einsum("ij,ij->i", rows[1:], rows[:-1]) < 0.0, -1.0, 1.0)
    found = attitudes.copy()
    found[known] = rows * np.cumprod(jumps)[:, None]
    return found


UNIT_QUATERNIONS: Final = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def in_frames(attitudes: Array, frames: Frames) -> Array:
    """Attitudes (FRD to NED), shape (n, 4), as attitudes of a convention. The change is linear in the components."""
    found: Array = attitudes @ np.array([frames.attitude(one) for one in UNIT_QUATERNIONS])
    return found
