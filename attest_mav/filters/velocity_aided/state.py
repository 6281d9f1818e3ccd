"""State of the flight filter: aligned or not, the aid that holds the attitude, and the records of its step."""

from math import pi
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.alignment.collect import Alignment
from attest_mav.filters.velocity_aided.navigation import AidingMode, Navigation
from attest_mav.innovation import Innovation
from attest_mav.types import North, Quat, Vec3

NORTH_LOST: Final = 0.5
"""rad: with a heading less certain than this there is no north."""


@mypyc_attr(acyclic=True, free_list_len=1)
class VelocityAidedState(FilterState):
    """State after a step.

    While the filter aligns the sigmas are pi, and ``q_nb`` is the last attitude turned on by the gyro.
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
        """The readings collected so far while the filter aligns, None while it navigates."""
        self.navigation: Final = navigation
        """Estimate and memories; kept during an alignment after a gap for the sensor errors. None before the first."""
        self.gap_s: Final = gap_s
        """Time since the estimate was given up, s; 0 while the filter navigates."""
        self.reset_by_innovations: Final = reset_by_innovations
        """Whether the alignment began because velocity fixes contradicted the estimate."""
        self.reset_sigma: Final = reset_sigma
        """Part of both sigmas after a reset, rad, decaying, see ``reset.RESET_SIGMA_S``."""

    def with_navigation(self, navigation: Navigation) -> "VelocityAidedState":
        """The same with another estimate, which the next step shows."""
        return VelocityAidedState(
            self.q_nb,
            self.gyro_bias,
            self.accel_used,
            self.mag_used,
            self.tilt_sigma,
            self.heading_sigma,
            self.alignment,
            navigation,
            self.gap_s,
            self.reset_by_innovations,
            self.reset_sigma,
        )

    @property
    def aligned(self) -> bool:
        """True once there is an attitude."""
        return self.navigation is not None and self.alignment is None

    @property
    def referred_to(self) -> North | None:
        """The north that the heading refers to."""
        navigation = self.navigation
        if navigation is None or self.heading_sigma > NORTH_LOST:
            return North.RELATIVE
        return North.MAGNETIC if navigation.declination is None else North.TRUE

    @property
    def accel_bias(self) -> Vec3 | None:
        """Bias of the accelerometer, m/s^2, body; None before the first attitude."""
        return None if self.navigation is None else self.navigation.estimate.accel_bias

    @property
    def is_calibrated(self) -> bool:
        """True while it goes on from the sensor errors of earlier flights."""
        return self.navigation is not None and self.navigation.begun_with is not None

    @property
    def sigma_is_proven(self) -> bool:
        """True once there is an attitude: its covariance holds with every aid, and counts the cost of a reset."""
        return self.aligned

    @property
    def rests_on(self) -> str:
        """The velocity and its source, or the aid that has taken its place; "" while the filter aligns."""
        stepped = self._stepped
        if stepped is None:
            return "just aligned" if self.aligned else ""
        if stepped.mode == AidingMode.VELOCITY:
            # Fixes that an alignment was made of are not measurements of the filter: the first of these has the source.
            last = stepped.gnss.last
            return "just aligned" if last is None else f"velocity from {last.source}"
        return f"no velocity: {_fallback_name(stepped.mode)}"

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """The records of this step's aids."""
        stepped = self._stepped
        return () if stepped is None else stepped.innovations

    @property
    def _stepped(self) -> Navigation | None:
        """The navigation after its first step; before that its records still describe the time before the gap."""
        navigation = self.navigation
        if navigation is None or self.alignment is not None or not navigation.has_stepped:
            return None
        return navigation


def aligning_state(
    q_nb: Quat,
    bias: Vec3,
    alignment: Alignment,
    navigation: Navigation | None,
    gap_s: float,
    reset_by_innovations: bool,
    reset_sigma: float,
) -> VelocityAidedState:
    """The state of an alignment that is not over."""
    return VelocityAidedState(
        q_nb, bias, False, False, pi, pi, alignment, navigation, gap_s, reset_by_innovations, reset_sigma
    )


def _fallback_name(mode: AidingMode) -> str:
    """The aid that has taken the velocity's place, in words."""
    if mode == AidingMode.STATIONARY:
        return "at rest"
    if mode == AidingMode.AIRSPEED:
        return "airspeed"
    if mode == AidingMode.ZERO_MEAN_VELOCITY:
        return "taken to stay in place"
    return "coasting" if mode == AidingMode.COASTING else "gravity only"
