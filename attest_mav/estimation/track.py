"""One filter on a lane, with its state and what it last put out."""

from math import atan2, isfinite
from typing import Final

from attest_mav.algebra import q_continuous, q_heading, q_mul, q_to_euler, rotate, sub
from attest_mav.filters.base import AttitudeFilter, FilterState, Start, VehicleFacts
from attest_mav.types import Estimate, ImuSample, North, Quat, Vec3


class Track:
    """The filter runs once ``state`` is there. north: what its heading refers to, before any declination.

    output: the last attitude put out. aligned: what a filter that aligns itself last said of it.
    """

    def __init__(self, attitude_filter: AttitudeFilter) -> None:
        self.filter = attitude_filter
        self.state: FilterState | None = None
        self.north = North.RELATIVE
        self.output: Quat = (1.0, 0.0, 0.0, 0.0)
        self.aligned = False
        self._uninformed: Final = attitude_filter

    def inform(self, facts: VehicleFacts) -> None:
        """Tell the filter the vehicle's settings: those that are not known any more become its own again."""
        self.filter = self._uninformed.informed(facts)

    def begin(self, start: Start, stands: bool) -> None:
        """Start the filter, with what an earlier state still knows.

        That is the gyro bias, unless the vehicle surely stands and has shown a newer one; and the heading, if the
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
        """What the state says at this sample; the heading is true once the declination (rad) is known."""
        q_nb, north = state.q_nb, self.north
        if north == North.MAGNETIC and isfinite(declination):
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
            state.velocity_nis,
            state.field_nis,
            state.aided,
        )


def field_heading(q_nb: Quat, mag: Vec3) -> float:
    """Angle of the levelled field east of the estimate's north, rad: the heading error the field sees."""
    field = rotate(q_nb, mag)
    return atan2(field[1], field[0])
