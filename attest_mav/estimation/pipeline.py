"""The pipeline: samples in; estimates, lane events and verdicts out. It never waits and reads no clock.

Live, replay and simulation drive the same object: ``handle`` for every sample, ``poll`` when ``next_deadline_ns``
has come. Each inertial message is a lane of its own. The primary lane is the first of ``sources``, or where none are
given the first message that arrives; it alone is published and compared with the autopilot, by its first filter.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import nan
from typing import Final

from attest_mav.estimation.events import Agreement, Event, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.lane import Lane
from attest_mav.estimation.vehicle import AidSettings
from attest_mav.estimation.verdict import Judge, VerdictSettings
from attest_mav.filters.base import AttitudeFilter, VehicleFacts
from attest_mav.types import AttitudeSample, EarthField, Estimate, ImuSample, ParameterSample, Sample

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

    filters: run side by side on every lane; the first one is published. sources: names of the inertial messages to
    use; empty takes the first that arrives. The caller passes samples of one vehicle only.
    """

    def __init__(
        self, settings: PipelineSettings, filters: Sequence[AttitudeFilter], sources: Sequence[str] = ()
    ) -> None:
        self.lanes: Final[dict[str, Lane]] = {}
        self.estimate: Estimate | None = None
        """The newest estimate of the primary lane, None while there is none that holds. One that came too late to hold
        is in the events of ``handle``, and not here."""
        self.verdict: Verdict | None = None
        """The newest verdict."""
        self.facts = VehicleFacts()
        """What the filters know of the vehicle's settings, unless they go their own way; see ``inform``."""
        self._settings = settings
        self._filters = list(filters)
        self._sources = list(sources)
        self._judge = Judge(settings.verdict)
        self._field = EarthField()
        self._newest: dict[str, Sample] = {}
        self._attitude_source = ""
        self._attitude_rx_ns = -1

    @property
    def primary(self) -> str:
        """Name of the primary lane's message, "" before one is known."""
        return self._sources[0] if self._sources else ""

    def set_field(self, field: EarthField) -> None:
        """From now on this is the field where the vehicle is: with its declination headings refer to true north."""
        self._field = field
        for lane in self.lanes.values():
            lane.aiding.field = field

    def inform(self, facts: VehicleFacts) -> None:
        """From now on these are the vehicle's settings, and all others what each filter assumes."""
        self.facts = facts
        for lane in self.lanes.values():
            lane.inform(facts)

    def handle(self, sample: Sample) -> list[Event]:
        """Take one sample, in order of arrival; what follows from it, in order."""
        if isinstance(sample, ImuSample):
            return self._handle_imu(sample)
        if isinstance(sample, AttitudeSample):
            return self._handle_attitude(sample)
        if isinstance(sample, ParameterSample):
            self.inform(self.facts.told(sample.setting, sample.value))
            return []
        # One GPS_RAW_INT gives a velocity and a position.
        self._newest[type(sample).__name__ + sample.source] = sample
        for lane in self.lanes.values():
            lane.aiding.take(sample)
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
            lane = Lane(source, self._filters, self._settings.aids)
            lane.aiding.field = self._field
            lane.inform(self.facts)
            for known in self._newest.values():
                lane.aiding.take(known)
            self.lanes[source] = lane
        taken = lane.samples
        events = lane.handle(sample)
        if source == self._sources[0] and lane.samples > taken:
            self._follow_primary(events)
        return events

    def _follow_primary(self, events: list[Event]) -> None:
        """Take over the first filter's new estimate; there is none while it aligns."""
        for event in events:
            if isinstance(event, Estimate) and event.filter_name == self._filters[0].name:
                if event.delay_s <= self._settings.stale_s:
                    self.estimate = event
                    self._judge.take_estimate(event)
                return
        self.estimate = None
        self._judge.forget_estimate()

    def _handle_attitude(self, sample: AttitudeSample) -> list[Event]:
        """Judge the autopilot's attitude: ATTITUDE_QUATERNION where it arrives, else ATTITUDE."""
        if sample.source == "ATTITUDE" and self._attitude_source == "ATTITUDE_QUATERNION":
            if sample.rx_ns < self._reference_deadline_ns():
                return []
        elif sample.source not in ("ATTITUDE", "ATTITUDE_QUATERNION"):
            return []
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
