"""The pipeline: samples in; estimates, lane events and verdicts out. It never waits and reads no clock.

Live, replay and simulation drive the same object: ``handle`` for every sample, ``poll`` when ``next_deadline_ns``
has come. Each inertial stream is a lane of its own. The primary lane is the first of ``sources``, or where none are
given the first stream that arrives; it alone is published and compared with the autopilot.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import nan
from typing import Final

from attest_mav.estimation.events import Agreement, Event, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.lane import Lane
from attest_mav.estimation.vehicle import AidSettings, Vehicle
from attest_mav.estimation.verdict import Judge, VerdictSettings
from attest_mav.filters.base import AttitudeFilter
from attest_mav.types import (
    AttitudeForm,
    AttitudeRole,
    AttitudeSample,
    EarthField,
    Estimate,
    ImuSample,
    ParameterSample,
    Sample,
    VehicleSettings,
)

_NS: Final = 1_000_000_000


@dataclass(frozen=True)
class PipelineSettings:
    """When to stop, and what to compare.

    stale_s: without a sample for this long there is no estimate, and one that comes later than this does not hold.
    verdict: thresholds of the comparison with the autopilot. aids: what aids the filters.
    """

    stale_s: float = 0.5
    verdict: VerdictSettings = field(default_factory=VerdictSettings)
    aids: AidSettings = field(default_factory=AidSettings)


class Pipeline:
    """One vehicle's samples to its estimates and verdict.

    attitude_filter: runs on every lane. sources: names of the inertial streams to use; empty takes the first that
    arrives. The caller passes samples of one vehicle only.
    """

    def __init__(
        self, settings: PipelineSettings, attitude_filter: AttitudeFilter, sources: Sequence[str] = ()
    ) -> None:
        self.lanes: Final[dict[str, Lane]] = {}
        self.vehicle: Final = Vehicle(settings.aids)
        """What is known of the vehicle, shared by all lanes."""
        self.estimate: Estimate | None = None
        """Newest valid estimate of the primary lane, else None. Late ones are returned by ``handle`` but not kept."""
        self.verdict: Verdict | None = None
        """The newest verdict."""
        self._settings = settings
        self._filter = attitude_filter
        self._sources = list(sources)
        self._judge = Judge(settings.verdict)
        self._attitude_form = AttitudeForm.EULER
        self._attitude_source = ""
        self._attitude_rx_ns = -1

    @property
    def primary(self) -> str:
        """Name of the primary lane's stream, "" before one is known."""
        return self._sources[0] if self._sources else ""

    def set_field(self, field: EarthField) -> None:
        """From now on this is the field where the vehicle is: with its declination headings refer to true north."""
        self.vehicle.field = field

    def set_vehicle_settings(self, known: VehicleSettings) -> None:
        """From now on these are the vehicle's settings; for all others the filter keeps its defaults."""
        self.vehicle.settings = known
        for lane in self.lanes.values():
            lane.use_vehicle_settings()

    def handle(self, sample: Sample) -> list[Event]:
        """Take one sample, in order of arrival; what follows from it, in order."""
        if isinstance(sample, ImuSample):
            return self._handle_imu(sample)
        if isinstance(sample, AttitudeSample):
            return self._handle_attitude(sample)
        self.vehicle.take(sample)
        if isinstance(sample, ParameterSample):
            self.set_vehicle_settings(self.vehicle.settings)
        return []

    def poll(self, now_ns: int) -> list[Event]:
        """What follows from nothing having come until ``now_ns`` (host clock)."""
        events: list[Event] = []
        estimate = self.estimate
        if estimate is not None and now_ns >= estimate.rx_ns + self._stale_ns():
            self.estimate = None
            self._judge.forget_estimate()
            text = f"no usable sample for {self._settings.stale_s:g} s: nothing is published"
            events.append(LaneEvent(estimate.lane, LaneEventKind.STOPPED, estimate.t_ns, now_ns, text))
            events.append(self._undecided("no-estimate", now_ns))
        elif self._attitude_rx_ns >= 0 and now_ns >= self._reference_deadline_ns():
            self._attitude_rx_ns = -1
            events.append(self._undecided("no-reference", now_ns))
        return events

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` has something to say if nothing comes, on the host clock; None while nothing is pending."""
        deadlines = []
        if self.estimate is not None:
            deadlines.append(self.estimate.rx_ns + self._stale_ns())
        if self._attitude_rx_ns >= 0:
            deadlines.append(self._reference_deadline_ns())
        return min(deadlines) if deadlines else None

    def _handle_imu(self, sample: ImuSample) -> list[Event]:
        """Run the sample's lane; publish and remember what the primary lane says."""
        source = sample.source
        if not self._sources:
            self._sources.append(source)
        if source not in self._sources:
            return []
        lane = self.lanes.get(source)
        if lane is None:
            lane = Lane(source, self._filter, self.vehicle)
            self.lanes[source] = lane
        taken = lane.samples
        events = lane.handle(sample)
        if source == self._sources[0] and lane.samples > taken:
            self._follow_primary(events)
        return events

    def _follow_primary(self, events: list[Event]) -> None:
        """Take over the primary lane's new estimate; there is none while its filter aligns."""
        for event in events:
            if isinstance(event, Estimate):
                if event.delay_s <= self._settings.stale_s:
                    self.estimate = event
                    self._judge.take_estimate(event)
                return
        self.estimate = None
        self._judge.forget_estimate()

    def _handle_attitude(self, sample: AttitudeSample) -> list[Event]:
        """Judge the autopilot's attitude: as a quaternion where it is sent as one, else as Euler angles."""
        if sample.role != AttitudeRole.AUTOPILOT:
            return []
        preferred = sample.form >= self._attitude_form
        if not preferred and sample.rx_ns < self._reference_deadline_ns():
            return []
        self._attitude_form = sample.form
        self._attitude_source = sample.source
        self._attitude_rx_ns = sample.rx_ns
        self.verdict = self._judge.judge(sample)
        return [self.verdict]

    def _undecided(self, reason: str, now_ns: int) -> Verdict:
        self.verdict = Verdict(Agreement.UNDECIDED, reason, nan, nan, self._attitude_source, -1, now_ns)
        return self.verdict

    def _stale_ns(self) -> int:
        return int(self._settings.stale_s * _NS)

    def _reference_deadline_ns(self) -> int:
        return self._attitude_rx_ns + int(self._settings.verdict.stale_s * _NS)
