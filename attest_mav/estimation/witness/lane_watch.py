"""One lane under watch: it takes its filter's steps, with or without the fix, and remembers the last seconds."""

from typing import Final

from attest_mav.algebra import hypotenuse
from attest_mav.estimation.field_evidence import FieldReading
from attest_mav.estimation.stepper import Stepper
from attest_mav.estimation.witness.dead_sensor import DeadSensor
from attest_mav.estimation.witness.field_watch import FieldWatch
from attest_mav.estimation.witness.fix_stream import FixStream
from attest_mav.estimation.witness.flight_state import (
    FixRecord,
    field_direction,
    field_reading,
    hard_iron,
    has_field_reading,
    navigation_of,
    shifted,
    unused_fix,
    used_fix,
    velocity_of,
)
from attest_mav.estimation.witness.moments import Moment, Moments
from attest_mav.estimation.witness.proving import ProvingFixes
from attest_mav.estimation.witness.rest_check import RestCheck
from attest_mav.estimation.witness.sensor_noise import SensorNoise
from attest_mav.estimation.witness.situation import Situation, Standing
from attest_mav.filters.base import AttitudeFilter, FilterInputs, FilterState
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import Vec3

FIELD_LEAST: Final = 0.02
FIELD_USUALS: Final = 3.0
FIELD_SIGMAS: Final = 2.0
"""The field's residual contradicts the attitude beyond this share of the field, so many usual residuals, and so many
sigmas of the attitude."""


