"""A ULog as a source of samples: a survey is the first pass, the readers of the plan run in the second."""

from collections.abc import Iterator, Mapping
from typing import Final

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.facts import FlightFacts, velocity_lack
from attest_mav.logs.source import EXPECTED, LogBytes, LogSummary, Plan, Progress, SampleBatch, VehicleSummary
from attest_mav.logs.ulog.flight_readers import (
    AirspeedReader,
    AttitudeReader,
    EstimatorReader,
    LandedReader,
    ReceiverReader,
    StatusReader,
)
from attest_mav.logs.ulog.reader import COMPONENT, SYSTEM, TopicReader
from attest_mav.logs.ulog.roles import OWN, RECEIVERS, ULOG_ROLES
from attest_mav.logs.ulog.sensor_readers import CombinedReader, Field, ImuReader, MagReader
from attest_mav.logs.ulog.topics import Topics
from attest_mav.logs.ulog.walker import UlogWalker
from attest_mav.logs.windows import read_windows
from attest_mav.mavlink.constants import MAV_AUTOPILOT_PX4, MAV_STATE_ACTIVE, MAV_TYPE_GENERIC
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware
from attest_mav.mavlink.decode.sensor_reader import SensorReader
from attest_mav.mavlink.decode.units import ULOG_IMU, MagnitudeCheck
from attest_mav.types import AttitudeRole
from attest_mav.vehicle_reports import HeartbeatSample
from attest_mav.vehicle_settings import Setting

BATCH: Final = 256
"""Samples handed over at a time: many against the cost of a batch, few enough to stay in the cache."""
VEHICLE: Final = (SYSTEM, COMPONENT)
UNKNOWN: Final = HeartbeatSample(
    "vehicle_status", SYSTEM, COMPONENT, 0, MAV_TYPE_GENERIC, MAV_AUTOPILOT_PX4, True, MAV_STATE_ACTIVE
)
"""The vehicle where the log does not tell it: armed, which allows any motion."""


class UlogSource:
    """The ``LogSource`` of a ULog."""

    def __init__(self, data: LogBytes) -> None:
        self._data: Final = data
        self._facts = FlightFacts()
        self._counts: dict[str, int] = {}
        self._notes: list[str] = []
        self._duration_s = 0.0
        self._intact_to = 0
        self._sensor: SensorReader | None = None

    def summary(self, progress: Progress | None = None) -> LogSummary:
        """First pass. UnreadableDataError if the log has no message."""
        facts, topics = FlightFacts(), Topics(survey_readers())
        walker = UlogWalker(topics)
        for samples in read_windows(self._data, walker):
            for sample in samples:
                facts.take(sample)
            if progress is not None:
                progress(walker.position / len(self._data))
        if not walker.records:
            raise UnreadableDataError(f"this ULog has no message; expected {EXPECTED}")
        self._facts, self._counts, self._notes = facts, topics.counts(), damage_notes(walker)
        self._duration_s = topics.span_ns * 1e-9
        self._intact_to = walker.damage.intact_to(len(self._data))
        return LogSummary(
            log_format="ulog",
            roles=ULOG_ROLES,
            messages=walker.records,
            bad_bytes=walker.damage.total,
            duration_s=self._duration_s,
            vehicles={VEHICLE: self._vehicle()},
        )

    def _vehicle(self) -> VehicleSummary:
        facts = self._facts
        heartbeat = facts.heartbeat or UNKNOWN
        assumed = facts_of_firmware(MAV_AUTOPILOT_PX4, heartbeat.vehicle_type)
        return VehicleSummary(
            vehicle=VEHICLE,
            is_autopilot=True,
            counts=self._counts,
            inertial=ULOG_ROLES.inertial,
            in_simulator=False,
            position=facts.position,
            velocity_lack="" if facts.velocities else velocity_lack(self._counts, RECEIVERS),
            settings=facts.settings(assumed.updated(Setting.FIELD_DELAY_S, ULOG_IMU.field_delay_s)),
            parameters=facts.parameters,
            opening=facts.opening(heartbeat),
            date=facts.date,
        )

    def samples(self, plan: Plan) -> Iterator[SampleBatch]:
        """Second pass, some samples at a time."""
        names = (plan.imu, *plan.other_sensors)
        sensors = {name: SensorReader(name, SYSTEM, COMPONENT, ULOG_IMU) for name in names}
        self._sensor = sensors[plan.imu]
        with_velocity = [name for name in RECEIVERS if name in self._facts.velocities]
        receiver = with_velocity[0] if with_velocity else RECEIVERS[0]
        walker = UlogWalker(Topics(flight_readers(plan, sensors, receiver)), self._intact_to)
        length = len(self._data)
        for samples in read_windows(self._data, walker):
            share = walker.position / length
            for start in range(0, len(samples), BATCH):
                some = samples[start : start + BATCH]
                yield SampleBatch(some, [], share)

    def notes(self, plan: Plan) -> list[str]:
        """Remarks on the sensor, on damage and on what the recorder has lost."""
        return [f"{plan.imu}: {ULOG_IMU.note}", *self._notes]

    def refusals(self, plan: Plan) -> list[str]:
        """Reasons of the sensor's checks, or too few messages for them."""
        count = self._counts.get(plan.imu, 0)
        if count < MagnitudeCheck.WINDOW:
            return [f"{count} {plan.imu}, fewer than the {MagnitudeCheck.WINDOW} that are needed to know its units"]
        if self._duration_s == 0.0:
            return ["the times of its messages stand still: no filter can go by them"]
        sensor = self._sensor
        return [] if sensor is None else [reason for reason in (sensor.refusal, sensor.field_refusal) if reason]


def vehicle_readers() -> dict[str, TopicReader]:
    """The readers of the vehicle's state."""
    return {"vehicle_status": StatusReader(), "vehicle_land_detected": LandedReader()}


def survey_readers() -> dict[str, TopicReader]:
    """The readers of the first pass; of inertial topics and attitude the time alone."""
    timed = {name: TopicReader() for name in (*ULOG_ROLES.inertial, OWN)}
    return {**timed, **vehicle_readers(), **{name: ReceiverReader(name) for name in RECEIVERS}}


def flight_readers(plan: Plan, sensors: Mapping[str, SensorReader], receiver: str) -> dict[str, TopicReader]:
    """The readers of the second pass: those of the plan, and of all that aids a filter."""
    field = Field()
    readers: dict[str, TopicReader] = {**vehicle_readers(), "vehicle_magnetometer": MagReader(field)}
    readers[receiver] = ReceiverReader(receiver)
    readers["airspeed"] = AirspeedReader()
    readers["estimator_status"] = EstimatorReader()
    for name, sensor in sensors.items():
        is_combined = name == "sensor_combined"
        readers[name] = CombinedReader(sensor, field) if is_combined else ImuReader(sensor, field)
    for name in plan.messages.difference(sensors):
        own = AttitudeRole.AUTOPILOT if name == OWN else AttitudeRole.SECONDARY
        readers[name] = AttitudeReader(name, AttitudeRole.TRUTH if name in ULOG_ROLES.truth else own)
    return readers


def damage_notes(walker: UlogWalker) -> list[str]:
    """Remarks on damage and dropouts."""
    notes = [] if not walker.damage.total else [walker.damage.note()]
    if walker.dropouts:
        notes.append(f"the recorder could not keep up {walker.dropouts} times, for {walker.dropout_ms} ms in all")
    return notes
