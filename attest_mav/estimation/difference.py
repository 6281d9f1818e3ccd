"""One attitude of the autopilot beside one of ours: how far apart, and whether our sigma explains that.

Tilt and heading are compared apart, never as Euler differences.
"""

from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import heading_between, hypotenuse, is_finite_number, tilt_between
from attest_mav.estimation.pairing import Carried
from attest_mav.types import North, Quat

TILT_SIGMAS: Final = 2.0
HEADING_SIGMAS: Final = 3.0
"""A difference must exceed this many of our sigmas. Heading errors last longer than tilt errors."""
SLOW_S: Final = 0.1
"""Inertial samples further apart hide motion: a lack of confidence is then put down to the rate."""
SLOW_TILT_SIGMAS: Final = 3.0
"""The same for the tilt beside such samples, where its error too lasts longer than a verdict takes."""


@mypyc_attr(acyclic=True)  # as Sample
class Member:
    """One attitude that is not refuted, as it stands beside the selected estimate.

    turn: body-side rotation from the selected attitude to this one. tilt_sigma, heading_sigma: rad.
    """

    def __init__(self, turn: Quat, tilt_sigma: float, heading_sigma: float) -> None:
        self.turn: Final = turn
        self.tilt_sigma: Final = tilt_sigma
        self.heading_sigma: Final = heading_sigma


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Difference:
    """The autopilot's attitude beside one of ours.

    tilt: rad, never negative. heading: rad, NaN without a common north. is_off: beyond what our sigma explains.
    tilt_is_near, heading_is_near: within the thresholds. reason: of the larger offence.
    """

    def __init__(
        self, tilt: float, heading: float, is_off: bool, tilt_is_near: bool, heading_is_near: bool, reason: str
    ) -> None:
        self.tilt: Final = tilt
        self.heading: Final = heading
        self.is_off: Final = is_off
        self.tilt_is_near: Final = tilt_is_near
        self.heading_is_near: Final = heading_is_near
        self.reason: Final = reason

    @property
    def is_near(self) -> bool:
        """True within both thresholds."""
        return self.tilt_is_near and self.heading_is_near


def difference_of(
    ours: Quat, member: Member, carried: Carried, theirs: Quat, threshold: float, share: float
) -> Difference:
    """The autopilot's attitude beside one of ours, a member of the set.

    threshold: smallest difference of tilt that counts, rad; share: of the limits, below which a difference is over.
    """
    estimate = carried.estimate
    tilt = tilt_between(ours, theirs)
    heading = heading_between(theirs, ours) if estimate.north == North.TRUE else nan
    tilt_sigmas = SLOW_TILT_SIGMAS if estimate.dt_s > SLOW_S else TILT_SIGMAS
    tilt_off = tilt > share * _limit(threshold, tilt_sigmas * member.tilt_sigma, carried.slack)
    heading_off = abs(heading) > share * _limit(2.0 * threshold, HEADING_SIGMAS * member.heading_sigma, carried.slack)
    tilt_near, heading_near = tilt <= threshold, not abs(heading) > 2.0 * threshold
    reason = "tilt" if tilt_off or (not heading_off and not tilt_near) else "heading"
    return Difference(tilt, heading, tilt_off or heading_off, tilt_near, heading_near, reason)


def _limit(threshold: float, uncertainty: float, slack: float) -> float:
    """The larger of threshold and uncertainty; a filter without covariance (NaN) has the threshold alone."""
    return hypotenuse(max(threshold, uncertainty) if is_finite_number(uncertainty) else threshold, slack)
