"""One filter over readings in time order, without a vehicle around it: for arrays, and for readings as they come.

The first usable reading aligns the filter, as an electronic compass does. After a gap of more than a second the motion
in between is lost: the filter is aligned again, and keeps its gyro bias. A filter that aligns itself does both on its
own.
"""

from math import isfinite, nan
from typing import Final

from attest_mav.algebra import norm, rotate_back
from attest_mav.estimation.alignment import ecompass
from attest_mav.estimation.filter_run import FilterRun
from attest_mav.filters.base import AttitudeFilter, BodyVelocity, FilterInputs, FilterState, Start
from attest_mav.plausible import is_force, is_rate
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import EarthField, North, Vec3, VelocityOrigin

LONGEST_STEP_S: Final = 1.0
"""After a longer step a filter that does not align itself starts again."""
FRESH_NS: Final = 2_000_000_000
"""A velocity that is older is not used, ns."""
SOURCE: Final = "arrays"
"""The name of the stream; there is only one."""


def velocity_fix(t_ns: int, v_ned: Vec3, sigma: float = nan) -> VelocitySample:
    """A velocity over ground at one instant, as filters take it.

    t_ns: when it was valid. v_ned: m/s, z NaN where the vertical velocity is not known. sigma: m/s an axis, NaN where
    the receiver reports none.
    """
    vertical_known = isfinite(v_ned[2])
    velocity = v_ned if vertical_known else (v_ned[0], v_ned[1], 0.0)
    known_sigma = sigma if sigma > 0.0 else None
    return VelocitySample(SOURCE, 1, 1, t_ns, t_ns, velocity, vertical_known, VelocityOrigin.RECEIVER, known_sigma)


class FilterSequence:
    """The filter, and its state after the last reading."""

    def __init__(self, attitude_filter: AttitudeFilter, field: EarthField, in_place: bool) -> None:
        """Begin before the first reading. in_place: until a velocity comes, the mean velocity may be taken for zero."""
        self._run: Final = FilterRun(attitude_filter)
        self._field: Final = field
        self._velocity: VelocitySample | None = None
        self._is_new = False
        self._t_ns = 0
        self._is_missing = False
        self._unaided = _inputs(field, in_place)

    @property
    def state(self) -> FilterState | None:
        """The filter's state after the last reading; None before the first usable one."""
        return self._run.state

    @property
    def north(self) -> North:
        """The north that headings refer to."""
        state = self._run.state
        own = None if state is None else state.referred_to
        return self._run.north if own is None else own

    def give_velocity(self, fix: VelocitySample) -> None:
        """Take a velocity fix, to be used from the next reading on."""
        if self._velocity is None:
            self._unaided = _inputs(self._field, in_place=False)
        self._velocity = fix
        self._is_new = True

    def advance(self, t_ns: int, gyro: Vec3, accel: Vec3, mag: Vec3 | None) -> FilterState | None:
        """The state at this reading; None while no reading was usable.

        t_ns: larger than at the reading before. Units and frames as in ``types``; not finite means missing. A reading
        without a rate is passed over, and the next step is the longer.
        """
        if not is_rate(gyro):
            self._is_missing = True
            return self._run.state
        sample = ImuSample(SOURCE, 1, 1, t_ns, t_ns, gyro, accel, mag)
        dt_s = 1e-9 * (t_ns - self._t_ns)
        run = self._run
        state = run.state
        if state is None or (dt_s > LONGEST_STEP_S and not run.filter.aligns_itself):
            self._align(sample)
        else:
            run.state = run.filter.step(state, dt_s, sample, self._given(t_ns, state))
        self._t_ns = t_ns
        self._is_missing = False
        return run.state

    def _align(self, sample: ImuSample) -> None:
        """Start the filter at this sample, if its specific force can be one."""
        if not is_force(sample.accel) or norm(sample.accel) == 0.0:
            return
        q_nb, north = ecompass(sample.accel, sample.mag)
        start = Start(q_nb, (0.0, 0.0, 0.0), north, sample.accel, sample.mag, at_rest=False)
        self._run.begin(start, stands=False)

    def _given(self, t_ns: int, state: FilterState) -> FilterInputs:
        """What is known besides the reading. The velocity is turned into the body for filters that level by it."""
        velocity = self._velocity
        if velocity is None or t_ns - velocity.t_ns > FRESH_NS:
            return _inputs(self._field, self._unaided.zero_mean_velocity, True) if self._is_missing else self._unaided
        forward, side, down = rotate_back(state.q_nb, velocity.v_ned)
        body = BodyVelocity(forward, side, down, True, self._is_new)
        self._is_new = False
        return FilterInputs(
            body_velocity=body,
            declination=self._field.declination,
            inclination=self._field.inclination,
            velocity=velocity,
            zero_mean_velocity=False,
            samples_missing=self._is_missing,
        )


def _inputs(field: EarthField, in_place: bool, missing: bool = False) -> FilterInputs:
    """The inputs without a velocity."""
    return FilterInputs(
        declination=field.declination,
        inclination=field.inclination,
        zero_mean_velocity=in_place,
        samples_missing=missing,
    )
