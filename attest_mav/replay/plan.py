"""The choice of vehicle, inertial message, reference and filter, from a log's summary and the user's names."""

from typing import Final

from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.registry import default_filter
from attest_mav.logs.formats import inertial_names, reference_names
from attest_mav.logs.source import LogSummary, Plan, VehicleSummary

FULL_SHARE: Final = 0.9
"""An inertial message with at least this share of the largest count is as good as the most frequent one."""


def check_names(imu: str | None, reference: str | None) -> None:
    """Raise UsageError unless both are messages of a readable format."""
    if imu is not None and imu not in inertial_names():
        raise UsageError(f"unknown inertial message {imu!r}; known: {', '.join(inertial_names())}")
    if reference is not None and reference not in reference_names():
        raise UsageError(f"unknown reference {reference!r}; known: {', '.join(reference_names())}")


def make_plan(summary: LogSummary, imu: str | None, reference: str | None) -> Plan:
    """Choose the messages that are not named. UnreadableDataError if a named or an inertial message is missing."""
    roles = summary.roles
    vehicle = _choose_vehicle(summary, imu)
    if reference is not None and not vehicle.count(reference):
        instead = _instead(vehicle, roles.named_reference)
        raise UnreadableDataError(f"no {reference} in it to compare with{instead}")
    chosen = reference or _first_present(vehicle, roles.reference)
    autopilot = _first_present(vehicle, roles.autopilot)
    inertial = imu or _choose_imu(vehicle)
    return Plan(
        vehicle.vehicle,
        inertial,
        chosen,
        autopilot if chosen not in roles.autopilot else None,
        (autopilot or inertial) if chosen in roles.untimed else None,
    )


def suitable_filter(vehicle: VehicleSummary) -> AttitudeFilter:
    """The filter if the user names none: the flight filter if the log has a receiver velocity."""
    return default_filter("velocity-aided" if vehicle.has_velocity else "gradient-descent")


def _choose_vehicle(summary: LogSummary, imu: str | None) -> VehicleSummary:
    """The flight controller with most inertial messages; any sender if there is no flight controller."""
    wanted = summary.roles.inertial if imu is None else (imu,)
    senders = list(summary.vehicles.values())
    candidates = [one for one in senders if one.is_autopilot] or senders
    best = max(candidates, key=lambda one: _total(one, wanted), default=None)
    if best is None or not _total(best, wanted):
        present = "" if best is None else _instead(best, summary.roles.inertial)
        raise UnreadableDataError(f"no {' or '.join(wanted)} in it: nothing to estimate an attitude from{present}")
    return best


def _total(vehicle: VehicleSummary, names: tuple[str, ...]) -> int:
    """Number of messages with one of the names."""
    return sum([vehicle.count(name) for name in names])


def _choose_imu(vehicle: VehicleSummary) -> str:
    """The best of the inertial messages that are about as frequent as the most frequent one."""
    enough = FULL_SHARE * max([vehicle.count(name) for name in vehicle.inertial])
    return next(name for name in vehicle.inertial if vehicle.count(name) >= enough)


def _first_present(vehicle: VehicleSummary, names: tuple[str, ...]) -> str | None:
    """The first of the names of which there is a message."""
    return next((name for name in names if vehicle.count(name)), None)


def _instead(vehicle: VehicleSummary, names: tuple[str, ...]) -> str:
    """The messages in the log that would do instead, to be appended to an error."""
    present = [name for name in names if vehicle.count(name)]
    return f"; it has {', '.join(present)}" if present else ""
