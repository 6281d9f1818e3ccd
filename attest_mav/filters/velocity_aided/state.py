"""State of the flight filter, and what it says of itself: whether it is aligned, and what the attitude rests on."""

from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.alignment.collect import Alignment
from attest_mav.filters.velocity_aided.control import Aid, Flying
from attest_mav.types import North, Quat, Vec3

NORTH_LOST: Final = 0.5
"""rad: with a heading less certain than this there is no north."""


@mypyc_attr(acyclic=True)
class VelocityAidedState(FilterState):
    """State after a step.

    alignment: what it has collected while it aligns, None while it flies. flying: the estimate, which an alignment
    after a gap keeps for what it knows of the sensors; None before the first. Its ``fixes`` and ``compass`` hold
    the innovations. gap_s: time since the estimate was given up. contested: it was, because the fixes contradicted it.
    doubt: rad, part of the sigmas, and fading, see ``velocity_aided.DOUBT_S``. While it aligns the sigmas are pi, and
    ``q_nb`` is the last attitude turned on by the gyro.
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
        flying: Flying | None,
        gap_s: float,
        contested: bool,
        doubt: float,
    ) -> None:
        super().__init__(q_nb, gyro_bias, accel_used, mag_used, tilt_sigma, heading_sigma)
        self.alignment: Final = alignment
        self.flying: Final = flying
        self.gap_s: Final = gap_s
        self.contested: Final = contested
        self.doubt: Final = doubt

    @property
    def aligned(self) -> bool:
        """True once there is an attitude."""
        return self.flying is not None and self.alignment is None

    @property
    def referred_to(self) -> North | None:
        """What the heading refers to."""
        flying = self.flying
        if flying is None or self.heading_sigma > NORTH_LOST:
            return North.RELATIVE
        return North.TRUE if flying.declined else North.MAGNETIC

    @property
    def sigma_is_proven(self) -> bool:
        """True once there is an attitude: its covariance holds with every aid, and counts the cost of a reset."""
        return self.aligned

    @property
    def rests_on(self) -> str:
        """The velocity and where it comes from, or what has taken its place; "" while it aligns."""
        flown = self._flown
        if flown is None:
            return "just aligned" if self.aligned else ""
        if flown.aid == Aid.VELOCITY:
            # Those that an alignment was made of are not the filter's rows: the first of these tells the source.
            return f"velocity from {flown.fixes.source}" if flown.fixes.source else "just aligned"
        return f"no velocity: {_substitute(flown.aid)}"

    @property
    def velocity_nis(self) -> float:
        """Of the fix that this step used, NaN if it used none."""
        flown = self._flown
        return nan if flown is None or flown.fixes.lost_s > 0.0 else flown.fixes.nis

    @property
    def field_nis(self) -> float:
        """Of the reading that came with this step, rejected or not; NaN if none did."""
        flown = self._flown
        return nan if flown is None or flown.compass.held_s > 0.0 else flown.compass.nis

    @property
    def _flown(self) -> Flying | None:
        """The flight, once it has gone a step: until then it tells of the time before a gap, or of none."""
        flying = self.flying
        if flying is None or self.alignment is not None or not flying.strapdown.track.points:
            return None
        return flying


def _substitute(aid: Aid) -> str:
    """The name of what has taken the velocity's place."""
    if aid == Aid.REST:
        return "at rest"
    if aid == Aid.AIRSPEED:
        return "airspeed"
    if aid == Aid.PLACE:
        return "taken to stay in place"
    return "coasting" if aid == Aid.COASTING else "gravity only"
