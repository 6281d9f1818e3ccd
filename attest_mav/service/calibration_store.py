"""Errors of sensors while a service runs: taken from the flights, and given to the next ones."""

from collections.abc import Mapping
from typing import Final

from attest_mav.config.calibration import (
    KeptCalibration,
    KeptCalibrations,
    calibrations_of,
    kept_calibration,
    newest,
)
from attest_mav.filters.calibration import SensorCalibration


class CalibrationStore:
    """The errors of the sensors of all vehicles that a service has followed.

    is_used: False gives and takes none, and keeps what is there.
    """

    def __init__(self, is_used: bool) -> None:
        self.kept: KeptCalibrations = {}
        self._is_used: Final = is_used
        self._unix_s = 0.0

    def restore(self, kept: Mapping[str, KeptCalibration], unix_s: float) -> None:
        """Go on from what was kept before a restart."""
        self.kept = newest(kept)
        self._unix_s = unix_s

    def set_time(self, unix_s: float) -> None:
        """Take the time of day."""
        self._unix_s = unix_s

    def of_vehicle(self, system: int) -> dict[str, SensorCalibration]:
        """The errors of a vehicle's sensors, by inertial message."""
        return calibrations_of(self.kept, system, self._unix_s) if self._is_used else {}

    def take(self, system: int, learned: Mapping[str, SensorCalibration]) -> None:
        """Take what the present flight has shown of a vehicle's sensors."""
        if learned and self._is_used:
            fresh = {f"{system}/{name}": kept_calibration(one, self._unix_s) for name, one in learned.items()}
            self.kept = newest(self.kept | fresh)
