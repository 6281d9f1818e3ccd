"""A steady offset between two attitudes that agree otherwise, where the autopilot's trim is not known.

ArduPilot reports its attitude turned by AHRS_TRIM, which the inertial messages do not have. Where the setting cannot be
read, the mean difference of the first seconds is taken for it once, and frozen: an offset that arises later stays a
disagreement.
"""

from math import hypot, radians
from typing import Final

from attest_mav.algebra import q_conj, q_continuous, q_exp, q_from_euler, q_mul, q_to_euler, scale
from attest_mav.samples import AttitudeSample
from attest_mav.types import AttitudeForm, Quat, Vec3

FIT_S: Final = 5.0
"""The difference is averaged over this long, s."""
FIT_SAMPLES: Final = 5
LARGEST: Final = radians(12.0)
"""ArduPilot limits a calibrated trim to 10 degrees an axis."""
SCATTER: Final = radians(1.0)
"""Standard deviation of the difference while it is averaged: above this it is no steady one."""
SMALLEST: Final = radians(1.0)
"""A smaller offset is none: both attitudes agree."""
OWN_SIGMAS: Final = 2.0
"""A larger one of less than so many of our own tilt sigmas may be our error: it is measured again."""


class OffsetMonitor:
    """Finds the offset of one source. ``angles``: roll and pitch of the trim, rad, None until there is one."""

    def __init__(self) -> None:
        self.angles: tuple[float, float] | None = None
        self.frozen = False
        self._first_ns = -1
        self._count = 0
        self._sum = (0.0, 0.0)
        self._square = 0.0

    def learn(self, ours: Quat, reference: AttitudeSample, tilt_sigma: float) -> None:
        """Average one more pair of attitudes, until the offset is frozen. tilt_sigma: of ours, rad, or NaN."""
        if self.frozen:
            return
        x, y = difference(ours, reference)
        if self._first_ns < 0:
            self._first_ns = reference.t_ns
        self._count += 1
        self._sum = (self._sum[0] + x, self._sum[1] + y)
        self._square += x * x + y * y
        if (reference.t_ns - self._first_ns) * 1e-9 < FIT_S or self._count < FIT_SAMPLES:
            return
        mean = (self._sum[0] / self._count, self._sum[1] / self._count)
        size = hypot(*mean)
        scatter_sq = self._square / self._count - size * size
        if scatter_sq > SCATTER * SCATTER or SMALLEST < size < OWN_SIGMAS * tilt_sigma:
            self._first_ns, self._count, self._sum, self._square = -1, 0, (0.0, 0.0), 0.0
            return
        self.frozen = True
        if SMALLEST < size < LARGEST:
            self.angles = mean

    def may_be_trim(self, tilt: float) -> bool:
        """True while the offset is being measured, for a difference (rad) that a trim could make."""
        return not self.frozen and tilt < LARGEST

    def undone(self, reference: AttitudeSample) -> Quat:
        """The reference without the offset."""
        if self.angles is None:
            return reference.q_nb
        x, y = self.angles
        if reference.form == AttitudeForm.EULER:
            roll, pitch, yaw = q_to_euler(reference.q_nb)
            return q_from_euler(roll + x, pitch + y, yaw)
        return q_mul(reference.q_nb, q_exp((0.5 * x, 0.5 * y, 0.0)))


def difference(ours: Quat, reference: AttitudeSample) -> tuple[float, float]:
    """Ours less the reference in the form of the message, rad: roll and pitch, or a body-side rotation vector."""
    if reference.form == AttitudeForm.EULER:
        mine, theirs = q_to_euler(ours), q_to_euler(reference.q_nb)
        return (mine[0] - theirs[0], mine[1] - theirs[1])
    _, x, y, z = q_continuous(q_mul(q_conj(reference.q_nb), ours), (1.0, 0.0, 0.0, 0.0))
    vector: Vec3 = scale((x, y, z), 2.0)
    return (vector[0], vector[1])