class LaneWatch(Stepper):
    """The lane's steps. name: of its inertial message."""

    def __init__(self, name: str) -> None:
        self.name: Final = name
        self.standing = Standing.NEW
        self.aside_reason = ""
        """Why it stands aside, or has stood aside last."""
        self.situation = Situation()
        self.moments: Final = Moments()
        self.dead: Final = DeadSensor()
        self.field: Final = FieldWatch()
        self.field_reading: FieldReading | None = None
        """The newest reading of the magnetometer, None before the first."""
        self.fixes: Final = FixStream()
        self.rest: Final = RestCheck()
        self.proving = ProvingFixes()
        self.fix: FixRecord | None = None
        """The newest fix beside the lane's estimate, used or not."""
        self.fix_seen_ns = -1
        """Time of the sample that came with it."""
        self.gyro_bias: Vec3 = (0.0, 0.0, 0.0)
        self.accel_bias: Vec3 = (0.0, 0.0, 0.0)
        """Biases that its readings are compared with while it stands aside, rad/s and m/s^2."""
        self.before_fault: FilterState | None = None
        """Its state from some seconds before it was set aside."""
        self.configured: VelocityAided | None = None
        """The filter with the vehicle's settings; None before its first step."""
        self.filter: VelocityAided | None = None
        """The same with the sensor's noise."""
        self.noise: SensorNoise | None = None
        """The sensor's noise, None while the filter takes its own."""
        self.distrusts_calibration = False
        """Whether the difference to another sensor has refuted what earlier flights have shown of this one; until the
        lane's filter is one without it, and what comes then was shown later."""
        self.noise_ns = -1
        """Time of the sample at which it was last looked at."""
        self._noise_in_use: SensorNoise | None = None
        self._refused_ns = -1
        self._adopted: FilterState | None = None

    @property
    def state(self) -> FilterState | None:
        """The filter's newest state; the next step goes on from it."""
        newest = self.moments.newest
        return self._adopted or (None if newest is None else newest.state)

    @property
    def is_navigating(self) -> bool:
        """True while the filter has an attitude."""
        return navigation_of(self.state) is not None

    @property
    def field_fits(self) -> bool:
        """False while the whole field is off by more than usual, and by more than the attitude's sigmas explain."""
        state = self.state
        if state is None or self.field.t_ns < 0:
            return True
        field = self.field
        usual = max(FIELD_LEAST, FIELD_USUALS * field.usual)
        return field.residual <= max(usual, FIELD_SIGMAS * hypotenuse(state.tilt_sigma, state.heading_sigma))

    def adopt(self, state: FilterState) -> None:
        """Go on from another state of the same instant as the newest one."""
        self._adopted = state
        self.fixes.forget_misfit()

    def begin_uncalibrated(self) -> None:
        """Begin anew without the sensor errors of earlier flights."""
        self.distrusts_calibration, self.filter = True, None
        self.begin_again()

    def begin_again(self) -> None:
        """Forget the attitude that was kept while the sensor stood aside, or that rests on wrong errors."""
        self.proving = ProvingFixes()
        newest, configured = self.moments.newest, self.configured
        if newest is not None and configured is not None:
            self.adopt(self.rest.begun_again(configured, newest.state))
        self.standing = Standing.NEW

    def step(
        self, one: AttitudeFilter, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs
    ) -> FilterState:
        """The state ``dt_s`` later; that of a lane which stands aside stays as it is."""
        if self._adopted is not None:
            state, self._adopted = self._adopted, None
        self.dead.take(sample, dt_s)
        after = state if self.standing == Standing.ASIDE else self._stepped(one, state, dt_s, sample, inputs)
        self.moments.append(Moment(sample.t_ns, dt_s, sample, inputs, state, after))
        if self.standing != Standing.ASIDE:
            self._watch_field(after, sample, inputs.inclination)
            self._check_rest(one)
        return after

    def _stepped(
        self, one: AttitudeFilter, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs
    ) -> FilterState:
        """One step of the filter; a fix outside the gate is not used."""
        if not isinstance(one, VelocityAided):
            return one.step(state, dt_s, sample, inputs)
        one = self._tuned(one)
        if navigation_of(state) is None:
            self.proving = ProvingFixes()
            return one.step(state, dt_s, sample, inputs)
        situation, fix = self.situation, inputs.velocity
        is_new = self.fixes.is_new(fix, one.parameters.fix_spacing_s, velocity_of(state))
        if fix is not None:
            fix = shifted(fix, situation.fix_shift_s)
        usable = fix is not None and situation.receiver_used and not self.fixes.frozen
        if usable and fix is not None and fix.t_ns != self._refused_ns:
            after = one.step(state, dt_s, sample, _with_velocity(inputs, fix))
            if not self._refuses(after, fix, sample):
                return after
            return one.step(state, dt_s, sample, _with_velocity(inputs, None))
        after = one.step(state, dt_s, sample, _with_velocity(inputs, None))
        if is_new and fix is not None and not self.fixes.frozen:
            record = unused_fix(one, after, fix)
            if record is not None:
                self._record(record, sample)
        return after

    def _refuses(self, after: FilterState, fix: VelocitySample, sample: ImuSample) -> bool:
        """Take note of a fix that the step used; True when a proven attitude contradicts it."""
        record = used_fix(after)
        if record is None or (self.fix is not None and record.t_ns == self.fix.t_ns):
            return False
        self._record(record, sample)
        fits = record.nis <= self.fixes.gate
        self.proving.take(fits)
        if fits and self.situation.calm:
            self.fixes.learn(record.nis, record.innovation)
        if fits or not self.proving.done:
            return False
        self._refused_ns = fix.t_ns
        return True

    def _check_rest(self, one: AttitudeFilter) -> None:
        """Begin again where the vehicle stands in another attitude."""
        moment = self.moments.newest
        if moment is not None and isinstance(one, VelocityAided) and self.rest.take(moment):
            self.adopt(self.rest.begun_again(one, moment.state))

    def _tuned(self, one: VelocityAided) -> VelocityAided:
        """The filter with the sensor's noise; it is made anew when either changes."""
        known = self.filter
        if known is None or one is not self.configured or self.noise is not self._noise_in_use:
            self.configured, self._noise_in_use = one, self.noise
            known = one if self.noise is None else self.noise.of(one)
            self.distrusts_calibration = self.distrusts_calibration and one.calibration is not None
            known = known.with_calibration(None) if self.distrusts_calibration else known
            self.filter = known
        return known

    def _record(self, record: FixRecord, sample: ImuSample) -> None:
        self.fix = record
        self.fix_seen_ns = sample.t_ns
        self.fixes.take(record.nis)

    def _watch_field(self, state: FilterState, sample: ImuSample, inclination: float) -> None:
        """Compare the direction of a new reading with the usual one. inclination: of the Earth's field, rad."""
        direction = field_direction(state, sample) if has_field_reading(state) else None
        if direction is not None:
            self.field.take(direction, sample.t_ns, self.situation.calm)
            self.field_reading = field_reading(self.name, state, sample, hard_iron(state), 0.0, inclination)


def _with_velocity(inputs: FilterInputs, velocity: VelocitySample | None) -> FilterInputs:
    """The inputs with this velocity: the same where they have it."""
    return inputs if inputs.velocity is velocity else inputs.with_velocity(velocity)
