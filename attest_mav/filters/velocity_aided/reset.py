"""Gaps and resets: when an attitude is lost, and how uncertain it is afterwards.

A reset is an alignment begun again because the innovations contradict the state. (Innovation monitoring and recovery:
Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., chapter 17.)
"""

from math import exp
from typing import Final

from attest_mav.algebra import dot, heading_between, tilt_between
from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.alignment.solve import ASSUMED_GRAVITY_TILT, AlignmentMethod
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.navigation import AidingMode, Navigation
from attest_mav.types import Quat

LONGEST_GAP_S: Final = 1.0
"""Where samples are missing for longer the attitude is lost, and alignment begins again, s."""
LONGEST_STEP_S: Final = 3.0
"""The same of a step of usual length: a stream of 1 Hz is slow, and has no gap in it."""
UNSEEN_GAP_S: Final = 0.25
"""Where samples are missing for longer a rotation may have gone unseen, s,"""
UNSEEN_RATE: Final = 1.0
"""rad/s: of this rate."""
MAX_TILT_SIGMA: Final = 0.6
"""rad: with a tilt less certain than this the measurements are not linear in the error any more, and lead astray."""
RESET_SIGMA_S: Final = 10.0
"""After a reset caused by velocity innovations, old and new attitude cannot both be right (the receiver may have
frozen). Their difference is added to both sigmas and decays with this time constant, s, while innovations stay small.
The same is done after a start in motion without a velocity."""
RESET_SIGMA_GRAVITY_S: Final = 60.0
"""The same while gravity is the only aid, s: the accelerations of some turns must cancel."""


IMPOSSIBLE_SPEED: Final = 150.0
"""m/s: a velocity that is carried on without fixes beyond this is no motion: gravity accumulates along a wrong
direction, and passes this in 15 s."""


def is_impossible(navigation: Navigation) -> bool:
    """Whether the velocity without fixes is one that no such vehicle has, so that the attitude cannot be right."""
    v = navigation.estimate.velocity
    return navigation.mode == AidingMode.COASTING and dot(v, v) > IMPOSSIBLE_SPEED**2


def is_lost(dt_s: float, inputs: FilterInputs) -> bool:
    """True when the motion during the step is not known."""
    return dt_s > (LONGEST_GAP_S if inputs.samples_missing else LONGEST_STEP_S)


def after_gap(navigation: Navigation, dt_s: float, inputs: FilterInputs) -> Navigation:
    """The navigation with the rotation in sigma that a gap may have hidden."""
    if not inputs.samples_missing or dt_s < UNSEEN_GAP_S:
        return navigation
    variance = (UNSEEN_RATE * dt_s) ** 2
    estimate = navigation.estimate.with_added_variance(ErrorBlock.ATTITUDE, (variance, variance, variance))
    return navigation.with_estimate(estimate)


def reset_sigma_decay(navigation: Navigation, dt_s: float) -> float:
    """The share of the reset sigma that is left after a step."""
    if navigation.gnss.mean_nis >= 1.0 or navigation.mode == AidingMode.AIRSPEED:
        # Airspeed alone does not make the attitude observable: in a circle it agrees with a wrong one for minutes.
        return 1.0
    return exp(-dt_s / (RESET_SIGMA_GRAVITY_S if navigation.mode == AidingMode.GRAVITY else RESET_SIGMA_S))


def _attitude_jump(after: NavigationState, carried: Quat, before: NavigationState) -> float:
    """Angle between a new attitude and the old one carried on, rad; 0 while the old one's own sigmas explain it."""
    tilt, heading = tilt_between(after.q_nb, carried), abs(heading_between(after.q_nb, carried))
    explained = tilt < 3.0 * before.tilt_sigma and heading < 3.0 * before.heading_sigma
    return 0.0 if explained else max(tilt, heading)


def reset_sigma_after(
    sigma: float, method: AlignmentMethod, begun: NavigationState, carried: Quat, earlier: NavigationState | None
) -> float:
    """The reset sigma at the end of an alignment, rad; ``sigma``: before.

    carried: the last attitude turned on by the gyro. earlier: the estimate that innovations contradicted, if any.
    """
    if method == AlignmentMethod.ASSUMED_GRAVITY:
        sigma = max(sigma, ASSUMED_GRAVITY_TILT)
    return sigma if earlier is None else max(sigma, _attitude_jump(begun, carried, earlier))
