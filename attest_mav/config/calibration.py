"""Errors of sensors that flights have shown, as text of a file between flights."""

from collections.abc import Mapping
from typing import Annotated, Final

import msgspec
from msgspec import Meta

from attest_mav.filters.calibration import SensorCalibration, SensorIdentity, UncertainVector
from attest_mav.plausible import is_covariance

DAY_S: Final = 86400.0
MAX_SENSORS: Final = 16
"""Sensors that are kept; the ones that were learned last."""

LARGEST: Final = 100.0
"""m/s^2 or gauss: no sensor is off by more."""
_Component = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
_Vector = tuple[_Component, _Component, _Component]
_Matrix = tuple[_Vector, _Vector, _Vector]


class KeptVector(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A vector in the body with the covariance of its error."""

    mean: _Vector
    """In the unit of the error."""
    covariance: _Matrix
    """In that unit squared."""

    def __post_init__(self) -> None:
        """Refuse a matrix that is no covariance, and a mean that is no number."""
        if not is_covariance(self.covariance):
            raise ValueError("expected a covariance: symmetric, no negative variance")
        if not all(abs(one) <= LARGEST for one in self.mean):
            raise ValueError(f"expected numbers up to {LARGEST:g}")


class KeptSensor(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """By what the autopilot knew a sensor when its errors were learned; None where it had not told."""

    device: int | None = None
    """The autopilot's number of the device."""
    board_orientation: int | None = None
    """The autopilot's number of the rotation from its board to the body."""
    offset: _Vector | None = None
    """What the autopilot's calibration subtracted from the readings, in their unit."""

    @property
    def identity(self) -> SensorIdentity:
        """The same for a filter's calibration."""
        return SensorIdentity(self.device, self.board_orientation, self.offset)


class KeptCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Errors of one inertial sensor."""

    accel_bias: KeptVector
    """m/s^2."""
    hard_iron: KeptVector
    """gauss."""
    learned_unix_s: Annotated[float, Meta(ge=0.0)] | None
    """When they were learned, s since 1970; None where nobody knew the time."""
    accelerometer: KeptSensor | None = None
    """The sensor that has the bias; None where nothing of it was told."""
    magnetometer: KeptSensor | None = None
    """The sensor that has the iron."""

    def at(self, unix_s: float | None) -> SensorCalibration:
        """The errors as a filter takes them at this time of day; a clock that is behind makes them no younger.

        The age is in whole days, so that live flight and replay, whose clocks differ, begin with the same numbers; 0
        where a time is not known.
        """
        bias, iron, learned_s = self.accel_bias, self.hard_iron, self.learned_unix_s
        age_s = 0.0 if unix_s is None or learned_s is None else max(0.0, unix_s - learned_s)
        return SensorCalibration(
            UncertainVector(bias.mean, bias.covariance),
            UncertainVector(iron.mean, iron.covariance),
            DAY_S * (age_s // DAY_S),
            None if self.accelerometer is None else self.accelerometer.identity,
            None if self.magnetometer is None else self.magnetometer.identity,
        )


KeptCalibrations = dict[Annotated[str, Meta(pattern=r"^[1-9]\d{0,2}/[A-Za-z0-9_]{1,40}$")], KeptCalibration]
"""By ``SYSTEM/MESSAGE``: the vehicle's id and the sensor's inertial message."""


class CalibrationFile(msgspec.Struct, frozen=True):
    """A file with the errors of sensors; the state file of a service is one too, and its other keys do not matter."""

    calibrations: KeptCalibrations
    """May be empty."""


def parse_calibrations(text: bytes) -> KeptCalibrations:
    """The errors in a file; ValueError says what is wrong."""
    try:
        return msgspec.json.decode(text, type=CalibrationFile).calibrations
    except RecursionError:
        raise ValueError("nested too deep") from None


def calibrations_text(kept: KeptCalibrations) -> bytes:
    """The errors as the text of a file."""
    return msgspec.json.format(msgspec.json.encode(CalibrationFile(kept))) + b"\n"


def kept_calibration(learned: SensorCalibration, unix_s: float | None) -> KeptCalibration:
    """The form that is kept; ValueError where it holds no numbers. unix_s: when it was learned, None if unknown."""
    bias, iron = learned.accel_bias, learned.hard_iron
    if bias is None or iron is None:
        raise ValueError("expected both errors of a sensor")
    sensors = _kept_sensor(learned.accelerometer), _kept_sensor(learned.magnetometer)
    return KeptCalibration(_kept(bias), _kept(iron), unix_s, *sensors)


def calibrations_of(
    kept: Mapping[str, KeptCalibration], system: int, unix_s: float | None
) -> dict[str, SensorCalibration]:
    """The errors of this vehicle's sensors at this time of day, by inertial message."""
    own = f"{system}/"
    return {name.removeprefix(own): one.at(unix_s) for name, one in kept.items() if name.startswith(own)}


def newest(kept: Mapping[str, KeptCalibration]) -> dict[str, KeptCalibration]:
    """The last ``MAX_SENSORS`` sensors, in the order in which they were learned, whatever the clock said."""
    return dict([*kept.items()][-MAX_SENSORS:])


def with_learned(kept: Mapping[str, KeptCalibration], learned: Mapping[str, KeptCalibration]) -> KeptCalibrations:
    """All of them, those just learned last."""
    return newest({**{name: one for name, one in kept.items() if name not in learned}, **learned})


def _kept(vector: UncertainVector) -> KeptVector:
    return KeptVector(vector.mean, vector.covariance)


def _kept_sensor(one: SensorIdentity) -> KeptSensor | None:
    kept = KeptSensor(one.device, one.orientation, one.offset)
    return None if kept == KeptSensor() else kept
