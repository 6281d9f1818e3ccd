"""The filters over one recorded flight: samples in, comparisons out."""

from collections.abc import Sequence
from math import inf, nan
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.estimation.events import Event, LaneEvent, Verdict
from attest_mav.estimation.imu_frame import ImuFrame
from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.estimation.timebase import WRAP_NS
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.source import EstimateWriter, Plan
from attest_mav.replay.comparison import Attitude, Comparison, ComparisonSink
from attest_mav.replay.lane_faults import LaneFaults
from attest_mav.replay.log_time import LogTime, Motion, Regularity
from attest_mav.replay.observer import FlightObserver, joined
from attest_mav.replay.peaks import WallClock
from attest_mav.replay.phases import FlightPhases
from attest_mav.replay.reference_track import ReferenceTrack
from attest_mav.replay.request import Window
from attest_mav.replay.smoothed import SmoothedFlight
from attest_mav.replay.smoothed_run import SmoothedRun
from attest_mav.replay.stamping import BurstStamp, Stamped
from attest_mav.replay.steady_tilt import SteadyTilt
from attest_mav.replay.verdict_log import VerdictLog
from attest_mav.samples import AttitudeSample, ImuSample, PositionSample, Sample
from attest_mav.types import NO_TIME, AttitudeRole, EarthField, North, Quat, Vec3
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import VehicleSettings

AUTOPILOT: Final = "autopilot"
"""Name of the autopilot's own attitude among the compared ones."""
POLL_NS: Final = 200_000_000
"""Period at which a filter is asked whether samples or attitudes have stopped, ns."""


class FilterRun:
    """One filter over the flight."""

    def __init__(
        self,
        one: AttitudeFilter,
        settings: PipelineSettings,
        plan: Plan,
        field: EarthField,
        comparison: Comparison,
        verdicts: VerdictLog,
    ) -> None:
        self.one: Final = one
        self.settings: Final = settings
        self.comparison: Final = comparison
        self.verdicts: Final = verdicts
        self.faults: Final = LaneFaults()
        others = plan.other_sensors if isinstance(one, VelocityAided) else ()  # without a witness they serve nothing
        self.pipeline: Final = Pipeline(self.settings, one, [plan.imu, *others])
        self.pipeline.set_field(field)
        self.aligned_s = inf
        """Log time of the first estimate, s."""
        self.poll_ns = 0
        """When the pipeline was last asked whether something has stopped, time of reception."""


