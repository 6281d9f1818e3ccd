"""The findings of a survey as the summary that every log format gives."""

from attest_mav.logs.source import LogSummary, VehicleId, VehicleSummary
from attest_mav.logs.tlog.message_counter import key_parts
from attest_mav.logs.tlog.roles import TLOG_ROLES, inertial_by_preference
from attest_mav.logs.tlog.survey import Survey
from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_INVALID
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware
from attest_mav.mavlink.dialect import Dialect


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
    parameters = tuple(survey.parameters.get(vehicle, {}).values())
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
    )


def _velocity_lack(counts: dict[str, int]) -> str:
    """The reason why there is no receiver velocity."""
    count = counts.get("GPS_RAW_INT", 0)
    return f"none of {count} GPS_RAW_INT has a 3-D fix with one" if count else "it has no GPS_RAW_INT"
