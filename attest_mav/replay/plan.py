"""The choice of vehicle, inertial message, reference and filter, from a log's summary and the user's names."""

from typing import Final

from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.registry import default_filter
from attest_mav.logs.formats import inertial_names, reference_names
from attest_mav.logs.source import SMOOTHED, LogSummary, MessageRoles, Plan, VehicleSummary

VehicleChoice = tuple[int, int | None]
"""System and component of the vehicle to read; None for any component of the system."""

ENOUGH: Final = 0.5
"""An attitude with this share of the messages of the most frequent one, over this share of its span, is as good."""
TRUTH_SHARE: Final = 0.1
"""A simulator's truth is preferred to the autopilot's attitude if it has at least this share of its messages."""
SMOOTHED_HZ: Final = 10.0
"""The smoothed attitude is a reference by itself where the inertial message comes at this rate or faster: below, motion
is lost between the samples."""
FULL_SHARE: Final = 0.9
"""An inertial message with at least this share of the largest count is as good as the most frequent one."""


def check_names(imu: str | None, reference: str | None) -> None:
    """Raise UsageError unless both are messages of a readable format."""
    if imu is not None and imu not in inertial_names():
        raise UsageError(f"unknown inertial message {imu!r}; known: {', '.join(inertial_names())}")
    known = (*reference_names(), SMOOTHED)
    if reference is not None and reference not in known:
        raise UsageError(f"unknown reference {reference!r}; known: {', '.join(known)}")


def make_plan(
    summary: LogSummary,
    imu: str | None,
    reference: str | None,
    wanted: VehicleChoice | None = None,
    *,
    smooths: bool = False,
) -> Plan:
    """Choose what is not named; an inertial message that is named is used without the other sensors.

    smooths: the smoothed attitude can be had, and is the reference of a log without a truth that allows it.
    UnreadableDataError if what is named, or an inertial message, is missing.
    """
    roles = summary.roles
    vehicle = _choose_vehicle(summary, imu, wanted)
    if reference not in (None, SMOOTHED) and not vehicle.count(reference):
        instead = _instead(vehicle, roles.named_reference)
        raise UnreadableDataError(f"no {reference} in it to compare with{instead}")
    autopilot = _fullest(vehicle, roles.autopilot)
    inertial = imu or _choose_imu(vehicle)
    chosen = reference or _choose_truth(vehicle, roles)
    if chosen is None and smooths and _allows_smoothing(summary, vehicle, inertial):
        chosen = SMOOTHED
    chosen = chosen or _choose_reference(vehicle, roles)
    return Plan(
        vehicle.vehicle,
        inertial,
        chosen,
        autopilot if chosen not in roles.autopilot else None,
        (autopilot or inertial) if chosen in roles.untimed else None,
        () if imu is not None else _other_sensors(vehicle, roles, inertial),
    )


def suitable_filter() -> AttitudeFilter:
    """The filter if the user names none: the most accurate one, without a receiver's velocity too."""
    return default_filter("velocity-aided")


def replayable(summary: LogSummary) -> list[VehicleSummary]:
    """The flight controllers with inertial messages, all senders with some if there is no flight controller."""
    present = [one for one in summary.vehicles.values() if _total(one, summary.roles.inertial)]
    return [one for one in present if one.is_autopilot] or present


def _choose_vehicle(summary: LogSummary, imu: str | None, wanted: VehicleChoice | None) -> VehicleSummary:
    """The flight controller with most inertial messages; any sender if there is no flight controller."""
    names = summary.roles.inertial if imu is None else (imu,)
    senders = list(summary.vehicles.values())
    if wanted is not None:
        senders = [one for one in senders if _is_wanted(one, wanted)]
        if not senders:
            raise UnreadableDataError(f"no vehicle {_named(wanted)} in it{_vehicles_instead(summary)}")
    candidates = [one for one in senders if one.is_autopilot] or senders
    best = max(candidates, key=lambda one: _total(one, names), default=None)
    if best is None or not _total(best, names):
        present = "" if best is None else _instead(best, summary.roles.inertial)
        of_vehicle = "" if wanted is None else f" of vehicle {_named(wanted)}"
        raise UnreadableDataError(
            f"no {' or '.join(names)}{of_vehicle} in it: nothing to estimate an attitude from{present}"
        )
    return best


def _is_wanted(vehicle: VehicleSummary, wanted: VehicleChoice) -> bool:
    system, component = wanted
    return vehicle.vehicle[0] == system and component in (None, vehicle.vehicle[1])


def _named(wanted: VehicleChoice) -> str:
    system, component = wanted
    return str(system) if component is None else f"{system}/{component}"


def _vehicles_instead(summary: LogSummary) -> str:
    """The vehicles in the log that would do instead, to be appended to an error."""
    present = [f"{one.vehicle[0]}/{one.vehicle[1]}" for one in replayable(summary)]
    return f"; it has {', '.join(present)}" if present else ""


def _choose_truth(vehicle: VehicleSummary, roles: MessageRoles) -> str | None:
    """A simulator's truth if there is enough of it."""
    count = max([vehicle.count(name) for name in roles.reference], default=0)
    return _fullest(vehicle, tuple([name for name in roles.truth if vehicle.count(name) >= TRUTH_SHARE * count]))


def _allows_smoothing(summary: LogSummary, vehicle: VehicleSummary, imu: str) -> bool:
    """Whether rate and aids of the log promise a smoothed attitude better than the autopilot's own."""
    return vehicle.has_velocity and vehicle.count(imu) >= SMOOTHED_HZ * summary.duration_s > 0.0


def _choose_reference(vehicle: VehicleSummary, roles: MessageRoles) -> str | None:
    """The fullest of the autopilot's attitudes, else what there is of a truth."""
    others = tuple(name for name in roles.reference if name not in roles.truth)
    return _fullest(vehicle, others) or _fullest(vehicle, roles.truth)


def _fullest(vehicle: VehicleSummary, names: tuple[str, ...]) -> str | None:
    """The first of the names with about as many messages as any, over about as much of the log; None without any."""
    present = [name for name in names if vehicle.count(name) and name not in vehicle.unfit]
    count = max([vehicle.count(name) for name in present], default=0)
    span = max([vehicle.spans.get(name, 1.0) for name in present], default=0.0)
    for name in present:
        if vehicle.count(name) >= ENOUGH * count and vehicle.spans.get(name, 1.0) >= ENOUGH * span:
            return name
    return max(present, key=vehicle.count, default=None)


def _total(vehicle: VehicleSummary, names: tuple[str, ...]) -> int:
    """Number of messages with one of the names."""
    return sum([vehicle.count(name) for name in names])


def _choose_imu(vehicle: VehicleSummary) -> str:
    """The best of the inertial messages that are about as frequent as the most frequent one."""
    enough = FULL_SHARE * max([vehicle.count(name) for name in vehicle.inertial])
    return next(name for name in vehicle.inertial if vehicle.count(name) >= enough)


def _other_sensors(vehicle: VehicleSummary, roles: MessageRoles, imu: str) -> tuple[str, ...]:
    """The inertial messages of the other sensors that come about as often as this one."""
    least = ENOUGH * vehicle.count(imu)
    return tuple(name for name in roles.other_sensors.get(imu, ()) if vehicle.count(name) >= least)


def _instead(vehicle: VehicleSummary, names: tuple[str, ...]) -> str:
    """The messages in the log that would do instead, to be appended to an error."""
    present = [name for name in names if vehicle.count(name)]
    return f"; it has {', '.join(present)}" if present else ""
