"""The findings of a survey as the summary that every log format gives."""

from collections.abc import Mapping

from attest_mav.logs.source import LogSummary, VehicleId, VehicleSummary
from attest_mav.logs.tlog.message_counter import key_parts
from attest_mav.logs.tlog.roles import GROUND_SYSTEM, TLOG_ROLES, inertial_by_preference
from attest_mav.logs.tlog.survey import Survey
from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_ARDUPILOTMEGA,
    MAV_AUTOPILOT_INVALID,
    MAV_COMP_ID_MISSIONPLANNER,
)
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware
from attest_mav.mavlink.dialect import Dialect
from attest_mav.types import ParameterSample, Sample


def summarize(survey: Survey, dialect: Dialect) -> LogSummary:
    """The summary of a surveyed tlog."""
    counter = survey.counter
    counts = _counts(survey, dialect)
    return LogSummary(
        log_format="tlog",
        roles=TLOG_ROLES,
        messages=counter.frames,
        bad_bytes=counter.bad_bytes,
        duration_s=(counter.last_rx_ns - counter.first_rx_ns) * 1e-9,
        vehicles={vehicle: _vehicle(survey, vehicle, counts[vehicle]) for vehicle in sorted(counts)},
    )


def _counts(survey: Survey, dialect: Dialect) -> dict[VehicleId, dict[str, int]]:
    """Number of messages by sender and name."""
    counts: dict[VehicleId, dict[str, int]] = {}
    for key, count in survey.counter.counts.items():
        system, component, message_id = key_parts(key)
        counts.setdefault((system, component), {})[dialect.name_of(message_id)] = count
    return counts


def _vehicle(survey: Survey, vehicle: VehicleId, counts: dict[str, int]) -> VehicleSummary:
    """The summary of one sender. Heartbeat and receiver count for all components of its system."""
    system = vehicle[0]
    autopilot = survey.autopilots.get(system)
    parameters = _parameters(survey, vehicle, survey.parameters)
    settings = facts_of_firmware(MAV_AUTOPILOT_INVALID if autopilot is None else autopilot)
    for sample in parameters:
        settings = settings.updated(sample.setting, sample.value)
    return VehicleSummary(
        vehicle=vehicle,
        is_autopilot=vehicle in survey.heartbeats,
        counts=counts,
        inertial=inertial_by_preference(autopilot),
        in_simulator=autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA and any(name in counts for name in TLOG_ROLES.truth),
        position=survey.positions.get(system),
        velocity_lack="" if system in survey.velocities else _velocity_lack(counts),
        settings=settings,
        parameters=parameters,
        opening=_opening(survey, vehicle),
    )


def _opening(survey: Survey, vehicle: VehicleId) -> tuple[Sample, ...]:
    """The first heartbeat of one sender, its firmware, and the first value of each parameter, as far as known."""
    known: list[Sample] = [*_parameters(survey, vehicle, survey.first_parameters)]
    if vehicle in survey.first_heartbeats:
        known.append(survey.first_heartbeats[vehicle])
    if vehicle in survey.firmware:
        known.append(survey.firmware[vehicle])
    return tuple(known)


def _parameters(
    survey: Survey, vehicle: VehicleId, told: Mapping[VehicleId, Mapping[int, ParameterSample]]
) -> tuple[ParameterSample, ...]:
    """One parameter a setting: the sender's own, else that which a ground station recorded for it."""
    by_setting: dict[int, ParameterSample] = {}
    if vehicle in survey.heartbeats:
        for sender in sorted(told):
            if _speaks_for(sender, vehicle, survey):
                by_setting.update(told[sender])
    by_setting.update(told.get(vehicle, {}))
    return tuple(by_setting.values())


def _speaks_for(sender: VehicleId, vehicle: VehicleId, survey: Survey) -> bool:
    """True for a ground station that records parameters of this vehicle, or of the only one.

    A ground station that downloads the parameters as a file writes them into its log under ids of its own.
    """
    system, component = sender
    if system == vehicle[0]:
        return component == MAV_COMP_ID_MISSIONPLANNER
    return system == GROUND_SYSTEM and len(survey.heartbeats) == 1


def _velocity_lack(counts: dict[str, int]) -> str:
    """The reason why there is no receiver velocity."""
    count = counts.get("GPS_RAW_INT", 0)
    return f"none of {count} GPS_RAW_INT has a 3-D fix with one" if count else "it has no GPS_RAW_INT"
