"""The errors of one lane's sensors by earlier flights, and whether they are still those of the sensors that are there.

The autopilot tells the devices and the offsets of its own calibration, in parameters that may come late, one after the
other, or never. Errors are taken for those of the same sensors while nothing else is told.
"""

from typing import Final

from attest_mav.estimation.events import LaneEventKind
from attest_mav.estimation.sensor_identity import (
    ACCELEROMETER,
    MAGNETOMETER,
    accelerometer_of,
    magnetometer_of,
    of_present_sensors,
)
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.calibration import SensorCalibration, SensorChanges, SensorIdentity

SETTLED_S: Final = 1.0
"""Parameters that were told have to stay so for this long: the three axes of an offset come one by one."""


class LaneCalibration:
    """Gives the filter of a lane its calibration, and follows changes of the sensors."""

    def __init__(self, source: str, vehicle: Vehicle) -> None:
        self.is_used = False
        """Whether the filter goes on from sensor errors of earlier flights."""
        self.errors = ""
        """Those errors in words, as far as they are known."""
        self.has_news = False
        """Whether there is something to tell, or to wait for."""
        self._source: Final = source
        self._vehicle: Final = vehicle
        self._accelerometer: Final = accelerometer_of(source, vehicle)
        self._magnetometer: Final = magnetometer_of(source, vehicle)
        self._of_bias = self._of_iron = SensorIdentity()
        """The sensors whose errors the filter has, as far as they were told."""
        self._quiet_s = 0.0
        self._told = ""
        self._waiting: list[tuple[LaneEventKind, str]] = []

    def begin(self, attitude_filter: AttitudeFilter) -> AttitudeFilter:
        """The filter with the errors by earlier flights, where it begins with them."""
        known = self._vehicle.calibrations.get(self._source)
        self._of_bias = SensorIdentity() if known is None else known.accelerometer
        self._of_iron = SensorIdentity() if known is None else known.magnetometer
        self._take_changes()
        return self.calibrated(attitude_filter)

    def calibrated(self, attitude_filter: AttitudeFilter) -> AttitudeFilter:
        """The filter with the errors by earlier flights, as far as they are known and those of the present sensors."""
        known = self._vehicle.calibrations.get(self._source)
        if known is None:
            return attitude_filter
        left = of_present_sensors(known, self._source, self._vehicle)
        errors = {ACCELEROMETER.error: left.accel_bias, MAGNETOMETER.error: left.hard_iron}
        self.errors = " and ".join([name for name, one in errors.items() if one is not None])
        return attitude_filter.with_calibration(left) if self.errors else attitude_filter

    def settings_changed(self) -> None:
        """The autopilot has told something of itself."""
        self.has_news, self._quiet_s = True, 0.0

    def changes(self, dt_s: float) -> SensorChanges | None:
        """What has become of the sensors while the filter ran, once that is told; None for nothing."""
        self._quiet_s += dt_s
        if self._quiet_s < SETTLED_S:
            return None
        changes = self._take_changes()
        self.has_news = False
        return None if changes.accelerometer is None and changes.magnetometer is None else changes

    def take_events(self) -> list[tuple[LaneEventKind, str]]:
        """The kinds and texts of what is to be told."""
        waiting, self._waiting = self._waiting, []
        return waiting

    def identified(self, learned: SensorCalibration) -> SensorCalibration:
        """The errors that the filter has learned, with the sensors that have them."""
        return SensorCalibration(learned.accel_bias, learned.hard_iron, learned.age_s, self._of_bias, self._of_iron)

    def _take_changes(self) -> SensorChanges:
        """The changes of both sensors since their errors were shown; they are told once."""
        accel = self._accelerometer.change_since(self._of_bias)
        mag = self._magnetometer.change_since(self._of_iron)
        texts: list[str] = []
        if accel is not None:
            texts.append(self._accelerometer.words(self._of_bias, accel))
        if mag is not None:
            texts.append(self._magnetometer.words(self._of_iron, mag))
        self._of_bias = self._accelerometer.settled(self._of_bias)
        self._of_iron = self._magnetometer.settled(self._of_iron)
        changes = SensorChanges(accel, mag)
        if texts and "; ".join(texts) != self._told:
            self._told = "; ".join(texts)
            kind = LaneEventKind.UNCALIBRATED if changes.has_other else LaneEventKind.RECALIBRATED
            self.has_news = True
            self._waiting.append((kind, self._told))
        return changes
