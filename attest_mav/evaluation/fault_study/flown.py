"""The daemon's core over the samples of a flight: errors, verdicts and events by the autopilot's clock."""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.estimate import Estimate
from attest_mav.estimation.events import Agreement, LaneEvent
from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.evaluation.fault_study.recording import LaneRecording
from attest_mav.filters.base import AttitudeFilter
from attest_mav.replay.comparison import Attitude, ComparedAttitude, Comparison
from attest_mav.replay.reference_track import ReferenceTrack
from attest_mav.replay.stamping import BurstStamp, Stamped
from attest_mav.samples import AttitudeSample, ImuSample, Sample
from attest_mav.types import NO_TIME, AttitudeRole, EarthField, North

Column = NDArray[np.float64]

LONGEST_S: Final = 0.2
"""An attitude counts for the time until the next one, at most for this long, s."""


@dataclass(frozen=True)
class Track:
    """Errors of one attitude over time: seconds of the autopilot's clock, and degrees; NaN without a truth."""

    t_s: Column
    tilt: Column
    heading: Column
    tilt_sigma: Column

    def durations(self) -> Column:
        """The time that each attitude stands for, s."""
        return np.minimum(np.diff(self.t_s, append=self.t_s[-1:]), LONGEST_S).clip(min=0.0)


@dataclass(frozen=True)
class FlownFaults:
    """Attitudes and verdicts of a flight with faults."""

    autopilot: Track
    agreement: NDArray[np.int_]
    """The verdict (``Agreement``) at each attitude of the autopilot."""
    ours: Track
    """The published attitudes."""
    events: tuple[tuple[float, str, str], ...]
    """Events of the lanes: time, s; name of the kind; lane and text."""


class _Columns:
    """Takes compared attitudes."""

    def __init__(self) -> None:
        self._flat: Final = array("d")

    def write(self, compared: ComparedAttitude) -> None:
        """Take the next one."""
        attitude = compared.attitude
        tilt, heading = compared.tilt, compared.heading
        errors = (nan if tilt is None else tilt, nan if heading is None else abs(heading))
        self._flat.extend((attitude.elapsed_s, *errors, attitude.tilt_sigma))

    def track(self) -> Track:
        """The columns."""
        t_s, tilt, heading, sigma = np.array(self._flat).reshape(-1, 4).T
        return Track(t_s, np.degrees(tilt), np.degrees(heading), np.degrees(sigma))


class FaultFlight:
    """Takes samples in order of arrival; ``timing`` names the message whose time an untimed truth takes."""

    def __init__(self, pipeline: Pipeline, truth: str, timing: str) -> None:
        self._pipeline: Final = pipeline
        self._truth: Final = truth
        self._timing: Final = timing
        self._stamp: Final = BurstStamp()
        self._reference: Final = ReferenceTrack()
        self._autopilot: Final = _Columns()
        self._ours: Final = _Columns()
        self._comparisons: Final = (
            Comparison("autopilot", self._reference, self._autopilot),
            Comparison("ours", self._reference, self._ours),
        )
        self._agreement: Final[list[int]] = []
        self._events: Final[list[tuple[float, str, str]]] = []

    def take(self, sample: Sample) -> None:
        """Take the next sample."""
        pipeline = self._pipeline
        if isinstance(sample, AttitudeSample) and sample.role == AttitudeRole.TRUTH:
            if sample.source == self._truth:
                self._take_truth(
                    self._stamp.untimed(sample) if sample.t_ns == NO_TIME else Stamped(sample, sample.t_ns)
                )
            return
        for event in pipeline.handle(sample):
            if isinstance(event, LaneEvent):
                self._events.append((event.t_ns * 1e-9, event.kind.name, f"{event.lane}: {event.text}"))
            elif isinstance(event, Estimate) and event is pipeline.estimate and pipeline.publishes:
                north = event.north
                self._comparisons[1].add(
                    Attitude(event.t_ns, event.t_ns * 1e-9, event.q_nb, north, event.tilt_sigma, nan, counted=False)
                )
        if isinstance(sample, AttitudeSample) and sample.source == self._timing:
            self._take_autopilot(sample)

    def finish(self) -> FlownFaults:
        """The flight has ended."""
        self._take_truth(self._stamp.finish())
        for comparison in self._comparisons:
            comparison.finish()
        agreement = np.array(self._agreement, dtype=np.int_)
        return FlownFaults(self._autopilot.track(), agreement, self._ours.track(), tuple(self._events))

    def _take_autopilot(self, sample: AttitudeSample) -> None:
        """The autopilot's attitude: it is compared with the truth, its time is the truth's."""
        t_s = sample.t_ns * 1e-9
        verdict = self._pipeline.verdict
        self._agreement.append(Agreement.UNDECIDED if verdict is None else verdict.agreement)
        self._comparisons[0].add(Attitude(sample.t_ns, t_s, sample.q_nb, North.TRUE, nan, nan, counted=False))
        self._take_truth(self._stamp.timed(sample.t_ns, sample.rx_ns))

    def _take_truth(self, stamped: Stamped | None) -> None:
        if stamped is None:
            return
        self._reference.add(stamped.t_ns, stamped.sample.q_nb, stamped.sample.rates)
        for comparison in self._comparisons:
            comparison.settle()


def fly(flight: LaneRecording, samples: Sequence[Sample], one: AttitudeFilter, lanes: Sequence[str]) -> FlownFaults:
    """Fly samples made of a recording, on these inertial streams."""
    recording = flight.recording
    plan = recording.plan
    earth_field = recording.earth_field
    pipeline = Pipeline(PipelineSettings(), one.with_vehicle_settings(recording.settings), lanes)
    pipeline.set_field(EarthField() if earth_field is None else earth_field.direction)
    run = FaultFlight(pipeline, plan.reference or "", plan.timing or "ATTITUDE")
    for sample in samples:
        run.take(sample)
    return run.finish()


def between(samples: Sequence[Sample], first_s: float, last_s: float = inf) -> list[Sample]:
    """The samples that arrived between two instants of the inertial sensors' clock."""
    kept: list[Sample] = []
    now_s = -inf
    for sample in samples:
        if isinstance(sample, ImuSample):
            now_s = sample.t_ns * 1e-9
        if first_s <= now_s <= last_s:
            kept.append(sample)
    return kept
