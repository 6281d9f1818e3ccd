"""One recorded flight on its way through the filters: samples in, comparisons out."""

from dataclasses import dataclass
from math import inf, nan
from typing import Final

from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.estimation.timebase import WRAP_NS
from attest_mav.filters.base import AttitudeFilter
from attest_mav.logs.tlog.annotate import Weaver
from attest_mav.replay.comparison import Attitude, Comparison, RowSink
from attest_mav.replay.log_time import LogTime, Regularity
from attest_mav.replay.plan import Plan
from attest_mav.replay.stamping import BurstStamp, Stamped
from attest_mav.replay.track import AttitudeTrack
from attest_mav.types import NO_TIME, AttitudeSample, EarthField, Estimate, ImuSample, North, Sample

AUTOPILOT_ROW: Final = "autopilot"
"""Name of the autopilot's own attitude among the rows."""


@dataclass(frozen=True)
class Window:
    """What part of a log is read, and counted; seconds of log time.

    start_s, end_s: only inertial samples between them are taken. skip_s: left out of the figures after alignment.
    """

    start_s: float = 0.0
    end_s: float = inf
    skip_s: float = 30.0


class Run:
    """One filter over the flight."""

    def __init__(self, one: AttitudeFilter, imu: str, field: EarthField, comparison: Comparison) -> None:
        self.comparison: Final = comparison
        self.pipeline: Final = Pipeline(PipelineSettings(), one, [imu])
        self.pipeline.set_field(field)
        self.aligned_s = inf
        """Log time of the first estimate."""


class Flight:
    """Takes the decoded samples of one vehicle in order.

    field: without a declination headings stay magnetic.
    """

    def __init__(
        self,
        plan: Plan,
        filters: list[AttitudeFilter],
        field: EarthField,
        window: Window,
        rows: RowSink | None = None,
        weaver: Weaver | None = None,
    ) -> None:
        track = AttitudeTrack()
        self.runs: Final = [Run(one, plan.imu, field, Comparison(one.name, track, rows)) for one in filters]
        self.autopilot: Final = Comparison(AUTOPILOT_ROW, track, rows) if plan.autopilot is not None else None
        self._comparisons: Final = [run.comparison for run in self.runs]
        if self.autopilot is not None:
            self._comparisons.append(self.autopilot)
        self.imu: Final = Regularity()
        self.reference_samples = 0
        self.sender: Final = plan.sender
        self.window: Final = window
        self._plan: Final = plan
        self._weaver: Final = weaver
        self._track: Final = track
        self._time: Final = LogTime()
        self._stamp: Final = BurstStamp()
        self._reading = window.start_s <= 0.0

    def take(self, sample: Sample, offset: int) -> None:
        """Take the next sample. ``offset``: where the record that it came from ends in the log."""
        if isinstance(sample, ImuSample):
            if sample.source == self._plan.imu:
                self._take_imu(sample, offset)
            if sample.source == self._plan.timing:
                self._take_stamped(self._stamp.timed(sample.t_ns, sample.rx_ns))
        elif isinstance(sample, AttitudeSample):
            self._take_attitude(sample)
        else:
            for run in self.runs:
                run.pipeline.handle(sample)

    def finish(self) -> None:
        """The log has ended."""
        self._take_stamped(self._stamp.finish())
        for comparison in self._comparisons:
            comparison.finish()
        if self._weaver is not None:
            self._weaver.finish()

    def _take_imu(self, sample: ImuSample, offset: int) -> None:
        elapsed_s = self._time.advance(sample.t_ns)
        self._reading = self.window.start_s <= elapsed_s <= self.window.end_s
        if not self._reading:
            return
        self.imu.add(sample.t_ns)
        for run in self.runs:
            for event in run.pipeline.handle(sample):
                if isinstance(event, Estimate):
                    self._take_estimate(run, event, elapsed_s)
                    if self._weaver is not None and run is self.runs[0]:
                        self._weaver.insert(event, offset)

    def _take_estimate(self, run: Run, estimate: Estimate, elapsed_s: float) -> None:
        run.aligned_s = min(run.aligned_s, elapsed_s)
        run.comparison.add(
            Attitude(
                estimate.t_ns,
                elapsed_s,
                estimate.q_nb,
                estimate.north,
                estimate.tilt_sigma,
                estimate.heading_sigma,
                elapsed_s >= run.aligned_s + self.window.skip_s,
                estimate.velocity_nis,
                estimate.field_nis,
            )
        )

    def _take_attitude(self, sample: AttitudeSample) -> None:
        """The reference, the autopilot's attitude, or the message that lends the reference its time: or two of them."""
        if sample.source == self._plan.timing:
            self._take_stamped(self._stamp.timed(sample.t_ns, sample.rx_ns))
        if sample.source == self._plan.reference and self._reading:
            self.reference_samples += 1
            if sample.t_ns == NO_TIME:
                self._take_stamped(self._stamp.untimed(sample))
            else:
                self._take_reference(sample, sample.t_ns)
        if sample.source == self._plan.autopilot and self._reading:
            self._take_own(sample)

    def _take_own(self, sample: AttitudeSample) -> None:
        """Compare the autopilot's own attitude, once there is a first inertial sample to count time from."""
        if self.autopilot is None or not self.imu.samples:
            return
        elapsed_s = self._time.at(sample.t_ns)
        counted = elapsed_s >= self.runs[0].aligned_s + self.window.skip_s
        self.autopilot.add(Attitude(sample.t_ns, elapsed_s, sample.q_nb, North.TRUE, nan, nan, counted))

    def _take_stamped(self, stamped: Stamped | None) -> None:
        if stamped is not None:
            self._take_reference(stamped.sample, stamped.t_ns)

    def _take_reference(self, sample: AttitudeSample, t_ns: int) -> None:
        """The reference has grown: what waited for it can be compared."""
        self._track.add(t_ns % WRAP_NS, sample.q_nb, sample.rates)
        for comparison in self._comparisons:
            comparison.settle()
