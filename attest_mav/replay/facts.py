"""What a log tells of the vehicle's settings: by the firmware, and by parameters that a ground station downloaded."""

from collections.abc import Iterable
from math import isfinite

from attest_mav.filters.base import AttitudeFilter
from attest_mav.mavlink.decode.autopilot_parameters import facts_of_firmware, quantity, with_unit
from attest_mav.mavlink.decode.units import INVALID
from attest_mav.types import ParameterSample, VehicleSettings


def facts_of(autopilot: int | None, told: Iterable[ParameterSample]) -> VehicleSettings:
    """The facts of one vehicle: its MAV_AUTOPILOT, None where no heartbeat tells, and its parameters."""
    facts = facts_of_firmware(INVALID if autopilot is None else autopilot)
    for sample in told:
        facts = facts.updated(sample.setting, sample.value)
    return facts


def fact_notes(told: Iterable[ParameterSample], filters: Iterable[AttitudeFilter]) -> list[str]:
    """A line for each setting that a filter takes from the log and would have assumed to be another."""
    notes = []
    for sample in told:
        for one in filters:
            assumed = one.default_settings.get(sample.setting)
            if isfinite(assumed) and isfinite(sample.value) and sample.value != assumed:
                value, instead = with_unit(sample.setting, sample.value), with_unit(sample.setting, assumed)
                notes.append(
                    f"{one.name} takes the {quantity(sample.setting)} from the log's {sample.name}: "
                    f"{value} instead of {instead}"
                )
    return notes
