"""Coasting: no lane takes a fix, the innovations are only watched, until the receiver makes sense again.

The attitude lives on changes of the velocity, so a receiver makes sense again when its error is steady, whatever the
error is. One that is late shows it by innovations that follow the lane's own velocity.
"""

from collections import deque
from math import hypot, sqrt
from typing import Final

from attest_mav.algebra import sub
from attest_mav.estimation.witness.contradiction import shifts_beside
from attest_mav.estimation.witness.flight_state import FixRecord, fix_lag_of
from attest_mav.estimation.witness.moments import Moments
from attest_mav.types import Vec3

STEADY_FIXES: Final = 15
STEADY_SHARE: Final = 0.5
LONGEST_STEADY_FIXES: Final = 30
"""Innovations must be steady over the first number of fixes, or this share of those that came before, at most the last
number: a velocity that wanders pauses by chance."""
STEADY_SIGMA: Final = 0.2
STEADY_USUALS: Final = 2.0
"""Innovations are steady when each axis scatters by less than both limits, m/s."""
LARGEST_OFFSET: Final = 15.0
"""m/s: a larger steady error is only believed while the magnetic field fits."""
LATE_FIXES: Final = 15
MOVING: Final = 0.15
"""m/s: a shift can be seen where the velocity differs by more over the fixes, standard deviation of an axis."""
LATE_SHARE: Final = 0.03
LATE_RMS: Final = 0.12
LATE_MEAN: Final = 1.0
"""Largest remaining share of the innovations' scatter, remaining rms and mean in m/s, where the receiver is late."""
SUSPECT_SHARE: Final = 0.3
SUSPECT_RMS: Final = 0.3
"""With less left than this the receiver may be late: it is not believed for any other reason."""
LATE_REMEMBERED: Final = 25
"""Fixes in which a delay is looked for."""


class Lateness:
    """How well a shift of the fixes explains the innovations.

    share, share_whole: of the scatter, and of the mean square, that is left. rms, mean: of the remainder, m/s.
    """

    def __init__(
        self, shift_s: float, moving: float, share: float, rms: float, mean: float, share_whole: float, rms_whole: float
    ) -> None:
        self.shift_s: Final = shift_s
        self.moving: Final = moving
        self.share: Final = share
        self.rms: Final = rms
        self.mean: Final = mean
        self.share_whole: Final = share_whole
        self.rms_whole: Final = rms_whole

    @property
    def is_proven(self) -> bool:
        """True where the receiver is late by this."""
        return self.moving > MOVING and self.share < LATE_SHARE and self.rms < LATE_RMS and self.mean < LATE_MEAN

    @property
    def is_suspected(self) -> bool:
        """True where it may be."""
        follows = self.moving > MOVING and self.share < SUSPECT_SHARE and self.mean < LATE_MEAN
        return follows or (self.rms_whole > SUSPECT_RMS and self.share_whole < SUSPECT_SHARE)


class _WatchedFix:
    """An innovation, and the change of velocity to each shifted instant; m/s."""

    def __init__(self, innovation: Vec3, shifts: list[Vec3]) -> None:
        self.innovation: Final = innovation
        self.shifts: Final = shifts


class Coasting:
    """The fixes received while coasting, and their fit to a delay.

    usual: size of an innovation before, m/s. shift_s: by which fixes are older than they say.
    """

    def __init__(self, usual: float, shift_s: float) -> None:
        self.shifts_s: Final = shifts_beside(shift_s)
        """Shifts of the fixes that are tried, s."""
        self._present_s: Final = shift_s
        self._limit: Final = max(STEADY_SIGMA, STEADY_USUALS * usual)
        self._fixes: Final[deque[_WatchedFix]] = deque(maxlen=LONGEST_STEADY_FIXES)
        self._count = 0

    def take(self, record: FixRecord, moments: Moments) -> None:
        """Take the next fix that no lane uses."""
        newest = moments.newest
        if newest is None:
            return
        instant_ns = record.t_ns - int(1e9 * fix_lag_of(newest.state))
        then = velocity_at(moments, instant_ns)
        shifts = [
            sub(velocity_at(moments, instant_ns - int(1e9 * (shift_s - self._present_s))), then)
            for shift_s in self.shifts_s
        ]
        self.add(record.innovation, shifts)

    def add(self, innovation: Vec3, shifts: list[Vec3]) -> None:
        """Record an innovation, m/s. shifts: change of the velocity to the instant of each shift, m/s."""
        self._count += 1
        self._fixes.append(_WatchedFix(innovation, shifts))

    def is_steady(self, field_fits: bool) -> bool:
        """True when the receiver's error is steady."""
        before = self._count / (1.0 + STEADY_SHARE)
        needed = min(max(STEADY_FIXES, int(STEADY_SHARE * before)), LONGEST_STEADY_FIXES)
        if len(self._fixes) < needed:
            return False
        recent = list(self._fixes)[-needed:]
        north = [fix.innovation[0] for fix in recent]
        east = [fix.innovation[1] for fix in recent]
        offset = hypot(_mean(north), _mean(east))
        near = offset <= LARGEST_OFFSET or field_fits
        return near and max(_deviation(north), _deviation(east)) < self._limit

    def lateness(self) -> Lateness | None:
        """The shift that explains the innovations best; None while there are too few."""
        if len(self._fixes) < LATE_FIXES:
            return None
        found = [self._lateness_of(place) for place in range(len(self.shifts_s))]
        return min(found, key=lambda one: one.rms)

    def _lateness_of(self, place: int) -> Lateness:
        left: list[list[float]] = [[], []]
        given: list[list[float]] = [[], []]
        moved: list[list[float]] = [[], []]
        for fix in list(self._fixes)[-LATE_REMEMBERED:]:
            for axis in range(2):
                x = fix.shifts[place][axis]
                left[axis].append(fix.innovation[axis] - x)
                given[axis].append(fix.innovation[axis])
                moved[axis].append(x)
        scatter = _square(_deviation(given[0])) + _square(_deviation(given[1]))
        scatter_left = _square(_deviation(left[0])) + _square(_deviation(left[1]))
        whole, whole_left = _mean_square(given), _mean_square(left)
        return Lateness(
            self.shifts_s[place],
            max(_deviation(moved[0]), _deviation(moved[1])),
            scatter_left / max(scatter, 1e-9),
            sqrt(scatter_left),
            hypot(_mean(left[0]), _mean(left[1])),
            whole_left / max(whole, 1e-9),
            sqrt(whole),
        )


def velocity_at(moments: Moments, t_ns: int) -> Vec3:
    """The lane's own velocity then, NED, m/s; the nearest one where the moments do not reach."""
    before, after = moments.around(t_ns)
    if before is None or after is None:
        nearest = before or after
        return (0.0, 0.0, 0.0) if nearest is None else nearest.velocity
    share = (t_ns - before.t_ns) / (after.t_ns - before.t_ns)
    a, b = before.velocity, after.velocity
    return (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2]))


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)


def _deviation(values: list[float]) -> float:
    mean = _mean(values)
    return sqrt(sum([_square(value - mean) for value in values]) / len(values))


def _mean_square(axes: list[list[float]]) -> float:
    """Of both axes together."""
    return sum([_square(value) for value in axes[0]]) / len(axes[0]) + sum([_square(value) for value in axes[1]]) / len(
        axes[1]
    )


def _square(value: float) -> float:
    return value * value
