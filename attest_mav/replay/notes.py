"""Remarks for the reader of a replay's figures, one line each."""

from collections.abc import Iterable, Sequence
from math import inf, isfinite

from attest_mav.filters.base import AttitudeFilter
from attest_mav.logs.source import LogSource, LogSummary, Plan
from attest_mav.mavlink.decode.autopilot_parameters import quantity, with_unit
from attest_mav.replay.flight import Flight
from attest_mav.replay.plan import suitable_filter
from attest_mav.types import ParameterSample


def all_notes(
    source: LogSource, summary: LogSummary, plan: Plan, flight: Flight, filters: Sequence[AttitudeFilter]
) -> list[str]:
    """The notes on a log that has been replayed with these filters."""
    vehicle = summary.vehicles[plan.vehicle]
    return [
        *source.notes(plan),
        *source.refusals(plan),
        *_other_autopilots(summary, plan),
        *_nothing_compared(plan, flight),
        *_truth_repeated(plan, flight),
        *flight.imu_frame.history,
        *_setting_notes(vehicle.parameters, filters),
    ]


def choice_notes(summary: LogSummary, plan: Plan) -> list[str]:
    """The reason why the flight filter was not chosen, for a user who named no filter."""
    vehicle = summary.vehicles[plan.vehicle]
    if vehicle.has_velocity:
        return []
    chosen = suitable_filter(vehicle).name
    return [f"no velocity in the log: {vehicle.velocity_lack}; so {chosen} was chosen, and not velocity-aided"]


def _other_autopilots(summary: LogSummary, plan: Plan) -> list[str]:
    others = [one.vehicle for one in summary.vehicles.values() if one.is_autopilot and one.vehicle != plan.vehicle]
    if not others:
        return []
    named = ", ".join(f"{system}/{component}" for system, component in others)
    return [f"the log has other autopilots too ({named}); this is {plan.vehicle[0]}/{plan.vehicle[1]}"]


def _nothing_compared(plan: Plan, flight: Flight) -> list[str]:
    if plan.reference is None or any(run.comparison.errors.samples for run in flight.runs):
        return []
    lost = all(run.aligned_s == inf for run in flight.runs)
    lack = "no filter found an attitude" if lost else f"no {plan.reference} at the times of the samples that count"
    return [f"nothing was compared: {lack}"]


def _truth_repeated(plan: Plan, flight: Flight) -> list[str]:
    tilt = None if flight.autopilot is None else flight.autopilot.errors.tilt()
    if tilt is None or tilt.max != 0.0:
        return []
    return [f"{plan.autopilot} repeats {plan.reference}: this autopilot flew on the simulator's truth"]


def _setting_notes(parameters: Iterable[ParameterSample], filters: Iterable[AttitudeFilter]) -> list[str]:
    """A line for each setting for which a filter takes the log's value instead of a different default."""
    notes = []
    for sample in parameters:
        for one in filters:
            assumed = one.default_settings.get(sample.setting)
            if isfinite(assumed) and isfinite(sample.value) and sample.value != assumed:
                value, instead = with_unit(sample.setting, sample.value), with_unit(sample.setting, assumed)
                notes.append(
                    f"{one.name} takes the {quantity(sample.setting)} from the log's {sample.name}: "
                    f"{value} instead of {instead}"
                )
    return notes
