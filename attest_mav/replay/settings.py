"""Notes on settings of the vehicle that a filter takes from the log."""

from collections.abc import Iterable
from math import isfinite

from attest_mav.filters.base import AttitudeFilter
from attest_mav.mavlink.decode.autopilot_parameters import quantity, with_unit
from attest_mav.types import ParameterSample


def setting_notes(parameters: Iterable[ParameterSample], filters: Iterable[AttitudeFilter]) -> list[str]:
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
