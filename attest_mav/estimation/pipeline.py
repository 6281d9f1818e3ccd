"""The pipeline: samples in; estimates, lane events and verdicts out. No call waits or reads a clock.

Live, replay and simulation drive the same object: ``handle`` for every sample, ``poll`` when ``next_deadline_ns``
has come. Each inertial stream is a lane of its own. With a velocity-aided filter the witness selects the lane that is
published and compared with the autopilot, and says which other attitudes are not refuted; with any other filter the
primary lane is selected: the first of ``sources``, or where none are given the first stream that arrives.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import radians
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.estimation.arrivals import Arrivals
from attest_mav.estimation.attitude_check import STALE_INTERVALS, AttitudeCheck
from attest_mav.estimation.events import Agreement, Event, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.freshness import FreshnessWatch
from attest_mav.estimation.imu_frame import ImuFrame
from attest_mav.estimation.lane import Lane
from attest_mav.estimation.trim_watch import TrimWatch
from attest_mav.estimation.vehicle import AidSettings, Vehicle
from attest_mav.estimation.verdict import VerdictSettings
from attest_mav.estimation.witness.witness import Witness
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import AttitudeSample, ImuSample, Sample
from attest_mav.types import AttitudeRole, EarthField
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import VehicleSettings

_NS: Final = 1_000_000_000

DOUBTED_SHARE: Final = 0.5
"""Delays above this share of ``PipelineSettings.stale_s`` are worth a question for the autopilot's time."""


@dataclass(frozen=True)
class PipelineSettings:
    """Time limit of an estimate, and settings of verdict and aiding.

    stale_s: without a sample for this long there is no estimate, and one that comes later than this does not hold.
    max_sigma: above this tilt sigma an estimate is not published, rad. verdict: thresholds of the comparison with the
    autopilot. aids: what aids the filters. arrivals: the clock of the samples' arrivals.
    """

    stale_s: float = 0.5
    max_sigma: float = radians(3.0)
    verdict: VerdictSettings = field(default_factory=VerdictSettings)
    aids: AidSettings = field(default_factory=AidSettings)
    arrivals: Arrivals = Arrivals.RECORDED


