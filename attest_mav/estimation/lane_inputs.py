"""Whether the sensors of a lane are quiet, and the inputs of its filter that follow from it."""

from typing import Final

from attest_mav.algebra import norm
from attest_mav.estimation.vehicle import STANDING_SPEED, Vehicle
from attest_mav.filters.base import BodyVelocity, FilterInputs
from attest_mav.filters.stationary import StillnessLimits, is_unaccelerated
from attest_mav.samples import ImuSample, Sample, VelocitySample
from attest_mav.types import G_MPS2, North, Quat

LIMITS: Final = StillnessLimits(rate=0.05, accel=0.3)
"""Quiet sensors show no more than this."""
LEAVING_FACTOR: Final = 2.0
"""The quiet time is over at the first reading beyond so many times the limits."""
STILL_AFTER_S: Final = 1.0
"""The sensors count as quiet after this time, s."""
FROZEN_REPEATS: Final = 4
"""A moving receiver does not repeat a velocity so often."""
FROZEN_NS: Final = 1_000_000_000
"""Nor for so long."""


class QuietSensors:
    """Follows one lane's readings, with hysteresis."""

    def __init__(self) -> None:
        self._quiet_s = 0.0
        self.quiet = False

    def advance(self, sample: ImuSample, dt_s: float) -> None:
        """Go on to this sample, ``dt_s`` after the one before."""
        if is_unaccelerated(sample.gyro, sample.accel, G_MPS2, LIMITS):
            self._quiet_s += dt_s
            self.quiet = self.quiet or self._quiet_s >= STILL_AFTER_S
        elif not is_unaccelerated(sample.gyro, sample.accel, G_MPS2, LIMITS, LEAVING_FACTOR):
            self._quiet_s = 0.0
            self.quiet = False


class RepeatedVelocity:
    """Notices a receiver that gives one velocity with new times, as one does whose computer hangs."""

    def __init__(self) -> None:
        self._first: VelocitySample | None = None
        self._newest_ns = 0
        self._repeats = 0

    def is_frozen(self, velocity: VelocitySample) -> bool:
        """True from the fifth fix with the same velocity on, if they span a second. A zero is what one at rest gives.

        velocity: the newest fix, which may be given again.
        """
        first = self._first
        if first is None or velocity.v_ned != first.v_ned or velocity.t_ns < self._newest_ns:
            self._first, self._newest_ns, self._repeats = velocity, velocity.t_ns, 0
            return False
        if velocity.t_ns > self._newest_ns:
            self._newest_ns = velocity.t_ns
            self._repeats += 1
        lasts_ns = self._newest_ns - first.t_ns
        return self._repeats >= FROZEN_REPEATS and lasts_ns >= FROZEN_NS and norm(velocity.v_ned) > 0.0


class LaneInputs:
    """Inputs of a lane's filter from the vehicle and the lane's own readings, marked where new to the filter."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle: Final = vehicle
        self._sensors: Final = QuietSensors()
        self._repeated: Final = RepeatedVelocity()
        self._speed_given: Sample | None = None

    def advance(self, sample: ImuSample, dt_s: float) -> None:
        """Go on to the next inertial sample."""
        self._sensors.advance(sample, dt_s)

    @property
    def stationary(self) -> bool:
        """True while the vehicle stands still. Disarmed, quiet sensors suffice.

        Armed or of unknown state, a speed is needed as well: hovering is quiet too.
        """
        return self._sensors.quiet and self._vehicle.stands is True

    def give(
        self, sample: ImuSample, q_nb: Quat, north: North, samples_missing: bool = False, body_velocity: bool = True
    ) -> FilterInputs:
        """The inputs at this sample for a filter that holds this attitude; a speed is new once.

        samples_missing: see ``FilterInputs``. body_velocity: whether the filter uses it.
        """
        vehicle, now_ns = self._vehicle, sample.rx_ns
        return FilterInputs(
            self._body_velocity(now_ns, q_nb, north) if body_velocity else None,
            self.stationary,
            vehicle.latitude,
            vehicle.field.declination,
            self._velocity(now_ns),
            None,
            vehicle.field.inclination,
            vehicle.airspeed(now_ns),
            vehicle.goes_where_it_points,
            vehicle.zero_mean_velocity(now_ns),
            samples_missing,
        )

    def _body_velocity(self, now_ns: int, q_nb: Quat, north: North) -> BodyVelocity | None:
        """The velocity in the body, None while none is fresh or known."""
        moving = self._vehicle.body_velocity(now_ns, q_nb, north)
        if moving is None:
            return None
        v = moving.velocity
        is_new = moving.sample is not self._speed_given
        self._speed_given = moving.sample
        return BodyVelocity(v.forward, v.side, v.down, v.lateral_known, is_new)

    def _velocity(self, now_ns: int) -> VelocitySample | None:
        """The velocity for the flight filter. One that moves is withheld from a vehicle that stands on the ground.

        Gyro, accelerometer and the vehicle's own word together are better evidence than a receiver indoors. A velocity
        that is repeated to the last digit is withheld as soon as the sensors show motion.
        """
        velocity = self._vehicle.velocity(now_ns)
        if velocity is None:
            return None
        frozen = self._repeated.is_frozen(velocity)
        if not self._sensors.quiet:
            return None if frozen else velocity
        if not self._vehicle.on_ground:
            return velocity
        return None if norm(velocity.v_ned) > STANDING_SPEED else velocity
