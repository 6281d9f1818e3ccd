"""The attitude of one vehicle: its samples in; estimates, verdicts and lines for the log out, by the companion.

There is one object a vehicle. Another vehicle, or another component of it, gets a new one, since nothing that was
learned of the last one holds for it.
"""

from collections.abc import Callable
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.estimation.events import Event, LaneEvent, LaneEventKind, Verdict
from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.innovation import Aid
from attest_mav.mavlink.component.companion import Companion
from attest_mav.mavlink.constants import MAV_STATE_ACTIVE, MAV_STATE_BOOT, MAV_STATE_CALIBRATING, MAV_STATE_CRITICAL
from attest_mav.samples import ImuSample, Sample
from attest_mav.service.announcements import Announcements
from attest_mav.service.publisher import Publisher
from attest_mav.service.sender_clock import SenderClock
from attest_mav.service.settings import ServiceSettings
from attest_mav.service.vehicle_records import AidSnapshot
from attest_mav.service.verdict_teller import VerdictTeller
from attest_mav.types import EarthField
from attest_mav.vehicle_settings import VehicleSettings

FindCalibrations = Callable[[], dict[str, SensorCalibration]]

TWO_SENDERS: Final = "two vehicles with one id"
"""Why the attitude is withheld while another sender uses the vehicle's ids."""


