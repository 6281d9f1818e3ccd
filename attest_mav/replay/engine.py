"""Runs filters over a recorded flight and compares them, and the autopilot's own attitude, with a reference.

The log is read twice: its summary tells what is there, and with the plan made of it the second pass decodes only what
is needed. Every filter gets a pipeline of its own, so that filters run together give what they give apart, bit for bit.
Nothing grows with the log but the columns of errors and of intervals.
"""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Final

from attest_mav.earth_field import LocalField
from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.source import (
    SMOOTHED,
    AnnotatableSource,
    ByteSink,
    EstimateWriter,
    LogSource,
    LogSummary,
    Plan,
    Progress,
    VehicleSummary,
)
from attest_mav.record import Record
from attest_mav.replay.calibrating import calibrate, identify, known_at_smoothing, learned
from attest_mav.replay.flight import Flight
from attest_mav.replay.north import LocalNorth, north_of
from attest_mav.replay.notes import all_notes, choice_notes
from attest_mav.replay.plan import make_plan, suitable_filter
from attest_mav.replay.request import Outputs, Request
from attest_mav.replay.smoothed import FlightToSmooth, SmoothedFlight, samples_of
from attest_mav.samples import Sample
from attest_mav.types import EarthField
from attest_mav.vehicle_settings import VehicleSettings

SUMMARY_SHARE: Final = 0.2
"""Approximate share of the first pass in the time of a replay, for the progress."""


class Replay:
    """The result of one log."""

    def __init__(
        self, summary: LogSummary, plan: Plan, earth_field: LocalField | None, flight: Flight, notes: tuple[str, ...]
    ) -> None:
        self.summary: Final = summary
        self.plan: Final = plan
        self.earth_field: Final = earth_field
        """None if headings stay magnetic."""
        self.flight: Final = flight
        self.notes: Final = notes
        """Remarks for the reader of the figures, a line each."""


class Recording(Record):
    """The samples of a log, decoded once for many flights over them or over edited forms of them.

    A ``Flight`` takes them with the same plan and field, and with filters that know the settings.
    """

    def __init__(
        self, plan: Plan, earth_field: LocalField | None, settings: VehicleSettings, samples: list[Sample]
    ) -> None:
        self.plan: Final = plan
        self.earth_field: Final = earth_field
        """None if headings stay magnetic."""
        self.settings: Final = settings
        """The settings of the vehicle."""
        self.samples: Final = samples
        """All samples of the plan's vehicle, in order of time."""


def replay(source: LogSource, request: Request, outputs: Outputs) -> Replay:
    """Replay a log. UnreadableDataError names what is missing in it."""
    summary = source.summary(_part_of(outputs.progress, 0.0, SUMMARY_SHARE))
    plan = make_plan(summary, request.imu, request.reference, request.vehicle, smooths=request.smooth is not None)
    vehicle = summary.vehicles[plan.vehicle]
    north = north_of(vehicle, request.declination_deg)
    with _smoothed(source, plan, vehicle, north.direction, request) as smoothed:
        if smoothed is None and request.reference == SMOOTHED:
            raise UnreadableDataError(f"{plan.imu} shows no attitude that the smoother could begin with")
        if smoothed is None and plan.reference == SMOOTHED:
            plan = make_plan(summary, request.imu, request.reference, request.vehicle)
        return _replayed(source, request, outputs, summary, plan, north, smoothed)


def _replayed(
    source: LogSource,
    request: Request,
    outputs: Outputs,
    summary: LogSummary,
    plan: Plan,
    north: LocalNorth,
    smoothed: SmoothedFlight | None,
) -> Replay:
    """The second pass and its result."""
    vehicle = summary.vehicles[plan.vehicle]
    filters = request.filters or (suitable_filter(),)
    flight = Flight(
        plan,
        filters if request.as_it_came else [one.with_vehicle_settings(vehicle.settings) for one in filters],
        north.direction,
        request.window,
        outputs.attitudes,
        _estimate_writer(source, plan, outputs.annotated),
        vehicle.opening,
        request.pipeline,
        outputs.observer,
        (vehicle.first_settings or vehicle.settings) if request.as_it_came else None,
        smoothed,
    )
    if not request.as_it_came:
        identify(flight, vehicle)
    remarks = calibrate(flight, plan, vehicle, request.calibrations)
    if outputs.observer is not None:
        outputs.observer.begin(north.direction)
    _fly(source, flight, plan, _part_of(outputs.progress, SUMMARY_SHARE, 1.0))
    if not flight.imu.samples:
        reasons = "; ".join(source.refusals(plan)) or "the part to be read has none"
        raise UnreadableDataError(f"no usable {plan.imu}: {reasons}")
    if outputs.learned is not None:
        outputs.learned(learned(flight, plan, vehicle))
    notes = [] if request.filters else choice_notes(summary, plan)
    notes += [*remarks, *all_notes(source, summary, plan, flight, filters), *north.notes]
    return Replay(summary, plan, north.field, flight, tuple(notes))


def _smoothed(
    source: LogSource, plan: Plan, vehicle: VehicleSummary, field: EarthField, request: Request
) -> AbstractContextManager[SmoothedFlight | None]:
    """The smoothed attitude, if it is the reference or wanted beside it."""
    smooth, window = request.smooth, request.window
    is_reference = plan.reference == SMOOTHED
    if smooth is None or not (is_reference or request.smooths_beside_truth):
        return nullcontext()
    ours = [one for one in request.filters if isinstance(one, VelocityAided)]
    one = (ours[0] if ours else VelocityAided()).with_vehicle_settings(vehicle.settings)
    flight = FlightToSmooth(
        samples_of(source, plan),
        plan.imu,
        vehicle.opening,
        field,
        request.pipeline,
        one.parameters,
        window.start_s,
        window.end_s,
        known_at_smoothing(plan, vehicle, request.calibrations, request.pipeline),
    )
    return smooth(flight)


def record(
    source: LogSource, imu: str | None = None, reference: str | None = None, *, every_sensor: bool = False
) -> Recording:
    """Decode a log; imu, reference and UnreadableDataError as for ``replay``. One inertial sensor, or every one."""
    summary = source.summary()
    plan = make_plan(summary, imu, reference)
    if not every_sensor:
        plan = replace(plan, other_sensors=())
    vehicle = summary.vehicles[plan.vehicle]
    samples: list[Sample] = []
    for batch in source.samples(plan):
        samples.extend(batch.samples)
    return Recording(plan, north_of(vehicle, None).field, vehicle.settings, samples)


def _part_of(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """The progress of one pass, which takes the whole's share from begin to end."""
    if progress is None:
        return None
    whole = progress
    return lambda share: whole(begin + (end - begin) * share)


def _estimate_writer(source: LogSource, plan: Plan, sink: ByteSink | None) -> EstimateWriter | None:
    """The writer of the annotated log, if one is wanted; UsageError if the format of the log has none."""
    if sink is None:
        return None
    if not isinstance(source, AnnotatableSource):
        raise UsageError("the format of this log cannot hold our attitudes; expected a tlog")
    return source.estimate_writer(plan, sink)


def _fly(source: LogSource, flight: Flight, plan: Plan, progress: Progress | None) -> None:
    """The second pass."""
    for batch in source.samples(plan):
        samples, positions = batch.samples, batch.positions
        if positions:
            for sample, position in zip(samples, positions, strict=True):
                flight.take(sample, position)
        else:
            for sample in samples:
                flight.take(sample)
        if progress is not None:
            progress(batch.share)
    flight.finish()
