"""Remarks for the reader of a replay's figures, one line each."""

from collections.abc import Iterable, Sequence
from math import degrees, isfinite

from attest_mav.estimation.body_frames import ARDUPILOT
from attest_mav.filters.base import AttitudeFilter
from attest_mav.logs.source import LogSource, LogSummary, Plan, VehicleSummary
from attest_mav.replay.flight import Flight
from attest_mav.replay.plan import replayable
from attest_mav.replay.sampling_notes import coverage_notes, rate_notes
from attest_mav.replay.smoothed import LARGEST_HEADING, LARGEST_TILT
from attest_mav.vehicle_reports import HeartbeatSample, ParameterSample
from attest_mav.vehicle_settings import Setting, quantity, with_unit


def all_notes(
    source: LogSource, summary: LogSummary, plan: Plan, flight: Flight, filters: Sequence[AttitudeFilter]
) -> list[str]:
    """The notes on a log that has been replayed with these filters."""
    vehicle = summary.vehicles[plan.vehicle]
    return [
        *source.notes(plan),
        *source.refusals(plan),
        *_other_vehicles(summary, plan),
        *_unfit_attitudes(vehicle, plan),
        *rate_notes(plan, flight),
        *coverage_notes(plan, flight),
        *_smoothed(flight),
        *_truth_repeated(plan, flight),
        *_untold_trim(summary, plan, flight),
        *flight.imu_frame.history,
        *_setting_notes(vehicle.parameters, filters),
    ]


def choice_notes(summary: LogSummary, plan: Plan) -> list[str]:
    """A remark on the filter, for a user who named none."""
    vehicle = summary.vehicles[plan.vehicle]
    if vehicle.has_velocity:
        return []
    return [f"no velocity in the log: {vehicle.velocity_lack}; velocity-aided goes by gravity instead"]


def _other_vehicles(summary: LogSummary, plan: Plan) -> list[str]:
    """The other vehicles that could be replayed."""
    others = [one.vehicle for one in replayable(summary) if one.vehicle != plan.vehicle]
    if not others:
        return []
    named = ", ".join(f"{system}/{component}" for system, component in others)
    this = f"{plan.vehicle[0]}/{plan.vehicle[1]}"
    return [f"the log has other vehicles too ({named}); this is {this} (--vehicle names another)"]


def _unfit_attitudes(vehicle: VehicleSummary, plan: Plan) -> list[str]:
    """A line for each attitude that is not compared, or should not have been."""
    used = (plan.reference, plan.autopilot)
    return [reason if name in used else f"{reason}; not compared" for name, reason in vehicle.unfit.items()]


def _smoothed(flight: Flight) -> list[str]:
    """The error that a smoothed reference may have itself, and the part of the flight that it does not judge."""
    run = flight.smoothed
    if run is None:
        return []
    notes = ["the flight contradicts the calibration: it is smoothed without"] if run.has_refuted else []
    if not run.is_reference:
        return notes
    tilt, heading = run.sigmas.tilt(), run.sigmas.heading()
    if tilt is not None and heading is not None:
        notes.append(
            f"errors are differences from the smoothed attitude, whose own sigma is {tilt.rms:.2f} deg of tilt and "
            f"{heading.rms:.2f} deg of heading (rms)"
        )
    if run.unsure:
        limits = f"{degrees(LARGEST_TILT):.0f} deg of tilt or {degrees(LARGEST_HEADING):.0f} deg of heading"
        notes.append(f"at {run.unsure} samples the smoothed attitude's sigma is above {limits}: not compared there")
    return notes


def _truth_repeated(plan: Plan, flight: Flight) -> list[str]:
    tilt = None if flight.autopilot is None else flight.autopilot.errors.tilt()
    if tilt is None or tilt.p95 != 0.0:
        return []
    return [f"{plan.autopilot} repeats {plan.reference}: this autopilot flew on the simulator's truth"]


def _untold_trim(summary: LogSummary, plan: Plan, flight: Flight) -> list[str]:
    """A steady tilt against an autopilot that can be trimmed, in a log without its parameters."""
    vehicle = summary.vehicles[plan.vehicle]
    is_trimmable = any(isinstance(one, HeartbeatSample) and one.autopilot == ARDUPILOT for one in vehicle.opening)
    is_told = isfinite(vehicle.settings.get(Setting.TRIM_X))
    if not is_trimmable or is_told or plan.reference not in summary.roles.autopilot:
        return []
    steady = flight.runs[0].comparison.steady_tilt
    offset_deg = None if steady is None else steady.offset_deg()
    if offset_deg is None:
        return []
    kind = "of the kind that AHRS_TRIM makes; the log does not tell the trim"
    return [f"steady tilt of {offset_deg:.1f} deg against {plan.reference}, {kind}"]


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
