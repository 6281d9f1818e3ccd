"""Errors of sensors while a service runs: taken from the flights, and given to the next ones."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Final

from attest_mav.config.calibration import (
    KeptCalibration,
    KeptCalibrations,
    KeptVector,
    calibrations_of,
    kept_calibration,
    newest,
    with_learned,
)
from attest_mav.filters.calibration import SensorCalibration

NEWS: Final = 0.1
"""1. Smallest change of an estimate that is kept: share of its sigma, and of its variance."""


class CalibrationStore:
    """The errors of the sensors of all vehicles that a service has followed. A small change is none, and not kept.

    is_used: False gives and takes none, and keeps what is there.
    """

    def __init__(self, is_used: bool) -> None:
        self.kept: KeptCalibrations = {}
        self.given: KeptCalibrations = {}
        """All errors as they were when a vehicle was last given its own."""
        self._is_used: Final = is_used
        self._unix_s: float | None = None

    def restore(self, kept: Mapping[str, KeptCalibration], unix_s: float) -> None:
        """Go on from what was kept before a restart."""
        self.kept = newest(kept)
        self._unix_s = unix_s

    def set_time(self, unix_s: float) -> None:
        """Take the time of day."""
        self._unix_s = unix_s

    def of_vehicle(self, system: int) -> dict[str, SensorCalibration]:
        """The errors of a vehicle's sensors, by inertial message."""
        self.given = self.kept if self._is_used else {}
        return calibrations_of(self.given, system, self._unix_s)

    def take(self, system: int, learned: Mapping[str, SensorCalibration]) -> None:
        """Take what the present flight has shown of a vehicle's sensors."""
        if not self._is_used:
            return
        for name, one in learned.items():
            key = f"{system}/{name}"
            with suppress(ValueError):  # an estimate that is no number teaches nothing
                fresh = kept_calibration(one, self._unix_s)
                if key not in self.kept or _is_news(self.kept[key], fresh):
                    self.kept = with_learned(self.kept, {key: fresh})

    def drop(self, system: int, names: Iterable[str]) -> None:
        """Forget the errors of sensors that a flight has refuted."""
        gone = {f"{system}/{name}" for name in names}
        if self._is_used and not gone.isdisjoint(self.kept):
            self.kept = {key: one for key, one in self.kept.items() if key not in gone}


def _is_news(before: KeptCalibration, now: KeptCalibration) -> bool:
    """Whether an estimate has moved by a tenth of its sigma, a variance by a tenth, or the sensor is another one."""
    if (before.accelerometer, before.magnetometer) != (now.accelerometer, now.magnetometer):
        return True
    return _has_changed(before.accel_bias, now.accel_bias) or _has_changed(before.hard_iron, now.hard_iron)


def _has_changed(before: KeptVector, now: KeptVector) -> bool:
    for axis in range(3):
        old, new = before.covariance[axis][axis], now.covariance[axis][axis]
        moved = now.mean[axis] - before.mean[axis]
        if abs(new - old) > NEWS * old or moved * moved > NEWS * NEWS * new:
            return True
    return False
