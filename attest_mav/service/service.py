"""The daemon's work without I/O: bytes of links in, frames for links out, notes for the log, time as an argument.

Framers, companion, decoder and pipeline are put together here. A host moves the bytes, calls ``poll`` when ``due_ns``
has come, and logs the notes: ``attest_mav.runtime.daemon`` with real links and the real clock, tests with a simulated
vehicle and a counter. Everything that anyone may see of the service is in ``snapshot``.
"""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Final

from attest_mav.estimate import Estimate
from attest_mav.estimation.pipeline import Pipeline
from attest_mav.mavlink.component.companion import Companion
from attest_mav.mavlink.component.notes import Note
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.dialect import Dialect
from attest_mav.samples import ImuSample, PositionSample, Sample
from attest_mav.service.announcements import Announcements
from attest_mav.service.calibration_store import CalibrationStore
from attest_mav.service.field_lookup import FieldFinder, FieldLookup
from attest_mav.service.kept_state import Persistence
from attest_mav.service.link_records import Traffic
from attest_mav.service.observation import (
    autopilot_attitude,
    clock_snapshot,
    lane_snapshots,
    refusals,
    stream_snapshots,
    tilt_threshold,
    vehicle_snapshot,
)
from attest_mav.service.reception import Reception
from attest_mav.service.settings import ServiceSettings
from attest_mav.service.snapshot import NoteCounts, RecordingSnapshot, Snapshot
from attest_mav.service.source_notes import SourceNotes
from attest_mav.service.tuning import Tuning
from attest_mav.service.vehicle_attitude import VehicleAttitude
from attest_mav.types import EarthField
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import VehicleSettings

if TYPE_CHECKING:
    from attest_mav.service.tape import Tape

REFUSALS_NS: Final = 1_000_000_000
"""Period at which the decoder's refusals and the frames of attitudes are looked through, ns."""