class Flight:
    """Takes the samples of one vehicle in order of time. Without a declination in ``field``, headings stay magnetic."""

    def __init__(
        self,
        plan: Plan,
        filters: Sequence[AttitudeFilter],
        field: EarthField,
        window: Window,
        sink: ComparisonSink | None = None,
        writer: EstimateWriter | None = None,
        opening: Sequence[Sample] = (),
        settings: PipelineSettings | None = None,
        observer: FlightObserver | None = None,
        first_settings: VehicleSettings | None = None,
        smoothed: SmoothedFlight | None = None,
    ) -> None:
        """first_settings: what filters know at first, where they shall learn the rest as the log tells it.

        None for filters that know everything from the start.
        """
        settings = PipelineSettings() if settings is None else settings
        sink = joined(sink, observer)
        reference = ReferenceTrack()
        # A trim shows against the autopilot's own attitude, which then is no attitude to be compared.
        shows_trim = plan.autopilot is None
        self._vehicle: Final = Vehicle(settings.aids)
        report = self._vehicle.self_report
        compared = [Comparison(one.name, reference, sink, SteadyTilt() if shows_trim else None) for one in filters]
        self.runs: Final = [
            FilterRun(one, settings, plan, field, comparison, VerdictLog(report))
            for one, comparison in zip(filters, compared, strict=True)
        ]
        self.autopilot: Final = Comparison(AUTOPILOT, reference, sink) if plan.autopilot is not None else None
        """The comparison of the autopilot's own attitude."""
        self.smoothed: Final = None if smoothed is None else SmoothedRun(smoothed, plan, reference, sink)
        """The smoothed attitude, as the reference or beside it."""
        self._comparisons: Final = [run.comparison for run in self.runs]
        if self.smoothed is not None:
            self._comparisons.append(self.smoothed.comparison)
        if self.autopilot is not None:
            self._comparisons.append(self.autopilot)
        self.imu: Final = Regularity()
        self.sensors: Final = {name: Regularity() for name in (plan.imu, *plan.other_sensors)} | {plan.imu: self.imu}
        """The streams of the inertial sensors; ``imu`` is the first of them."""
        self.motion: Final = Motion()
        self.phases: Final = FlightPhases()
        self.clock: Final = WallClock()
        self.reference_samples = 0
        self.window: Final = window
        self._imu_source: Final[str] = plan.imu
        self._other_sensors: Final[tuple[str, ...]] = plan.other_sensors
        self._reference_source: Final[str | None] = plan.reference
        self._autopilot_source: Final[str | None] = plan.autopilot
        self._timing_source: Final[str | None] = plan.timing
        self._writer: Final = writer
        self._observer: Final = observer
        self._learns: Final = first_settings is not None
        self._field: Final = field
        if first_settings is not None:
            for run in self.runs:
                run.pipeline.set_field(EarthField())
                run.pipeline.set_vehicle_settings(first_settings)
        self._reference: Final = reference
        self._time: Final = LogTime()
        self._stamp: Final = BurstStamp()
        self._reading = window.start_s <= 0.0
        self._elapsed_s = 0.0
        self._rx_ns = 0
        self.imu_frame: Final = ImuFrame(self._vehicle)
        """Turns the autopilot's attitudes into the frame of the inertial messages."""
        for sample in opening:
            self._vehicle.take(sample)
            self.phases.take(sample, 0.0)

    def take(self, sample: Sample, position: int = 0) -> None:
        """Take the next sample. ``position``: the end of its record in the log, for the writer."""
        if isinstance(sample, ImuSample):
            if sample.source == self._imu_source:
                self._take_imu(sample, position)
            elif self._reading and self.imu.samples and sample.source in self._other_sensors:
                self.sensors[sample.source].add(sample.t_ns)
                self._fly(sample, self._time.at(sample.t_ns), position)
            if sample.source == self._timing_source:
                self._take_stamped(self._stamp.timed(sample.t_ns, sample.rx_ns))
        elif isinstance(sample, AttitudeSample):
            self._take_attitude(sample)
        else:
            self._take_other(sample)

    def finish(self) -> None:
        """The log has ended."""
        self._take_stamped(self._stamp.finish())
        for comparison in self._comparisons:
            comparison.finish()
        for run in self.runs:
            run.verdicts.finish(self._elapsed_s, self._rx_ns)
        if self._writer is not None:
            self._writer.finish()

    def _take_other(self, sample: Sample) -> None:
        """A sample of the vehicle. Filters that do not learn have its settings: a change is for the frames alone."""
        self._vehicle.take(sample)
        self.phases.take(sample, self._elapsed_s)
        self.clock.take(sample)
        if self._observer is not None and self._reading and self.imu.samples:
            self._observer.vehicle(sample, self._elapsed_s)
        if self._learns and isinstance(sample, PositionSample):
            for run in self.runs:
                run.pipeline.set_field(self._field)
        if self._learns or not isinstance(sample, ParameterSample):
            for run in self.runs:
                run.pipeline.handle(sample)

    def _take_imu(self, sample: ImuSample, position: int) -> None:
        elapsed_s = self._time.advance(sample.t_ns)
        self._reading = self.window.start_s <= elapsed_s <= self.window.end_s
        if not self._reading:
            return
        self.imu.add(sample.t_ns)
        self.motion.add(sample.t_ns, sample.gyro)
        self.phases.turn(sample.gyro[2], elapsed_s)
        self.clock.settle(self._time)
        self._reference.add_rates(sample.t_ns % WRAP_NS, sample.gyro)
        if self.smoothed is not None:
            self._take_smoothed(self.smoothed, sample, elapsed_s, position)
        self._fly(sample, elapsed_s, position)

    def _fly(self, sample: ImuSample, elapsed_s: float, position: int) -> None:
        """The filters take a sample of the stretch to be read."""
        self._elapsed_s, self._rx_ns = elapsed_s, sample.rx_ns
        observer = self._observer
        if observer is not None:
            observer.imu(sample, elapsed_s)
        for run in self.runs:
            if abs(run.poll_ns - sample.rx_ns) >= POLL_NS:
                run.poll_ns = sample.rx_ns
                self._judge(run, tuple(run.pipeline.poll(sample.rx_ns)))
                run.verdicts.settle(elapsed_s, sample.rx_ns)
            events = run.pipeline.handle(sample)
            is_selected = sample.source == run.pipeline.selected
            for event in events:
                if not isinstance(event, Estimate):
                    self._judge(run, (event,))
                elif is_selected:
                    if observer is not None:
                        observer.estimate(run.comparison.name, event, sample)
                    self._take_estimate(run, event, elapsed_s)
                    if self._writer is not None and run is self.runs[0] and self.smoothed is None:
                        self._writer.insert(event, position)

    @property
    def _reference_is_sure(self) -> bool:
        """False where the reference is a smoothed attitude with too large a sigma."""
        return self.smoothed is None or self.smoothed.is_sure

    def _take_smoothed(self, run: SmoothedRun, sample: ImuSample, elapsed_s: float, position: int) -> None:
        """The smoothed attitude at an inertial sample: into the reference, or beside it, and into the annotated log."""
        counted = elapsed_s >= self.runs[0].aligned_s + self.window.skip_s
        estimate = run.take(sample, elapsed_s, counted, self.clock.unix_s(elapsed_s))
        if estimate is None:
            return
        if self._writer is not None:
            self._writer.insert(estimate, position)
        if run.is_reference:
            self.reference_samples += 1
            self._extend_reference(sample.t_ns, estimate.q_nb, estimate.rates)

    def _judge(self, run: FilterRun, events: tuple[Event, ...]) -> None:
        """Keep the verdicts beside a filter, and the events of its lane."""
        for event in events:
            if isinstance(event, Verdict):
                elapsed_s = self._elapsed_s if event.t_ns < 0 else self._time.at(event.t_ns)
                run.verdicts.take(event, elapsed_s)
                if self._observer is not None:
                    self._observer.verdict(run.comparison.name, event, elapsed_s)
            elif isinstance(event, LaneEvent):
                if self._observer is not None:
                    self._observer.lane_event(run.comparison.name, event, self._elapsed_s)
                run.verdicts.lane_event(event)
                run.faults.take(event, self._elapsed_s)

    def _take_estimate(self, run: FilterRun, estimate: Estimate, elapsed_s: float) -> None:
        run.aligned_s = min(run.aligned_s, elapsed_s)
        run.comparison.add(
            Attitude(
                estimate.t_ns,
                elapsed_s,
                estimate.q_nb,
                estimate.north,
                estimate.tilt_sigma,
                estimate.heading_sigma,
                elapsed_s >= run.aligned_s + self.window.skip_s and self._reference_is_sure,
                estimate.innovations,
                self.clock.unix_s(elapsed_s),
            )
        )

    def _take_attitude(self, sample: AttitudeSample) -> None:
        """The reference, the autopilot's attitude, the message that times the reference, or two of these."""
        self._vehicle.self_report.take(sample)
        if sample.source == self._timing_source:
            self._take_stamped(self._stamp.timed(sample.t_ns, sample.rx_ns))
        is_reference = sample.source == self._reference_source
        if not self._reading or not (is_reference or sample.source == self._autopilot_source):
            return
        in_imu_frame = self.imu_frame.attitude(sample)
        if in_imu_frame is None:
            return
        if sample.role == AttitudeRole.AUTOPILOT and self.imu.samples:
            for run in self.runs:
                self._judge(run, run.pipeline.compare(in_imu_frame))
        if not is_reference:
            self._take_own(in_imu_frame)
            return
        self.reference_samples += 1
        if sample.t_ns == NO_TIME:
            self._take_stamped(self._stamp.untimed(in_imu_frame))
        else:
            self._take_reference(in_imu_frame, sample.t_ns)

    def _take_own(self, sample: AttitudeSample) -> None:
        """Compare the autopilot's own attitude, once there is a first inertial sample to count time from."""
        if self.autopilot is None or not self.imu.samples:
            return
        elapsed_s = self._time.at(sample.t_ns)
        counted = elapsed_s >= self.runs[0].aligned_s + self.window.skip_s and self._reference_is_sure
        unix_s = self.clock.unix_s(elapsed_s)
        self.autopilot.add(Attitude(sample.t_ns, elapsed_s, sample.q_nb, North.TRUE, nan, nan, counted, unix_s=unix_s))

    def _take_stamped(self, stamped: Stamped | None) -> None:
        if stamped is not None:
            self._take_reference(stamped.sample, stamped.t_ns)

    def _take_reference(self, sample: AttitudeSample, t_ns: int) -> None:
        """Extend the reference, and compare the attitudes that waited for it."""
        self._extend_reference(t_ns, sample.q_nb, sample.rates)

    def _extend_reference(self, t_ns: int, q_nb: Quat, rates: Vec3 | None) -> None:
        self._reference.add(t_ns % WRAP_NS, q_nb, rates)
        if self._observer is not None and self.imu.samples:
            self._observer.reference(q_nb, self._time.at(t_ns))
        for comparison in self._comparisons:
            comparison.settle()
