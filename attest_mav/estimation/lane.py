"""One lane: one inertial sensor with its time base, its alignment and its filter."""

from typing import Final

from attest_mav.algebra import is_finite_number, norm, q_norm
from attest_mav.estimation.alignment import Aligner
from attest_mav.estimation.arrivals import Arrivals
from attest_mav.estimation.delay import DelayMeter
from attest_mav.estimation.events import Event, LaneEvent, LaneEventKind
from attest_mav.estimation.filter_run import NORTH_TEXTS, FilterRun
from attest_mav.estimation.lane_calibration import LaneCalibration
from attest_mav.estimation.lane_inputs import LaneInputs
from attest_mav.estimation.sensors import FreezeDetector, StuckMagnetometer
from attest_mav.estimation.stepper import Stepper
from attest_mav.estimation.timebase import StepKind, TimeBase, TimeStep
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.base import AttitudeFilter, FilterState
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.plausible import is_rate
from attest_mav.samples import ImuSample
from attest_mav.types import North, Quat


class Lane:
    """Samples of one source in, estimates and events out. stepper: takes the filter's steps. arrivals: their clock.

    Counters: samples (taken), repeats (same timestamp), late (out of order), strays (with a timestamp that nothing
    confirmed), gaps, restarts, rejected (no rate of a vehicle), frozen (repeated by a frozen sensor).
    """

    def __init__(
        self,
        source: str,
        attitude_filter: AttitudeFilter,
        vehicle: Vehicle,
        stepper: Stepper | None = None,
        arrivals: Arrivals = Arrivals.RECORDED,
    ) -> None:
        self.source: Final = source
        self.samples = 0
        self.repeats = 0
        self.late = 0
        self.strays = 0
        self.gaps = 0
        self.restarts = 0
        self.rejected = 0
        self.frozen = 0
        self._vehicle: Final = vehicle
        self._stepper: Final = Stepper() if stepper is None else stepper
        self._inputs: Final = LaneInputs(vehicle)
        self._filter = attitude_filter
        self.calibration: Final = LaneCalibration(source, vehicle)
        """Sensor errors of earlier flights, and whether the filter goes on from them."""
        self._run: Final = FilterRun(self.calibration.begin(attitude_filter))
        self._run.set_vehicle_settings(vehicle.settings)
        self.timebase: Final = TimeBase(arrivals)
        """Its samples' timestamps beside their arrivals."""
        self._aligner = Aligner()
        self.delay_s = 0.0
        """How late the newest sample came, s."""
        self._arrivals: Final = arrivals
        self._delay = DelayMeter(vehicle.clock, arrivals)
        self._freeze = FreezeDetector()
        self._field = StuckMagnetometer()
        self._aligned = False
        self._is_frozen = False
        self._frozen_s = 0.0

    @property
    def field_lost_s(self) -> float:
        """Time since the magnetometer could last be used, s; 0 where it never could."""
        return self._field.absent_s if self._field.was_used else 0.0

    @property
    def rests_on(self) -> str:
        """The aiding of the filter, see ``FilterState.rests_on``; "" before it runs."""
        state = self._run.state
        return "" if state is None else state.rests_on

    def continue_sign(self, q_nb: Quat) -> None:
        """Put out the quaternion of the sign that follows this one: q and -q are the same attitude."""
        self._run.output = q_nb

    def use_vehicle_settings(self) -> None:
        """Give the filter the vehicle's settings as they are now; its state goes on."""
        self._run.set_vehicle_settings(self._vehicle.settings)
        self.calibration.settings_changed()

    def use_filter(self, attitude_filter: AttitudeFilter) -> None:
        """Go on with other parameters of the same filter."""
        self._filter = attitude_filter
        calibrate = self.calibration.begin if self._run.state is None else self.calibration.calibrated
        self._run.use_filter(calibrate(attitude_filter), self._vehicle.settings)

    @property
    def learned(self) -> SensorCalibration | None:
        """The errors of the sensor as the filter knows them; None where it knows none."""
        run, state = self._run, self._run.state
        known = None if state is None else run.filter.learned(state)
        return None if known is None else self.calibration.identified(known)

    def handle(self, sample: ImuSample) -> list[Event]:
        """Take the next sample of this source."""
        events: list[Event] = []
        if not is_rate(sample.gyro):
            self.rejected += 1
            return events
        step = self.timebase.advance(sample.t_ns, sample.rx_ns, self._delay.least_ns)
        if not self._in_order(step, sample, events):
            return events
        self.delay_s = self._delay.delay_s(step.t_ns, sample.rx_ns)
        self.samples += 1
        if self._freeze.frozen(sample, step.dt_s):
            self._hold_frozen(sample, step.dt_s, events)
            return events
        # A filter that aligns itself has to know how long it has not seen the motion.
        dt_s = step.dt_s + self._frozen_s
        missing = step.kind in (StepKind.GAP, StepKind.RESTART) or self._frozen_s > 0.0
        self._is_frozen, self._frozen_s = False, 0.0
        if not self._field.usable(sample, norm(sample.gyro) * step.dt_s, step.dt_s) and sample.has_field:
            sample = sample.with_readings(sample.gyro, sample.accel, None)
        self._inputs.advance(sample, step.dt_s)
        if self.calibration.has_news:
            self._follow_sensors(sample, step.dt_s, events)
        self._step(sample, dt_s, missing, events)
        if not self._aligned:
            self._align(sample, step.dt_s, events)
        self._estimate(sample, step, events)
        return events

    def _in_order(self, step: TimeStep, sample: ImuSample, events: list[Event]) -> bool:
        """Act on the kind of the time step; False when the sample is to be dropped."""
        kind = step.kind
        if kind == StepKind.REPEAT:
            self.repeats += 1
            return False
        if kind == StepKind.LATE:
            self.late += 1
            return False
        if kind == StepKind.STRAY:
            self.strays += 1
            return False
        if kind == StepKind.GAP:
            self.gaps += 1
            self._tell(events, LaneEventKind.GAP, sample, f"no samples for {step.dt_s:.2f} s")
        elif kind == StepKind.RESTART:
            self.gaps += 1
            text = f"no samples for {step.dt_s:.2f} s: aligning again"
            self._restart(sample, events, LaneEventKind.RESTARTED, text)
        elif kind == StepKind.REBOOT:
            self._restart(sample, events, LaneEventKind.REBOOTED, "the sensor clock went back: aligning again")
            self._run.state = None
        return True

    def _restart(self, sample: ImuSample, events: list[Event], kind: LaneEventKind, text: str) -> None:
        """Begin alignment anew; the filter's last state stays, for its bias and heading."""
        self.restarts += 1
        self._aligned = False
        self._aligner = Aligner()
        if kind == LaneEventKind.REBOOTED:
            self._vehicle.clock.forget()
            self._delay = DelayMeter(self._vehicle.clock, self._arrivals)
        self._tell(events, kind, sample, text)

    def _hold_frozen(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        self.frozen += 1
        self._frozen_s += dt_s
        if not self._is_frozen:
            self._is_frozen = True
            self._restart(sample, events, LaneEventKind.FROZEN, "the sensor repeats one reading: samples ignored")

    def _align(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        """Feed the aligner; start the filter once it is done, unless it aligns itself."""
        stands = self._vehicle.stands
        start = self._aligner.add(sample, dt_s, stands)
        if start is None:
            return
        self._aligned = True
        if self._run.filter.aligns_itself:
            return
        self._run.begin(start, stands is True)
        manner = "at rest" if start.at_rest else "in motion, or in doubt of it"
        heading = "magnetic heading" if start.north == North.MAGNETIC else "no heading: it starts at zero"
        self._tell(events, LaneEventKind.ALIGNED, sample, f"aligned {manner}, {heading}")

    def _step(self, sample: ImuSample, dt_s: float, missing: bool, events: list[Event]) -> None:
        """One step of the filter if it runs; one that leaves the unit sphere sends the lane back to alignment."""
        run = self._run
        if run.state is None:
            run.begin_by_itself(sample)
            return
        if not self._aligned and not run.filter.aligns_itself:
            return
        inputs = self._inputs.give(sample, run.output, run.north, missing, run.filter.uses_body_velocity)
        state = self._stepper.step(run.filter, run.state, dt_s, sample, inputs)
        run.state = state
        length = q_norm(state.q_nb)
        if not is_finite_number(length) or length < 0.5:
            run.state = None
            self._restart(sample, events, LaneEventKind.RESTARTED, f"{run.filter.name} failed: aligning again")
            return
        self._judge(run, state, sample, events)

    def _judge(self, run: FilterRun, state: FilterState, sample: ImuSample, events: list[Event]) -> None:
        """Update whether the run is aligned, and the north that its heading refers to."""
        found = run.follow_north(state, sample, self._field.absent_s)
        if found is not None:
            self._tell(events, found, sample, NORTH_TEXTS[found])
        if run.filter.aligns_itself and state.aligned != run.aligned:
            kind = LaneEventKind.ALIGNED if state.aligned else LaneEventKind.RESTARTED
            text = "has found its attitude" if state.aligned else "has lost its attitude: aligning again"
            self._tell(events, kind, sample, f"{run.filter.name} {text}")
        run.aligned = state.aligned
        if state.aligned and state.is_calibrated != self.calibration.is_used:
            self.calibration.is_used = state.is_calibrated
            self._tell_calibration(sample, events)

    def _tell_calibration(self, sample: ImuSample, events: list[Event]) -> None:
        if self.calibration.is_used:
            text = f"begins with the {self.calibration.errors} of earlier flights"
            self._tell(events, LaneEventKind.CALIBRATED, sample, text)
        else:
            text = "contradicts the accelerometer bias or hard iron of earlier flights: both count as unknown"
            self._tell(events, LaneEventKind.UNCALIBRATED, sample, text)
            self._vehicle.refute_calibration(self.source)
            self.use_filter(self._filter)

    def _follow_sensors(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        """Let the filter go on with the errors of other sensors, where the autopilot tells of them."""
        run, changes = self._run, self.calibration.changes(dt_s)
        for kind, text in self.calibration.take_events():
            self._tell(events, kind, sample, text)
        if changes is None:
            return
        if run.state is not None:
            run.state = run.filter.after_changes(run.state, changes)
            self.calibration.is_used = run.state.is_calibrated
        self.use_filter(self._filter)

    def _estimate(self, sample: ImuSample, step: TimeStep, events: list[Event]) -> None:
        """Append the filter's estimate at this sample."""
        run, state = self._run, self._run.state
        runs = self._aligned or run.filter.aligns_itself
        if state is not None and runs and state.aligned:
            declination = self._vehicle.field.declination
            events.append(run.estimate(self.source, state, sample, step.t_ns, step.dt_s, self.delay_s, declination))

    def _tell(self, events: list[Event], kind: LaneEventKind, sample: ImuSample, text: str) -> None:
        events.append(LaneEvent(self.source, kind, sample.t_ns, sample.rx_ns, text))
