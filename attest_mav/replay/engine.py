"""Runs filters over a recorded flight and compares them, and the autopilot's own attitude, with a reference.

The log is read twice: a survey counts what is there, and with the plan made of it the second pass decodes only what is
needed. Every filter gets a pipeline of its own, so that filters run together give what they give apart, bit for bit.
Nothing grows with the log but the columns of errors and of intervals.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, nan
from mmap import mmap
from typing import Final

from attest_mav.earth_field import LocalField, field_at, simulated_field_at
from attest_mav.errors import UnreadableDataError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.logs.detect import EXPECTED
from attest_mav.logs.tlog.annotate import ByteSink, Weaver
from attest_mav.logs.tlog.reader import TlogReader, read_windows
from attest_mav.logs.tlog.survey import Survey
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.decode.decoder import Decoder, of_message
from attest_mav.mavlink.dialect import Dialect
from attest_mav.replay.comparison import RowSink
from attest_mav.replay.facts import fact_notes, facts_of
from attest_mav.replay.flight import Flight, Window
from attest_mav.replay.plan import Plan, in_simulator, make_plan, suitable_filter
from attest_mav.types import EarthField, PositionSample, Sample, VehicleSettings

OUR_COMPONENT: Final = 193
"""The component id of woven messages, the daemon's default."""
AID_MESSAGES: Final = ("HEARTBEAT", "VFR_HUD", "GPS_RAW_INT", "SYSTEM_TIME")
"""What every lane is told besides the inertial samples, whatever its filter makes of it: a filter's result must not
depend on which others run beside it."""

SURVEY_SHARE: Final = 0.2
"""About the first pass's share of the time, for the progress."""


@dataclass(frozen=True)
class Request:
    """What to do with each log.

    filters: empty to take the one that suits the log. imu, reference: message names, None to choose. declination_deg:
    None to look it up.
    """

    filters: tuple[AttitudeFilter, ...] = ()
    imu: str | None = None
    reference: str | None = None
    declination_deg: float | None = None
    window: Window = field(default_factory=Window)


@dataclass(frozen=True)
class Outputs:
    """Where things go besides the result.

    rows: every attitude with its errors. woven: the log with the first filter's attitudes. progress: is told the
    share of the work done, 0 to 1, every few hundred kilobytes.
    """

    rows: RowSink | None = None
    woven: ByteSink | None = None
    progress: Callable[[float], None] | None = None


@dataclass(frozen=True)
class Replay:
    """What came of one log.

    earth_field: None when headings stayed magnetic. notes: what a reader of the figures should know, a line each.
    """

    survey: Survey
    plan: Plan
    earth_field: LocalField | None
    flight: Flight
    notes: tuple[str, ...]


def replay(buffer: mmap | bytes, dialect: Dialect, request: Request, outputs: Outputs) -> Replay:
    """Replay a tlog. UnreadableDataError says what is missing in it."""
    survey = _survey(buffer, dialect, outputs.progress)
    plan = make_plan(survey, request.imu, request.reference)
    earth_field = _earth_field(survey, plan, request.declination_deg)
    weaver = None
    if outputs.woven is not None:
        weaver = Weaver(buffer, outputs.woven, Encoder(dialect, plan.sender[0], OUR_COMPONENT))
    filters = request.filters or (suitable_filter(survey, plan.sender),)
    facts = _facts(survey, plan)
    flight = Flight(
        plan,
        [one.with_vehicle_settings(facts) for one in filters],
        EarthField() if earth_field is None else earth_field.direction,
        request.window,
        outputs.rows,
        weaver,
    )
    decoder = _taught_decoder(dialect, survey, plan)
    _fly(buffer, decoder, flight, TlogReader(buffer, dialect, _wanted(dialect, plan)), outputs.progress)
    if not flight.imu.samples:
        raise UnreadableDataError(f"no usable {plan.imu}: {_lack(survey, plan, decoder)}")
    notes = [] if request.filters else _choice_notes(survey, plan)
    notes += [*_notes(survey, plan, decoder, flight), *fact_notes(survey.told(plan.sender), filters)]
    return Replay(survey, plan, earth_field, flight, tuple(notes))


@dataclass(frozen=True)
class Recording:
    """What ``replay`` takes from a log, decoded once: for many flights over it, or over what was made of it.

    samples: of the plan's vehicle, in order. To be given to a ``Flight`` of the same plan and field, with filters
    that are informed of the facts.
    """

    plan: Plan
    earth_field: LocalField | None
    facts: VehicleSettings
    samples: list[Sample]


def record(buffer: mmap | bytes, dialect: Dialect, imu: str | None = None, reference: str | None = None) -> Recording:
    """Decode a tlog; imu, reference and UnreadableDataError as with ``replay``."""
    survey = _survey(buffer, dialect, None)
    plan = make_plan(survey, imu, reference)
    decoder = _taught_decoder(dialect, survey, plan)
    samples: list[Sample] = []
    for frames in TlogReader(buffer, dialect, _wanted(dialect, plan)).batches():
        for frame in frames:
            if frame.system == plan.sender[0] and frame.component == plan.sender[1]:
                samples.extend(decoder.decode(frame))
    return Recording(plan, _earth_field(survey, plan, None), _facts(survey, plan), samples)


