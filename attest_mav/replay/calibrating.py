"""Sensor errors of earlier flights at the start of a replay, and those of its flight in the end."""

from contextlib import suppress
from typing import TYPE_CHECKING, Final

from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.estimation.sensor_identity import of_present_sensors
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.logs.source import Plan, VehicleSummary
from attest_mav.replay.flight import Flight
from attest_mav.replay.north import date_of
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import IDENTIFYING, Setting

if TYPE_CHECKING:
    from attest_mav.config.calibration import KeptCalibrations

DAY_S: Final = 86400.0
FIRST_UNIX_S: Final = 1e9
"""An earlier UNIX time (2001) is that of a clock that was not set."""


def identify(flight: Flight, vehicle: VehicleSummary) -> None:
    """Tell the filters from which sensors the readings come, as the autopilot has told it first."""
    for run in flight.runs:
        _tell(run.pipeline.vehicle, vehicle)


def _tell(state: Vehicle, vehicle: VehicleSummary) -> None:
    told: dict[Setting, ParameterSample] = {one.setting: one for one in vehicle.parameters}
    told.update({one.setting: one for one in vehicle.opening if isinstance(one, ParameterSample)})
    for setting, sample in told.items():
        if setting in IDENTIFYING:
            state.take(sample)


def known_at_smoothing(
    plan: Plan, vehicle: VehicleSummary, kept: "KeptCalibrations", settings: PipelineSettings
) -> SensorCalibration | None:
    """The errors of the sensor that is smoothed, as far as its readings come from the same sensors."""
    known = known_errors(plan, vehicle, kept).get(plan.imu)
    if known is None:
        return None
    state = Vehicle(settings.aids)
    _tell(state, vehicle)
    return of_present_sensors(known, plan.imu, state)


def calibrate(flight: Flight, plan: Plan, vehicle: VehicleSummary, kept: "KeptCalibrations") -> list[str]:
    """Let the filters begin with the errors of the sensors by earlier flights; remarks for people."""
    if not kept:
        return []
    known, system = known_errors(plan, vehicle, kept), plan.vehicle[0]
    for run in flight.runs:
        run.pipeline.vehicle.calibrations = known
    used = [name for name in (plan.imu, *plan.other_sensors) if name in known]
    if not used:
        return [f"the calibration has neither {system}/{plan.imu} nor another sensor used here: it has {_list(kept)}"]
    ages = [f"{name} {known[name].age_s / DAY_S:.0f} days old" for name in used]
    return [f"the filter begins with sensor errors of earlier flights: {', '.join(ages)}"]


def known_errors(plan: Plan, vehicle: VehicleSummary, kept: "KeptCalibrations") -> dict[str, SensorCalibration]:
    """The errors of the sensors by earlier flights, by inertial message.

    Without a date of the flight they count as just learned.
    """
    if not kept:
        return {}
    from attest_mav.config.calibration import calibrations_of  # noqa: PLC0415  (its library costs 20 ms)

    return calibrations_of(kept, plan.vehicle[0], _unix_s(vehicle))


def learned(flight: Flight, plan: Plan, vehicle: VehicleSummary) -> "KeptCalibrations":
    """The errors of the sensors that the first filter which knows them has found."""
    from attest_mav.config.calibration import kept_calibration  # noqa: PLC0415  (as above)

    system, unix_s = plan.vehicle[0], _unix_s(vehicle)
    found = next((one for run in flight.runs if (one := run.pipeline.learned)), {})
    kept: KeptCalibrations = {}
    for name, shown in found.items():
        with suppress(ValueError):  # an estimate that is no number teaches nothing
            kept[f"{system}/{name}"] = kept_calibration(shown, unix_s)
    return kept


def _unix_s(vehicle: VehicleSummary) -> float | None:
    """The date of the flight, s since 1970; None where the log does not tell it."""
    date = date_of(vehicle)
    return None if date is None or date.unix_s < FIRST_UNIX_S else date.unix_s


def _list(kept: "KeptCalibrations") -> str:
    return ", ".join(sorted(kept))
