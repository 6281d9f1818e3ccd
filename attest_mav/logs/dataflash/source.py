"""A DataFlash log as a source of samples: the survey is the first pass, the readers of the plan run in the second."""

from collections.abc import Iterator
from typing import Final, Protocol

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.damage import Damage
from attest_mav.logs.dataflash.readers import FlightReaders
from attest_mav.logs.dataflash.roles import DATAFLASH_ROLES
from attest_mav.logs.dataflash.routes import Router
from attest_mav.logs.dataflash.streams import SENSORS
from attest_mav.logs.dataflash.survey import Survey
from attest_mav.logs.dataflash.text_walker import TextWalker
from attest_mav.logs.dataflash.walker import RecordWalker
from attest_mav.logs.facts import velocity_lack
from attest_mav.logs.source import EXPECTED, LogBytes, LogSummary, Plan, Progress, SampleBatch, VehicleSummary
from attest_mav.logs.windows import read_windows
from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware
from attest_mav.mavlink.decode.units import DATAFLASH_IMU, MagnitudeCheck
from attest_mav.samples import Sample

BATCH: Final = 256
"""Samples handed over at a time: many against the cost of a batch, few enough to stay in the cache."""
VEHICLE: Final = (1, 1)


class Walker(Protocol):
    """Finds the records of a log, window by window."""

    @property
    def position(self) -> int:
        """Where the next window has to begin."""

    @property
    def records(self) -> int:
        """Intact records so far."""

    @property
    def damage(self) -> Damage:
        """Bytes that belong to none."""

    def walk(self, window: bytes, final: bool) -> list[Sample]:
        """The samples of the next window."""


class DataflashSource:
    """The ``LogSource`` of a binary DataFlash log."""

    def __init__(self, data: LogBytes, log_format: str = "dataflash") -> None:
        self._data: Final = data
        self._log_format: Final = log_format
        self._survey = Survey()
        self._damage = Damage()
        self._intact_to = 0
        self._readers: FlightReaders | None = None
        self._counts: dict[str, int] = {}

    def _walker(self, router: Router, intact_to: int = 0) -> Walker:
        """A walker over this log. intact_to: up to this byte the first pass has found no damage."""
        return RecordWalker(router, intact_to)

    def summary(self, progress: Progress | None = None) -> LogSummary:
        """First pass. UnreadableDataError if the log has no record."""
        survey = Survey()
        walker = self._walker(survey.router)
        for _ in survey.take(read_windows(self._data, walker)):
            if progress is not None:
                progress(walker.position / len(self._data))
        if not walker.records:
            raise UnreadableDataError(f"this DataFlash log has no record; expected {EXPECTED}")
        self._survey, self._damage, self._counts = survey, walker.damage, survey.router.counts()
        self._intact_to = walker.damage.intact_to(len(self._data))
        return LogSummary(
            log_format=self._log_format,
            roles=DATAFLASH_ROLES,
            messages=walker.records,
            bad_bytes=walker.damage.total,
            duration_s=survey.duration_s,
            vehicles={VEHICLE: self._vehicle()},
        )

    def _vehicle(self) -> VehicleSummary:
        survey, facts, counts = self._survey, self._survey.facts, self._counts
        return VehicleSummary(
            vehicle=VEHICLE,
            is_autopilot=True,
            counts=counts,
            inertial=DATAFLASH_ROLES.inertial,
            in_simulator=any(name in counts for name in DATAFLASH_ROLES.truth),
            position=facts.position,
            velocity_lack="" if facts.velocities else velocity_lack(counts, SENSORS["GPS"]),
            settings=facts.settings(facts_of_firmware(MAV_AUTOPILOT_ARDUPILOTMEGA, survey.vehicle_type)),
            parameters=facts.parameters,
            opening=facts.opening(survey.begin().heartbeat("MSG", 0)),
            date=facts.date,
        )

    def samples(self, plan: Plan) -> Iterator[SampleBatch]:
        """Second pass, some samples at a time."""
        readers = FlightReaders(plan, self._survey, self._counts)
        self._readers = readers
        length = len(self._data)
        router = Router(readers.readers, self._survey.units, self._survey.pace_ns, counts_all=False)
        walker = self._walker(router, self._intact_to)
        for samples in read_windows(self._data, walker):
            share = walker.position / length
            for start in range(0, len(samples), BATCH):
                some = samples[start : start + BATCH]
                yield SampleBatch(some, [], share)

    def notes(self, plan: Plan) -> list[str]:
        """Remarks on the sensor, and on the damage."""
        notes = [f"{plan.imu}: {DATAFLASH_IMU.note}"]
        return [*notes, self._damage.note()] if self._damage.total else notes

    def refusals(self, plan: Plan) -> list[str]:
        """Reasons of the sensor's checks, or too few records for them."""
        count = self._counts.get(plan.imu, 0)
        if count < MagnitudeCheck.WINDOW:
            return [f"{count} {plan.imu}, fewer than the {MagnitudeCheck.WINDOW} that are needed to know its units"]
        if self._survey.duration_s == 0.0:
            return ["the times of its records stand still: no filter can go by them"]
        if self._readers is None:
            return []
        sensor = self._readers.sensors[plan.imu]
        return [reason for reason in (sensor.refusal, sensor.field_refusal) if reason]


class TextSource(DataflashSource):
    """The source of a DataFlash log in text."""

    def __init__(self, data: LogBytes) -> None:
        super().__init__(data, "dataflash-text")

    def _walker(self, router: Router, intact_to: int = 0) -> Walker:
        """A walker over this log, whose lines need no look inside."""
        return TextWalker(router)
