"""State of the flight filter, and what it says of itself: whether it is aligned, and what the attitude rests on."""

from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.alignment.collect import Alignment
from attest_mav.filters.velocity_aided.control import AidingMode, Navigation
from attest_mav.types import North, Quat, Vec3

NORTH_LOST: Final = 0.5
"""rad: with a heading less certain than this there is no north."""


@mypyc_attr(acyclic=True)
class VelocityAidedState(FilterState):
    """State after a step.

    alignment: what it has collected while it aligns, None while it navigates. navigation: the estimate, which an
    alignment after a gap keeps for what it knows of the sensors; None before the first. gap_s: time since the estimate
    was given up. reset_by_innovations: whether fixes contradicted it. reset_sigma: rad, part of both sigmas, decaying,
    see ``filter.RESET_SIGMA_S``. While it aligns the sigmas are pi, and ``q_nb`` is the last attitude turned on by the
    gyro.
    """

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        tilt_sigma: float,
        heading_sigma: float,
        alignment: Alignment | None,
        navigation: Navigation | None,
        gap_s: float,
        reset_by_innovations: bool,
        reset_sigma: float,
    ) -> None:
        super().__init__(q_nb, gyro_bias, accel_used, mag_used, tilt_sigma, heading_sigma)
        self.alignment: Final = alignment
        self.navigation: Final = navigation
        self.gap_s: Final = gap_s
        self.reset_by_innovations: Final = reset_by_innovations
        self.reset_sigma: Final = reset_sigma

    @property
    def aligned(self) -> bool:
        """True once there is an attitude."""
        return self.navigation is not None and self.alignment is None

    @property
    def referred_to(self) -> North | None:
        """What the heading refers to."""
        navigation = self.navigation
        if navigation is None or self.heading_sigma > NORTH_LOST:
            return North.RELATIVE
        return North.TRUE if navigation.declination_known else North.MAGNETIC

    @property
    def sigma_is_proven(self) -> bool:
        """True once there is an attitude: its covariance holds with every aid, and counts the cost of a reset."""
        return self.aligned

    @property
    def rests_on(self) -> str:
        """The velocity and where it comes from, or what has taken its place; "" while it aligns."""
        navigated = self._navigated
        if navigated is None:
            return "just aligned" if self.aligned else ""
        if navigated.mode == AidingMode.VELOCITY:
            # Those that an alignment was made of are not the filter's rows: the first of these tells the source.
            return f"velocity from {navigated.gnss.source}" if navigated.gnss.source else "just aligned"
        return f"no velocity: {_fallback_name(navigated.mode)}"

    @property
    def velocity_nis(self) -> float:
        """Of the fix that this step used, NaN if it used none."""
        navigated = self._navigated
        return nan if navigated is None or navigated.gnss.since_fused_s > 0.0 else navigated.gnss.nis

    @property
    def field_nis(self) -> float:
        """Of the reading that came with this step, rejected or not; NaN if none did."""
        navigated = self._navigated
        return nan if navigated is None or navigated.magnetometer.since_reading_s > 0.0 else navigated.magnetometer.nis

    @property
    def _navigated(self) -> Navigation | None:
        """The flight, once it has gone a step: until then it tells of the time before a gap, or of none."""
        navigation = self.navigation
        if navigation is None or self.alignment is not None or not navigation.imu.history.points:
            return None
        return navigation


def _fallback_name(mode: AidingMode) -> str:
    """The name of what has taken the velocity's place."""
    if mode == AidingMode.STATIONARY:
        return "at rest"
    if mode == AidingMode.AIRSPEED:
        return "airspeed"
    if mode == AidingMode.ZERO_MEAN_VELOCITY:
        return "taken to stay in place"
    return "coasting" if mode == AidingMode.COASTING else "gravity only"
