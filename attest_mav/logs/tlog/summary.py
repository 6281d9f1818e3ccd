"""The findings of a survey as the summary that every log format gives."""

from collections.abc import Mapping

from attest_mav.estimation.imu_frame import ImuFrame, Refusal
from attest_mav.estimation.vehicle import AidSettings, Vehicle
from attest_mav.logs.source import FlightDate, LogSummary, VehicleId, VehicleSummary
from attest_mav.logs.tlog.clocks import LogClocks, date_of
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
from attest_mav.samples import Sample
from attest_mav.vehicle_reports import ParameterSample


def summarize(survey: Survey, clocks: LogClocks, dialect: Dialect, log_format: str, length: int) -> LogSummary:
    """The summary of a surveyed log of so many bytes."""
    counter = survey.counter
    counts = _counts(survey, dialect)
    return LogSummary(
        log_format=log_format,
        roles=TLOG_ROLES,
        messages=counter.frames,
        bad_bytes=counter.bad_bytes,
        duration_s=clocks.duration_s(),
        vehicles={vehicle: _vehicle(survey, clocks, vehicle, counts[vehicle], length) for vehicle in sorted(counts)},
    )


def _counts(survey: Survey, dialect: Dialect) -> dict[VehicleId, dict[str, int]]:
    """Number of messages by sender and name."""
    counts: dict[VehicleId, dict[str, int]] = {}
    for key, count in survey.counter.counts.items():
        system, component, message_id = key_parts(key)
        counts.setdefault((system, component), {})[dialect.name_of(message_id)] = count
    return counts


def _vehicle(
    survey: Survey, clocks: LogClocks, vehicle: VehicleId, counts: dict[str, int], length: int
) -> VehicleSummary:
    """The summary of one sender. Heartbeat and receiver count for all components of its system."""
    system = vehicle[0]
    autopilot = survey.autopilots.get(system)
    parameters = _parameters(survey, vehicle, survey.parameters)
    heartbeat = survey.first_heartbeats.get(vehicle)
    settings = facts_of_firmware(
        MAV_AUTOPILOT_INVALID if autopilot is None else autopilot, -1 if heartbeat is None else heartbeat.vehicle_type
    )
    first_settings = settings
    for sample in parameters:
        settings = settings.updated(sample.setting, sample.value)
    return VehicleSummary(
        vehicle=vehicle,
        is_autopilot=vehicle in survey.heartbeats,
        counts=counts,
        inertial=inertial_by_preference(autopilot),
        in_simulator=autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA and any(name in counts for name in TLOG_ROLES.truth),
        position=survey.positions.get(system),
        velocity_lack="" if _has_velocity(survey, clocks, vehicle) else _velocity_lack(counts),
        settings=settings,
        parameters=parameters,
        opening=_opening(survey, vehicle),
        first_settings=first_settings,
        date=_date(survey, system),
        spans=survey.attitudes.spans(vehicle, length),
        unfit=_unfit(survey, vehicle, counts),
    )


def _unfit(survey: Survey, vehicle: VehicleId, counts: dict[str, int]) -> dict[str, str]:
    """The reasons why attitudes cannot be compared; a frame that is not known at once only while another one is.

    An attitude of the secondary estimator is none of the autopilot's, whatever else there is.
    """
    attitudes = {name: count for name, count in counts.items() if name in TLOG_ROLES.named_reference}
    reasons = survey.attitudes.unfit(vehicle, attitudes)
    foreign = {}
    frame = ImuFrame(_known(survey, vehicle))
    fit = [name for name in TLOG_ROLES.autopilot if name in attitudes and name not in reasons]
    for name in fit:
        first = survey.attitudes.first_of(vehicle, name)
        if first is None or frame.attitude(first) is not None:
            continue
        refusal = frame.refusal(name)
        if refusal == Refusal.SECONDARY:
            reasons[name] = f"{name}: {refusal.value}"
        else:
            foreign[name] = f"{name} is in a frame that its firmware does not tell"
    return reasons if len(foreign) == len(fit) else {**reasons, **foreign}


def _known(survey: Survey, vehicle: VehicleId) -> Vehicle:
    """The vehicle as it is known at the beginning."""
    known = Vehicle(AidSettings())
    for sample in _opening(survey, vehicle):
        known.take(sample)
    return known


def _has_velocity(survey: Survey, clocks: LogClocks, vehicle: VehicleId) -> bool:
    """True for a receiver's velocity whose time is known, or becomes so by the shift of the inertial times."""
    system = vehicle[0]
    return system in survey.velocities or (system in survey.untimed_velocities and clocks.unix_shift_us(vehicle) != 0)


def _date(survey: Survey, system: int) -> FlightDate | None:
    """The date of a system's flight; None where it has no position to look anything up for."""
    position = survey.positions.get(system)
    if position is None:
        return None
    counter = survey.counter
    arrivals = () if counter.bare else (position.rx_ns, counter.first_rx_ns, counter.last_rx_ns)
    return date_of(arrivals, survey.told_us.get(system))


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