class Service:
    """One vehicle's attitude, from the bytes of its links to the frames that are sent on them."""

    def __init__(
        self,
        settings: ServiceSettings,
        links: Sequence[str],
        dialect: Dialect,
        find_field: FieldFinder,
        now_ns: int,
        tape: "Tape | None" = None,
    ) -> None:
        """links: the names of the links, one for each of ``settings.ports``. tape: keeps the vehicle's messages."""
        self._tape: Final = tape
        self.due_ns = now_ns
        """When ``poll`` is due; a time in the past is at once."""
        self._dialect: Final = dialect
        ports = list(zip(links, settings.ports, strict=True))
        self._companion: Final = Companion(dialect, settings.companion, ports, now_ns)
        self._notebook: Final = self._companion.notebook
        self._tuning: Final = Tuning(self._companion, settings)
        self._reception: Final = Reception(dialect, self._companion, settings)
        self._calibrations: Final = CalibrationStore(settings.learns)
        self.persistence: Final = Persistence(self._reception.clock, self._companion.own_parameters, self._calibrations)
        """The state that survives a restart; restored before the first bytes come."""
        self._decoder = Decoder(dialect, settings.raw_scales)
        self._field_lookup: Final = FieldLookup(find_field, settings.declination, self._notebook)
        self._announcements: Final = Announcements(self._companion)
        self._sender = self._companion.sender
        self._attitude = self._new_attitude(VehicleSettings(), EarthField(settings.declination))
        self._samples = 0
        self._source_notes: Final = SourceNotes(self._notebook)
        self._next_refusals_ns = now_ns + REFUSALS_NS

    @property
    def estimate(self) -> Estimate | None:
        """The newest valid estimate, else None."""
        return self._attitude.estimate

    @property
    def is_armed(self) -> bool | None:
        """Whether the vehicle is armed, None while that is not known."""
        return self._attitude.vehicle.armed

    def fresh(self, now_ns: int) -> bool:
        """Whether there is an estimate younger than the configured limit."""
        return self._attitude.is_fresh(now_ns)

    def receive(self, link: int, data: bytes, now_ns: int, stream: int = 0) -> bool:
        """Take bytes that arrived on a link, in one of its streams; whether they completed an intact frame."""
        companion = self._companion
        frames, is_intact = self._reception.feed(link, data, now_ns, stream)
        for frame in frames:
            is_data = companion.handle(link, frame, now_ns)
            if companion.sender != self._sender:
                self._begin_anew()
            if is_data:
                if self._tape is not None:
                    self._tape.hear(frame)
                for sample in self._decoder.decode(frame):
                    self._take(sample, now_ns)
            else:
                self._retune()
                for exchange in companion.timesync.take():
                    self._attitude.vehicle.clock.take(exchange)
                self.due_ns = now_ns  # a heartbeat, an answer, a command: something may follow from it
        return is_intact

    def link_restarted(self, link: int) -> None:
        """A link was opened again: a frame that was received in part is dropped."""
        self._reception.restarted(link)
        self._companion.link_broken(link)
        self.due_ns = 0

    def poll(self, now_ns: int) -> None:
        """Do everything that is due."""
        self._reception.clock.advance(now_ns)
        self._retune()
        self._attitude.poll(now_ns)
        if now_ns >= self._next_refusals_ns:
            self._next_refusals_ns = now_ns + REFUSALS_NS
            self._source_notes.refusals(self._decoder, self._companion.data.imu, now_ns)
            self._source_notes.frames(self._frame_notes)
            self._attitude.verdicts.settle(now_ns)
            self._reception.measure_loss(now_ns)
            self._learn()
        self._companion.state = self._attitude.state(now_ns)
        self._companion.poll(now_ns)
        self.due_ns = min(self._companion.next_deadline_ns, self._next_refusals_ns)
        pipeline_ns = None if self._pipeline is None else self._pipeline.next_deadline_ns
        if pipeline_ns is not None:
            self.due_ns = min(self.due_ns, pipeline_ns)

    def take_frames(self, link: int) -> list[bytes]:
        """The frames to be written to a link; each is handed out once."""
        return self._companion.ports[link].take()

    def take_notes(self) -> list[Note]:
        """The lines for the log since the last call, oldest first."""
        return self._notebook.take()

    def stop(self) -> None:
        """Leave the last frames to ``take_frames``: rates set back, and a heartbeat that says goodbye."""
        self._attitude.verdicts.end()
        self._companion.stop()

    def snapshot(
        self, now_ns: int, traffic: Sequence[Traffic] = (), recording: RecordingSnapshot | None = None
    ) -> Snapshot:
        """Everything that may be seen of the service.

        traffic: the host's counters, one record a link. recording: the host's, of the tape.
        """
        companion, decoder, attitude = self._companion, self._decoder, self._attitude
        inertial = companion.data.imu
        return Snapshot(
            now_ns=now_ns,
            state=companion.state,
            vehicle=vehicle_snapshot(companion.discovery, attitude.vehicle),
            ambiguity=companion.discovery.ambiguity,
            links=self._reception.snapshots(traffic, now_ns),
            streams=stream_snapshots(companion.data.stream_manager, companion.discovery.present, now_ns),
            inertial="" if inertial is None else inertial.name,
            single_imu=companion.data.single_imu,
            not_independent=frozenset(name for name, independent in decoder.independent.items() if not independent),
            refusals=refusals(decoder),
            samples=self._samples,
            clock=clock_snapshot(attitude.vehicle.clock, companion.timesync.answers),
            late_by_s=0.0 if self._pipeline is None else self._pipeline.freshness.late_by_s,
            lanes=lane_snapshots(self._pipeline),
            aids=tuple(attitude.aids.values()),
            verdict=attitude.verdicts.standing,
            spans=attitude.verdicts.spans,
            tilt_threshold=tilt_threshold(self._pipeline, self._tuning.pipeline.verdict),
            autopilot=autopilot_attitude(self._pipeline),
            withheld="" if self.estimate is None else attitude.publisher.reason,
            self_report=attitude.vehicle.self_report.remarks(now_ns),
            frame_notes=tuple(self._frame_notes),
            link_remarks=tuple(companion.remarks(now_ns)),
            own_parameters=tuple(companion.own_parameters.changes.items()),
            notes=NoteCounts(self._notebook.warnings, self._notebook.errors, self._notebook.dropped),
            recording=recording,
        )

    def use(self, settings: ServiceSettings) -> None:
        """Publish, filter and judge by other settings from now on: those of the same filter on the same links.

        A parameter of ours that a station has set stays as it was set.
        """
        self._tuning.use(settings)
        self._attitude.use(self._tuning.pipeline)
        self._attitude.use_filter(settings.attitude_filter)
        self.due_ns = 0

    def _take(self, sample: Sample, now_ns: int) -> None:
        companion, attitude = self._companion, self._attitude
        if isinstance(sample, ImuSample):
            if not companion.imu_taken(sample.source, sample.t_ns, now_ns):
                return
            if sample.source == companion.data.primary_imu:
                self._samples += 1
                attitude.begin_on(sample.source, self._decoder.notes.get(sample.source, ""))
        elif not attitude.believes(sample):
            return
        elif isinstance(sample, PositionSample):
            attitude.vehicle.field = self._field_lookup.at(sample) or attitude.vehicle.field
        elif isinstance(sample, ParameterSample) and not companion.parameter_taken(sample):
            self.due_ns = now_ns  # it is asked again
            return
        if attitude.take(sample, now_ns):
            self.due_ns = now_ns
        if attitude.pipeline is not None and attitude.pipeline.doubts_clock:
            companion.timesync.hurry()
            self.due_ns = min(self.due_ns, companion.next_deadline_ns)

    def _begin_anew(self) -> None:
        """Another vehicle, another component of it, or none: nothing learned from the last one holds for this one."""
        self._sender = self._companion.sender
        self._decoder = Decoder(self._dialect, self._tuning.settings.raw_scales)
        field = self._attitude.vehicle.field  # the place is the same until a position says otherwise
        self._attitude.verdicts.end()
        heard = self._companion.discovery.vehicle
        facts = facts_of_firmware(self._sender[2], -1 if heard is None else heard.vehicle_type)
        self._attitude = self._new_attitude(facts, field)

    def _new_attitude(self, facts: VehicleSettings, field: EarthField) -> VehicleAttitude:
        """The work on another vehicle, of which these settings and this field of the Earth are known."""
        known = partial(self._calibrations.of_vehicle, self._sender[0])
        return VehicleAttitude(self._companion, self._announcements, self._tuning.settings, facts, field, known)

    def _retune(self) -> None:
        """Put our own parameters in force, where they have changed."""
        if self._tuning.take_change():
            self._attitude.use(self._tuning.pipeline)

    def _learn(self) -> None:
        """Keep what the flight has shown of the sensors' errors, and forget what it has refuted."""
        vehicle = self._attitude.vehicle
        self._calibrations.drop(self._sender[0], vehicle.refuted)
        vehicle.refuted.clear()
        if self._pipeline is not None:
            self._calibrations.take(self._sender[0], self._pipeline.learned)

    @property
    def _pipeline(self) -> Pipeline | None:
        return self._attitude.pipeline

    @property
    def _frame_notes(self) -> list[str]:
        return [] if self._pipeline is None else self._pipeline.imu_frame.notes
