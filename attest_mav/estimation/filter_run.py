"""The filter of a lane, with its state and its last output."""

from math import atan2
from typing import Final

from attest_mav.algebra import is_finite_number, norm, q_continuous, q_heading, q_mul, q_to_euler, rotate, sub
from attest_mav.estimate import Estimate
from attest_mav.estimation.alignment import ecompass
from attest_mav.estimation.events import LaneEventKind
from attest_mav.filters.base import AttitudeFilter, FilterState, Start
from attest_mav.plausible import is_force
from attest_mav.samples import ImuSample
from attest_mav.types import North, Quat, Vec3
from attest_mav.vehicle_settings import VehicleSettings

HEADING_MEMORY_S: Final = 10.0
"""Without a magnetometer for longer the heading is dead-reckoned, and no longer referred to north."""
HEADING_CAPTURE: Final = 0.09
"""rad (5 deg): a heading counts as found again when it is this near to the heading by the field."""

NORTH_TEXTS: Final = {
    LaneEventKind.HEADING_LOST: "no magnetometer: the heading drifts",
    LaneEventKind.HEADING_FOUND: "the heading is magnetic again",
}
"""What is told of a heading that is lost or found."""


class FilterRun:
    """A filter that runs once ``state`` is there."""

    def __init__(self, attitude_filter: AttitudeFilter) -> None:
        self.filter = attitude_filter
        """The filter with the vehicle's settings in it."""
        self.state: FilterState | None = None
        self.north = North.RELATIVE
        """The north of its heading, before any declination."""
        self.output: Quat = (1.0, 0.0, 0.0, 0.0)
        """The last attitude put out."""
        self.aligned = False
        """Whether a filter that aligns itself had an attitude at the last step."""
        self._as_configured = attitude_filter

    def set_vehicle_settings(self, known: VehicleSettings) -> None:
        """Give the filter the vehicle's settings; those that are not known any more become its own again."""
        self.filter = self._as_configured.with_vehicle_settings(known)

    def use_filter(self, attitude_filter: AttitudeFilter, known: VehicleSettings) -> None:
        """Go on from the present state with other parameters of the same filter."""
        self._as_configured = attitude_filter
        self.set_vehicle_settings(known)

    def begin(self, start: Start, stands: bool) -> None:
        """Start the filter, with the still valid parts of an earlier state.

        These are the gyro bias, unless the vehicle surely stands and has shown a newer one; and the heading, if the
        start has no field.
        """
        before = self.state
        if before is not None:
            bias = start.gyro_bias if stands else before.gyro_bias
            q_nb = start.q_nb
            if start.north == North.RELATIVE:
                q_nb = q_mul(q_heading(q_to_euler(before.q_nb)[2]), q_nb)
            start = Start(q_nb, bias, start.north, start.accel, start.mag, start.at_rest)
        self.state = self.filter.initial(start)
        self.north = start.north

    def begin_by_itself(self, sample: ImuSample) -> None:
        """Start a filter that aligns itself from one reading."""
        if self.filter.aligns_itself and is_force(sample.accel) and norm(sample.accel) > 0.0:
            q_nb, north = ecompass(sample.accel, sample.mag)
            self.begin(Start(q_nb, (0.0, 0.0, 0.0), north, sample.accel, sample.mag, False), stands=False)

    def follow_north(self, state: FilterState, sample: ImuSample, field_absent_s: float) -> LaneEventKind | None:
        """Keep ``north`` true: the filter's own; else lost after a time without field, found when both agree.

        HEADING_LOST or HEADING_FOUND where a filter without a north of its own has lost or found it.
        """
        own_north = state.referred_to
        if own_north is not None:
            self.north = own_north
        elif self.north == North.MAGNETIC:
            if field_absent_s > HEADING_MEMORY_S:
                self.north = North.RELATIVE
                return LaneEventKind.HEADING_LOST
        elif sample.mag is not None and abs(field_heading(state.q_nb, sample.mag)) < HEADING_CAPTURE:
            self.north = North.MAGNETIC
            return LaneEventKind.HEADING_FOUND
        return None

    def estimate(
        self,
        lane: str,
        state: FilterState,
        sample: ImuSample,
        t_ns: int,
        dt_s: float,
        delay_s: float,
        declination: float,
    ) -> Estimate:
        """The estimate of the state at this sample; the heading is true once the declination (rad) is known."""
        q_nb, north = state.q_nb, self.north
        if north == North.MAGNETIC and is_finite_number(declination):
            q_nb, north = q_mul(q_heading(declination), q_nb), North.TRUE
        self.output = q_continuous(q_nb, self.output)
        rates = sub(sample.gyro, state.gyro_bias)
        return Estimate(
            lane,
            self.filter.name,
            t_ns,
            sample.rx_ns,
            self.output,
            rates,
            north,
            state.tilt_sigma,
            state.heading_sigma,
            dt_s,
            delay_s,
            state.innovations,
            state.sigma_is_proven,
            state.accel_bias,
        )


def field_heading(q_nb: Quat, mag: Vec3) -> float:
    """Angle of the levelled field east of the estimate's north, rad: the heading error the field sees."""
    field = rotate(q_nb, mag)
    return atan2(field[1], field[0])
