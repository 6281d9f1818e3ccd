"""The whole field vector in NED beside its mean: two of three gyro axes show in it, ten times a second."""

from typing import Final

from attest_mav.algebra import add, norm, scale, sub
from attest_mav.types import Vec3

MEAN_S: Final = 5.0
"""Time constant of the mean direction."""
USUAL_SHARE: Final = 0.02
"""Share of a new residual in the usual one."""
USUAL_AT_START: Final = 0.006
LEAST_NOISE: Final = 0.012
"""A residual counts as a multiple of this, or of twice the usual one if that is more."""
LARGEST_SQUARE: Final = 16.0
"""A residual counts for no more than four of those."""
HELD_LEAST: Final = 0.02
HELD_USUALS: Final = 3.0
HELD_S: Final = 3.0
"""A residual beyond both does not move the mean for so long: it may be the attitude's, and then that is found by it."""
CALM_REACH: Final = 3.0
"""A residual beyond this many of the usual ones does not move the usual one."""


class FieldWatch:
    """Follows one lane's field."""

    def __init__(self) -> None:
        self.residual = 0.0
        """Distance of the newest direction from the mean, as a share of the field."""
        self.score = 0.0
        """Evidence against the attitude in it, 0 to 4."""
        self.t_ns = -1
        """Time of the newest reading; -1 before the first."""
        self.usual = USUAL_AT_START
        """The usual residual."""
        self._mean: Vec3 | None = None
        self._off_s = 0.0
        """For so long the residual has been too large to move the mean."""

    @property
    def mean(self) -> Vec3 | None:
        """The mean direction, NED; None before the first reading."""
        return self._mean

    def take(self, direction: Vec3, t_ns: int, calm: bool) -> None:
        """Take a new reading. Only in calm times does it move the mean."""
        mean = direction if self._mean is None else self._mean
        elapsed_s = (t_ns - self.t_ns) * 1e-9 if self.t_ns >= 0 else 0.0
        self.t_ns = t_ns
        self.residual = norm(sub(direction, mean))
        self.score = self.score_of(self.residual)
        is_off = self.residual > max(HELD_LEAST, HELD_USUALS * self.usual)
        self._off_s = self._off_s + max(0.0, elapsed_s) if is_off else 0.0
        if self._mean is None or (calm and not 0.0 < self._off_s < HELD_S):
            self._mean = add(mean, scale(sub(direction, mean), min(1.0, max(0.0, elapsed_s) / MEAN_S)))
            self.usual += USUAL_SHARE * (min(self.residual, CALM_REACH * self.usual) - self.usual)

    def residual_of(self, direction: Vec3) -> float:
        """The residual of another attitude's direction."""
        return 0.0 if self._mean is None else norm(sub(direction, self._mean))

    def score_of(self, residual: float) -> float:
        """Evidence against an attitude in a residual."""
        share = residual / max(LEAST_NOISE, 2.0 * self.usual)
        return 0.25 * min(share * share, LARGEST_SQUARE)

    def shift(self, by: Vec3) -> None:
        """The field itself has changed by this."""
        if self._mean is not None:
            self._mean = add(self._mean, by)