class Pipeline:
    """One vehicle's samples to its estimates and verdict.

    attitude_filter: runs on every lane. sources: names of the inertial streams to use; empty takes the first that
    arrives. vehicle: what is known of the vehicle from before, which then is kept in that record and goes on when the
    pipeline ends. The caller passes samples of one vehicle only.
    """

    def __init__(
        self,
        settings: PipelineSettings,
        attitude_filter: AttitudeFilter,
        sources: Sequence[str] = (),
        vehicle: Vehicle | None = None,
    ) -> None:
        self.lanes: Final[dict[str, Lane]] = {}
        self.vehicle: Final = Vehicle(settings.aids) if vehicle is None else vehicle
        """State of the vehicle, shared by all lanes."""
        self.imu_frame: Final = ImuFrame(self.vehicle)
        """Turns the autopilot's attitudes into the frame of the inertial messages."""
        self.estimate: Estimate | None = None
        """Newest valid estimate of the selected lane, else None. Late ones are returned by ``handle`` but not kept."""
        self._settings = settings
        self._filter = attitude_filter
        self._sources = list(sources)
        self.freshness: Final = FreshnessWatch()
        """Whether the samples of the selected lane come in time."""
        self._check = AttitudeCheck(settings.verdict)
        self._trims: Final = TrimWatch(self.vehicle)
        self._witness = Witness() if isinstance(attitude_filter, VelocityAided) else None

    def use(self, settings: PipelineSettings) -> None:
        """Publish and judge by other settings from now on; those of lanes and aids stay."""
        self._settings = settings
        self._check.use(settings.verdict)

    def use_filter(self, attitude_filter: AttitudeFilter) -> None:
        """Go on with other parameters of the same filter, on every lane."""
        self._filter = attitude_filter
        for lane in self.lanes.values():
            lane.use_filter(attitude_filter)

    def takes(self, source: str) -> bool:
        """Whether the stream of this name is one of the lanes."""
        return source in self._sources

    @property
    def publishes(self) -> bool:
        """Whether ``estimate`` may be published: it is certain enough, and nothing contradicts it."""
        estimate = self.estimate
        return estimate is not None and not (self.is_contradicted or estimate.tilt_sigma > self._settings.max_sigma)

    @property
    def doubts_clock(self) -> bool:
        """Whether the clocks of autopilot and host ought to be compared: samples come late, or their clock jumps."""
        lane = self.lanes.get(self.selected)
        return lane is not None and (lane.delay_s > DOUBTED_SHARE * self._settings.stale_s or lane.timebase.is_jumping)

    @property
    def is_contradicted(self) -> bool:
        """Whether a sensor, the receiver or the magnetic field contradicts ``estimate`` at present."""
        return self._witness is not None and not self._witness.publishes

    @property
    def selected(self) -> str:
        """Name of the selected lane's stream, "" before one is known."""
        return self.primary if self._witness is None else self._witness.selected

    def fault_of(self, source: str) -> str:
        """Why the witness has set this lane aside, "" while it has not."""
        return "" if self._witness is None else self._witness.fault_of(source)

    @property
    def primary(self) -> str:
        """Name of the primary lane's stream, "" before one is known."""
        return self._sources[0] if self._sources else ""

    @property
    def learned(self) -> dict[str, SensorCalibration]:
        """The lasting errors of the sensors in good standing, by the name of the lane; none while there is a doubt."""
        if not self.publishes:
            return {}
        known = {name: lane.learned for name, lane in self.lanes.items() if not self.fault_of(name)}
        return {name: one for name, one in known.items() if one is not None}

    def set_field(self, field: EarthField) -> None:
        """From now on this is the field where the vehicle is: with its declination headings refer to true north."""
        self.vehicle.field = field

    def set_vehicle_settings(self, known: VehicleSettings) -> None:
        """From now on these are the vehicle's settings; for all others the filter keeps its defaults."""
        self.vehicle.settings = known
        for lane in self.lanes.values():
            lane.use_vehicle_settings()

    def handle(self, sample: Sample) -> list[Event]:
        """Take one sample, in order of arrival; the events that follow from it, in order."""
        if isinstance(sample, ImuSample):
            return self._handle_imu(sample)
        if isinstance(sample, AttitudeSample):
            self.vehicle.self_report.take(sample)
            if sample.role != AttitudeRole.AUTOPILOT:
                return []
            in_imu_frame = self.imu_frame.attitude(sample)
            if in_imu_frame is None:
                return [*self._check.refuse(sample)]
            return [*self.compare(in_imu_frame)]
        before = self.vehicle.settings
        self.vehicle.take(sample)
        if isinstance(sample, ParameterSample):
            agrees = self.verdict is not None and self.verdict.agreement == Agreement.AGREE
            self._check.judge.trim_moved = self._trims.take(sample, before, agrees)
            self.set_vehicle_settings(self.vehicle.settings)
        elif self.vehicle.armed is False:
            self._trims.forget()
            self._check.judge.trim_moved = False
        return []

    def compare(self, sample: AttitudeSample) -> tuple[Verdict, ...]:
        """Judge an attitude of the autopilot that stands in the frame of the inertial messages."""
        return self._check.take(sample)

    def suspended(self, reason: str, now_ns: int) -> Verdict:
        """The verdict that there is none at present, for a reason that the samples do not tell."""
        return self._check.undecided(reason, now_ns)

    def poll(self, now_ns: int) -> list[Event]:
        """Events due because no sample has come until ``now_ns`` (host clock)."""
        estimate = self.estimate
        if estimate is None or now_ns < estimate.rx_ns + self._stale_ns():
            return [*self._check.poll(now_ns)]
        self.estimate = None
        self._check.judge.forget_estimate()
        stopped = self.freshness.stopped(estimate, now_ns, self._stale_ns())
        return [stopped, self._check.undecided("no-estimate", now_ns)]

    @property
    def autopilot_attitude(self) -> AttitudeSample | None:
        """The newest attitude of the autopilot that was compared, in the frame of the inertial sensor."""
        return self._check.attitude

    @property
    def verdict(self) -> Verdict | None:
        """The newest verdict."""
        return self._check.verdict

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` has something to say if nothing comes, on the host clock; None while nothing is pending."""
        reference_ns = self._check.deadline_ns
        if self.estimate is None:
            return reference_ns
        estimate_ns = self.estimate.rx_ns + self._stale_ns()
        return estimate_ns if reference_ns is None else min(estimate_ns, reference_ns)

    def _handle_imu(self, sample: ImuSample) -> list[Event]:
        """Run the sample's lane; keep and check the estimate of the selected lane."""
        source = sample.source
        if not self._sources:
            self._sources.append(source)
        if source not in self._sources:
            return []
        lane = self.lanes.get(source)
        if lane is None:
            stepper = None if self._witness is None else self._witness.watch(source)
            lane = Lane(source, self._filter, self.vehicle, stepper, self._settings.arrivals)
            self.lanes[source] = lane
        taken, restarts = lane.samples, lane.restarts
        events = lane.handle(sample)
        if lane.restarts > restarts:
            self._forget_if_rebooted(events)
        if lane.samples > taken:
            before = self.selected
            if self._witness is not None:
                self._witness.advance(source, events)
            if self.selected != before and self.estimate is not None:
                self.lanes[self.selected].continue_sign(self.estimate.q_nb)
            if source == self.selected:
                events.extend(self._follow_selected(events))
                late = self.freshness.take(sample, lane.delay_s, 1e-9 * self._stale_ns())
                if late is not None:
                    events.append(late)
        return events

    def _forget_if_rebooted(self, events: list[Event]) -> None:
        """Forget the trims of an autopilot that has booted since."""
        for event in events:
            if isinstance(event, LaneEvent) and event.kind == LaneEventKind.REBOOTED:
                self.vehicle.forget_trims()

    def _follow_selected(self, events: list[Event]) -> tuple[Verdict, ...]:
        """Take over the selected lane's new estimate; there is none while its filter aligns."""
        for event in events:
            if isinstance(event, Estimate):
                if 1e9 * event.delay_s > self._stale_ns():
                    return ()
                self.estimate = event
                witness = self._witness
                if witness is None:
                    return self._check.take_estimate(event)
                readings = witness.compasses.newest
                return self._check.take_estimate(event, witness.members, doubts=witness.doubts, readings=readings)
        self.estimate = None
        self._check.judge.forget_estimate()
        return ()

    def _stale_ns(self) -> int:
        """Without a sample for this long there is no estimate, ns: a slow stream has its own intervals."""
        lane = self.lanes.get(self.selected)
        usual_s = 0.0 if lane is None else lane.timebase.usual_s
        return int(_NS * max(self._settings.stale_s, STALE_INTERVALS * usual_s))
