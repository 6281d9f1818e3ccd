"""By what the autopilot knows a sensor, out of its settings; what has become of the sensor since, and that in words."""

from math import isfinite
from typing import Final

from attest_mav.algebra import sub
from attest_mav.estimation.vehicle import Vehicle
from attest_mav.filters.calibration import (
    SensorCalibration,
    SensorChange,
    SensorChanges,
    SensorIdentity,
    change_between,
    differ,
)
from attest_mav.record import Record
from attest_mav.types import Vec3
from attest_mav.vehicle_settings import (
    ACCELEROMETERS,
    MAGNETOMETERS,
    SENSOR_NUMBERS,
    SensorSettings,
    Setting,
    VehicleSettings,
    quantity,
)


class SensorRule(Record):
    """What counts as a change of a sensor. error: its error in words. least, most: see ``change_between``.

    is_turned_with_board: its offset applies before the rotation from the board to the body.
    """

    def __init__(self, error: str, least: float, most: float, is_turned_with_board: bool) -> None:
        self.error: Final = error
        self.least: Final = least
        self.most: Final = most
        self.is_turned_with_board: Final = is_turned_with_board


ACCELEROMETER: Final = SensorRule("accelerometer bias", 0.04, 0.5, is_turned_with_board=True)
"""m/s^2: errors of earlier flights are no better known at a start than the least; few sensors are off by the most."""
MAGNETOMETER: Final = SensorRule("hard iron", 0.003, 0.1, is_turned_with_board=False)
"""gauss."""


class KnownSensor:
    """One of the sensors of an inertial message, as the autopilot tells it. settings: None where nothing tells it."""

    def __init__(self, rule: SensorRule, settings: SensorSettings | None, vehicle: Vehicle) -> None:
        self._rule: Final = rule
        self._settings: Final = settings
        self._vehicle: Final = vehicle

    @property
    def present(self) -> SensorIdentity:
        """The sensor by the settings as they are now. A device that is 0 is not told: it was not found."""
        settings = self._settings
        if settings is None:
            return SensorIdentity()
        known = self._vehicle.settings
        return SensorIdentity(
            _number(known, settings.device) or None,
            _number(known, Setting.BOARD_ORIENTATION),
            _vector(known, settings.offset),
        )

    def change_since(self, before: SensorIdentity) -> SensorChange | None:
        """What has become of a sensor whose error was shown before; None for nothing that is known."""
        rule, now = self._rule, self.present
        change = change_between(before, now, rule.least, rule.most)
        if change is not None and rule.is_turned_with_board and now.orientation:
            return SensorChange(True, change.offset)
        return change

    def settled(self, before: SensorIdentity) -> SensorIdentity:
        """The sensor that has the error from now on; small changes of its offset add up."""
        now, change = self.present, self.change_since(before)
        if change is not None and change.is_other:
            return now
        offset = before.offset if change is None and before.offset is not None else now.offset
        return SensorIdentity(now.device, now.orientation, offset).completed(before)

    def words(self, before: SensorIdentity, change: SensorChange) -> str:
        """The change in words: the parameter, what it tells and has told, and what follows."""
        follows = "counts as unknown" if change.is_other else "is taken less that change"
        return f"{self._difference(before)}: the {self._rule.error} of before {follows}"

    def _difference(self, before: SensorIdentity) -> str:
        now, settings = self.present, self._settings
        if settings is None:
            return ""
        if differ(before.device, now.device):
            return f"{self._name(settings.device)} is {now.device} instead of {before.device}"
        if differ(before.orientation, now.orientation):
            return f"{self._name(Setting.BOARD_ORIENTATION)} is {now.orientation} instead of {before.orientation}"
        if before.offset is None or now.offset is None:
            return ""
        change = sub(now.offset, before.offset)
        axis = max(range(3), key=lambda one: abs(change[one]))
        instead = f"{now.offset[axis]:.4g} {settings.unit} instead of {before.offset[axis]:.4g}"
        return f"{self._name(settings.offset[axis])} subtracts {instead}"

    def _name(self, setting: Setting) -> str:
        return self._vehicle.parameters.get(setting, quantity(setting))


def accelerometer_of(source: str, vehicle: Vehicle) -> KnownSensor:
    """The accelerometer of an inertial message."""
    number = SENSOR_NUMBERS.get(source)
    return KnownSensor(ACCELEROMETER, None if number is None else ACCELEROMETERS[number], vehicle)


def magnetometer_of(source: str, vehicle: Vehicle) -> KnownSensor:
    """The magnetometer of an inertial message."""
    number = SENSOR_NUMBERS.get(source)
    return KnownSensor(MAGNETOMETER, None if number is None else MAGNETOMETERS[number], vehicle)


def of_present_sensors(known: SensorCalibration, source: str, vehicle: Vehicle) -> SensorCalibration:
    """The calibration of an inertial message, as far as it is that of the sensors that are there now."""
    accelerometer, magnetometer = accelerometer_of(source, vehicle), magnetometer_of(source, vehicle)
    return known.after(
        SensorChanges(accelerometer.change_since(known.accelerometer), magnetometer.change_since(known.magnetometer))
    )


def _number(known: VehicleSettings, setting: Setting) -> int | None:
    value = known.get(setting)
    return int(value) if isfinite(value) else None


def _vector(known: VehicleSettings, settings: tuple[Setting, Setting, Setting]) -> Vec3 | None:
    x, y, z = known.get(settings[0]), known.get(settings[1]), known.get(settings[2])
    return (x, y, z) if isfinite(x) and isfinite(y) and isfinite(z) else None
