"""A vehicle that stands shows its attitude plainly: by gravity and the magnetic field.

A filter whose attitude differs from that has missed a turn (a gap, a saturated sensor, a turn without a fix), and none
of its own measurements corrects it soon. The filter is restarted.
"""

from math import radians
from typing import Final

from attest_mav.algebra import add, heading_between, hypotenuse, is_finite, norm, scale, sub, tilt_between, wrap_pi
from attest_mav.estimation.alignment import ecompass
from attest_mav.estimation.witness.flight_state import navigation_of
from attest_mav.estimation.witness.moments import Moment
from attest_mav.filters.base import FilterInputs, FilterState, Start
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North, Vec3

MEAN_S: Final = 0.3
"""Time constant of the running means."""
QUIET_RATE: Final = 0.02
"""rad/s: readings this near to their mean, and a mean this near to the bias, are quiet."""
QUIET_ACCEL: Final = 0.3
NEAR_GRAVITY: Final = 0.15
"""m/s^2: the same of the accelerometer, and of the length of its mean beside g."""
QUIET_S: Final = 1.0
"""Quiet for so long is rest."""
STANDING_SPEED: Final = 0.5
"""m/s: a vehicle whose fixes are slower stands."""
OFF_TILT: Final = radians(6.0)
OFF_HEADING: Final = radians(25.0)
OFF_SIGMAS: Final = 3.0
OFF_S: Final = 1.0
"""A vehicle that stands has another attitude than its filter when both limits are exceeded for so long."""
FLYING_OFF_TILT: Final = radians(15.0)
FLYING_OFF_S: Final = 3.0
"""The same where it may fly: within ``NEAR_GRAVITY`` of g no steady acceleration tilts by more than 10 degrees."""
FIELD_SHARE: Final = 0.05
"""The heading is plain while the field has its usual strength within this share."""
LARGEST_BIAS: Final = 0.02
"""rad/s: a larger gyro bias is not kept."""


class RestCheck:
    """Follows one lane."""

    def __init__(self) -> None:
        self._gyro: Vec3 = (0.0, 0.0, 0.0)
        self._accel: Vec3 = (0.0, 0.0, -G_MPS2)
        self._has_field = False
        self._field: Vec3 = (0.0, 0.0, 0.0)
        """Mean of the readings of the magnetometer, gauss, once there is one."""
        self._quiet_s = 0.0
        self._off_s = 0.0

    def take(self, moment: Moment) -> bool:
        """Take the next moment; True when the filter is to begin again."""
        state = moment.state
        self._average(moment.sample, moment.dt_s)
        self._quiet_s = self._quiet_s + moment.dt_s if self._is_quiet(moment.sample, state) else 0.0
        if self._quiet_s < QUIET_S or navigation_of(state) is None:
            self._off_s = 0.0
            return False
        stands = _stands(moment.inputs)
        self._off_s = self._off_s + moment.dt_s if self._is_off(state, stands) else 0.0
        if self._off_s < (OFF_S if stands else FLYING_OFF_S):
            return False
        self._off_s = 0.0
        return True

    def begun_again(self, one: VelocityAided, state: FilterState) -> FilterState:
        """The filter at its start, with the plain attitude to be shown until it has its own."""
        mag = self._field if self._has_field else None
        q_nb, north = ecompass(self._accel, mag)
        bias = state.gyro_bias if norm(state.gyro_bias) < LARGEST_BIAS else (0.0, 0.0, 0.0)
        return one.initial(Start(q_nb, bias, north, self._accel, mag))

    def _average(self, sample: ImuSample, dt_s: float) -> None:
        share = min(1.0, dt_s / MEAN_S)
        self._gyro = add(self._gyro, scale(sub(sample.gyro, self._gyro), share))
        if is_finite(sample.accel):
            self._accel = add(self._accel, scale(sub(sample.accel, self._accel), share))
        if sample.has_field and is_finite(sample.field):
            before = self._field if self._has_field else sample.field
            self._has_field = True
            self._field = add(before, scale(sub(sample.field, before), share))

    def _is_quiet(self, sample: ImuSample, state: FilterState) -> bool:
        return (
            not sample.saturated
            and norm(sub(sample.gyro, self._gyro)) < QUIET_RATE
            and norm(sub(self._gyro, state.gyro_bias)) < QUIET_RATE
            and norm(sub(sample.accel, self._accel)) < QUIET_ACCEL
            and abs(norm(self._accel) - G_MPS2) < NEAR_GRAVITY
        )

    def _is_off(self, state: FilterState, stands: bool) -> bool:
        """Whether the filter's attitude is another one than the plain one."""
        plain, north = ecompass(self._accel, self._field if self._has_field else None)
        tilt = tilt_between(state.q_nb, plain)
        if not stands:
            return tilt > max(FLYING_OFF_TILT, OFF_SIGMAS * state.tilt_sigma)
        if tilt > max(OFF_TILT, OFF_SIGMAS * state.tilt_sigma):
            return True
        navigation = navigation_of(state)
        if navigation is None or not self._has_field or north == North.RELATIVE:
            return False
        usual = navigation.magnetometer.usual
        if usual is None or abs(norm(self._field) - usual.strength) > FIELD_SHARE * usual.strength:
            return False
        heading = abs(wrap_pi(heading_between(state.q_nb, plain) - navigation.assumed_declination))
        return heading > max(OFF_HEADING, OFF_SIGMAS * state.heading_sigma)


def _stands(inputs: FilterInputs) -> bool:
    """Whether the vehicle is known to stand: not under way, or slow by its receiver."""
    fix = inputs.velocity
    if fix is None:
        return inputs.zero_mean_velocity
    return hypotenuse(fix.v_ned[0], fix.v_ned[1]) < STANDING_SPEED
