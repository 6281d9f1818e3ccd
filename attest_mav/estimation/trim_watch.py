"""Notices a trim that is changed in flight: the autopilot's attitude moves with it, and is none the worse."""

from math import isfinite, radians
from typing import Final

from attest_mav.estimation.vehicle import Vehicle
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import Setting, VehicleSettings

MOVED_TRIM: Final = radians(1.0)
"""A trim that changes in flight by more is no fine adjustment."""


class TrimWatch:
    """The trims of one flight."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle: Final = vehicle
        self._first: Final[dict[Setting, float]] = {}
        """The trims before they were changed, rad."""

    def take(self, sample: ParameterSample, before: VehicleSettings, agrees: bool) -> bool:
        """Take a setting that the vehicle has; whether trims differ by more than a fine adjustment from those before.

        before: the settings before it. agrees: the attitudes agree without a trim that was not told before, which then
        counts as none.
        """
        setting, first = sample.setting, self._first
        is_new = setting in (Setting.TRIM_X, Setting.TRIM_Y) and self._vehicle.armed and setting not in first
        if is_new and (agrees or isfinite(before.get(setting))):
            first[setting] = before.get_or(setting, 0.0)
        now = self._vehicle.settings
        return any(abs(now.get_or(one, 0.0) - value) > MOVED_TRIM for one, value in first.items())

    def forget(self) -> None:
        """The flight has ended."""
        self._first.clear()