def _survey(buffer: mmap | bytes, dialect: Dialect, progress: Callable[[float], None] | None) -> Survey:
    """The first pass."""
    survey = Survey(dialect)
    for frames in read_windows(buffer, survey.census):
        survey.take(frames)
        if progress is not None:
            progress(SURVEY_SHARE * _share(survey.census.position, buffer))
    if not survey.census.frames:
        raise UnreadableDataError(f"this is no log that is known here: it has no MAVLink message; expected {EXPECTED}")
    return survey


def _share(done: int, buffer: mmap | bytes) -> float:
    """Share of the buffer that lies before ``done``."""
    return done / len(buffer)


def _earth_field(survey: Survey, plan: Plan, given_deg: float | None) -> LocalField | None:
    """Looked up at the vehicle's first good position, for the world it flew in; a given declination counts more."""
    position = survey.positions.get(plan.sender[0])
    found = None if position is None else _field_at(position, in_simulator(survey, plan.sender))
    if given_deg is None:
        return found
    return LocalField(given_deg, nan if found is None else found.inclination_deg, "given")


def _field_at(position: PositionSample, simulated: bool) -> LocalField:
    """In the simulator's world, or in this one on the day of the recording."""
    place = (position.latitude_deg, position.longitude_deg)
    found = simulated_field_at(*place) if simulated else None
    return found or field_at(*place, position.altitude_m, unix_s=position.rx_ns * 1e-9)


def _facts(survey: Survey, plan: Plan) -> VehicleSettings:
    """What the log tells of the vehicle's settings."""
    return facts_of(survey.autopilot(plan.sender), survey.told(plan.sender))


def _wanted(dialect: Dialect, plan: Plan) -> frozenset[int]:
    """Ids of the messages to decode in the second pass."""
    names = {plan.imu, plan.reference, plan.autopilot, plan.timing} - {None}
    names.update(AID_MESSAGES)
    return frozenset(dialect.id_of(name) for name in names if name is not None)


def _taught_decoder(dialect: Dialect, survey: Survey, plan: Plan) -> Decoder:
    """A decoder that knows the autopilot from the start, also where its first heartbeat comes late."""
    decoder = Decoder(dialect)
    heartbeat = survey.heartbeats.get(plan.sender)
    if heartbeat is not None:
        decoder.decode(heartbeat)
    return decoder


def _fly(
    buffer: mmap | bytes,
    decoder: Decoder,
    flight: Flight,
    reader: TlogReader,
    progress: Callable[[float], None] | None,
) -> None:
    """The second pass."""
    system, component = flight.sender
    for frames in reader.batches():
        for frame in frames:
            if frame.system == system and frame.component == component:
                for sample in decoder.decode(frame):
                    flight.take(sample, frame.offset + frame.size)
        if progress is not None and frames:
            progress(SURVEY_SHARE + (1.0 - SURVEY_SHARE) * _share(frames[-1].offset, buffer))
    flight.finish()


def _lack(survey: Survey, plan: Plan, decoder: Decoder) -> str:
    """Why there was no inertial sample."""
    if survey.autopilot(plan.sender) is None:
        return f"the log has no HEARTBEAT of system {plan.sender[0]}'s autopilot, which would tell its units"
    reasons = [reason for source, reason in decoder.refusals.items() if source in of_message(plan.imu)]
    return "; ".join(reasons) or "the part to be read has none"


def _choice_notes(survey: Survey, plan: Plan) -> list[str]:
    """Why the filter is not the one for flight, where nobody named one."""
    if plan.sender[0] in survey.velocities:
        return []
    chosen = suitable_filter(survey, plan.sender).name
    count = survey.count(plan.sender, "GPS_RAW_INT")
    lack = f"none of {count} GPS_RAW_INT has a 3-D fix with one" if count else "it has no GPS_RAW_INT"
    return [f"no velocity in the log: {lack}; so {chosen} was chosen, and not velocity-aided"]


def _notes(survey: Survey, plan: Plan, decoder: Decoder, flight: Flight) -> tuple[str, ...]:
    """What a reader of the figures should know."""
    notes = [f"{source}: {note}" for source, note in decoder.notes.items() if source == plan.imu]
    notes += [reason for source, reason in decoder.refusals.items() if source in of_message(plan.imu)]
    others = sorted(sender for sender in survey.heartbeats if sender != plan.sender)
    if others:
        named = ", ".join(f"{system}/{component}" for system, component in others)
        notes.append(f"the log has other autopilots too ({named}); this is {plan.sender[0]}/{plan.sender[1]}")
    if plan.reference is not None and not any(run.comparison.errors.samples for run in flight.runs):
        lost = all(run.aligned_s == inf for run in flight.runs)
        lack = "no filter found an attitude" if lost else f"no {plan.reference} at the times of the samples that count"
        notes.append(f"nothing was compared: {lack}")
    tilt = None if flight.autopilot is None else flight.autopilot.errors.tilt()
    if tilt is not None and tilt.max == 0.0:
        notes.append(f"{plan.autopilot} repeats {plan.reference}: this autopilot flew on the simulator's truth")
    return tuple(notes)