class VehicleAttitude:
    """Runs the pipeline of one vehicle, and passes on what follows.

    facts, field: the settings of the vehicle and the field of the Earth at its place, as far as they are known.
    find_calibrations: gives the errors of its sensors by the flights so far, by inertial message.
    """

    def __init__(
        self,
        companion: Companion,
        announcements: Announcements,
        settings: ServiceSettings,
        facts: VehicleSettings,
        field: EarthField,
        find_calibrations: FindCalibrations,
    ) -> None:
        self.vehicle: Final = Vehicle(settings.pipeline.aids)
        self.vehicle.settings, self.vehicle.field = facts, field
        self.vehicle.calibrations = find_calibrations()
        self.pipeline: Pipeline | None = None
        """None before the first inertial sample that is used."""
        self.publisher: Final = Publisher(companion, announcements, settings.pipeline.max_sigma)
        self.verdicts: Final = VerdictTeller(companion, announcements, self.vehicle)
        self.aids: Final[dict[Aid, AidSnapshot]] = {}
        """The newest measurement of each aid beside the published estimates."""
        self._find_calibrations: Final = find_calibrations
        self._companion: Final = companion
        self._settings = settings.pipeline
        self._filter = settings.attitude_filter
        self._clock: Final = SenderClock()
        self._two_senders = False
        self._stale_ns: Final = int(settings.pipeline.stale_s * 1e9)
        self._sample_ns = -1

    @property
    def estimate(self) -> Estimate | None:
        """The newest valid estimate, else None."""
        return None if self.pipeline is None else self.pipeline.estimate

    def is_fresh(self, now_ns: int) -> bool:
        """Whether there is an estimate younger than the configured limit."""
        estimate = self.estimate
        return estimate is not None and now_ns - estimate.rx_ns < self._stale_ns

    def state(self, now_ns: int) -> int:
        """MAV_STATE; while the attitude is withheld the filter is still calibrating."""
        if self.is_fresh(now_ns):
            if self.verdicts.disagrees:
                return MAV_STATE_CRITICAL
            return MAV_STATE_ACTIVE if self.publisher.is_open else MAV_STATE_CALIBRATING
        return MAV_STATE_CALIBRATING if self.brings_samples(now_ns) else MAV_STATE_BOOT

    def brings_samples(self, now_ns: int) -> bool:
        """Whether inertial samples that are used have come of late."""
        return self._sample_ns >= 0 and now_ns - self._sample_ns < self._stale_ns

    def believes(self, sample: Sample) -> bool:
        """Whether a sample that is not inertial comes from the vehicle, and not from another sender with its ids."""
        pipeline = self.pipeline
        lane = None if pipeline is None else pipeline.lanes.get(pipeline.selected)
        return not self._two_senders and (lane is None or self._clock.is_of(lane, sample))

    def begin_on(self, source: str, note: str) -> None:
        """Run the filter on this primary inertial message unless it is served; the record of the vehicle goes on."""
        pipeline = self.pipeline
        if pipeline is not None and (pipeline.takes(source) or pipeline.estimate is not None):
            return
        lanes = [source, *self._companion.data.further_imu]
        self.pipeline = Pipeline(self._settings, self._filter, lanes, self.vehicle)
        self.aids.clear()
        remark = f" ({note})" if note else ""
        self._companion.notebook.info(f"using {source} with the filter {self._filter.name}{remark}")

    def take(self, sample: Sample, now_ns: int) -> bool:
        """Take a sample that is believed; whether something is due that follows from it."""
        pipeline = self.pipeline
        if isinstance(sample, ImuSample) and sample.source == self._companion.data.primary_imu:
            self._sample_ns = now_ns
            self._watch_senders(now_ns)
        if pipeline is None:
            self.vehicle.take(sample)
            return False
        return self._act(pipeline.handle(sample), now_ns)

    def poll(self, now_ns: int) -> bool:
        """Do what is due because no sample has come; whether something follows from it."""
        self._watch_senders(now_ns)
        return self.pipeline is not None and self._act(self.pipeline.poll(now_ns), now_ns)

    def use(self, settings: PipelineSettings) -> None:
        """Publish and judge by other settings from now on."""
        self._settings = settings
        self.publisher.limit(settings.max_sigma)
        if self.pipeline is not None:
            self.pipeline.use(settings)

    def use_filter(self, attitude_filter: AttitudeFilter) -> None:
        """Go on with other parameters of the same filter."""
        self._filter = attitude_filter
        if self.pipeline is not None:
            self.pipeline.use_filter(attitude_filter)

    def _watch_senders(self, now_ns: int) -> None:
        """Withhold the attitude and the verdict as soon as two senders are there, until one is alone again."""
        pipeline, two_senders = self.pipeline, self._companion.traffic.identity.are_two_clocks(now_ns)
        if pipeline is None or two_senders == self._two_senders:
            return
        self._two_senders = two_senders
        if two_senders:
            self.vehicle.forget_motion()
            self.publisher.withdraw(TWO_SENDERS, now_ns)
            self.verdicts.take(pipeline.suspended("two-senders", now_ns))

    def _act(self, events: list[Event], now_ns: int) -> bool:
        """Publish estimates, pass verdicts on, and tell the events of the lanes; whether something is due."""
        is_due = False
        for event in events:
            if isinstance(event, Estimate):
                for one in event.innovations:
                    self.aids[one.aid] = AidSnapshot(one, event.rx_ns)
                if event is self.estimate and not self._two_senders:  # one that came too late to hold is not sent
                    contradicted = self.pipeline is not None and self.pipeline.is_contradicted
                    self.publisher.publish(event, contradicted, now_ns)
            elif isinstance(event, Verdict):
                if not self._two_senders:
                    is_due = True
                    self.verdicts.take(event)
            elif isinstance(event, LaneEvent):
                is_due = True
                self.verdicts.lane_event(event)
                if event.kind == LaneEventKind.REBOOTED:
                    self._companion.ask_again(now_ns)
                    self._begin_with_what_was_learned()
        if events and self.estimate is None:
            self.publisher.withdraw(self._lack(events, now_ns), now_ns)
        return is_due

    def _begin_with_what_was_learned(self) -> None:
        """The filters, which begin again, take the errors of the sensors as the flights so far have shown them."""
        self.vehicle.calibrations = self._find_calibrations()
        if self.pipeline is not None:
            self.pipeline.use_filter(self._filter)

    def _lack(self, events: list[Event], now_ns: int) -> str:
        """Why there is no estimate after these events."""
        if self._two_senders:
            return TWO_SENDERS
        is_silent = any(isinstance(event, LaneEvent) and event.kind == LaneEventKind.STOPPED for event in events)
        if is_silent or not self.brings_samples(now_ns):
            return "samples stopped"
        late_by_s = 0.0 if self.pipeline is None else self.pipeline.freshness.late_by_s
        return f"samples come {late_by_s:.1f} s late" if late_by_s > 0.0 else "aligning"
