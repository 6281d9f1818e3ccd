"""Errors of sensors that flights have shown, as text of a file between flights."""

from collections.abc import Mapping
from typing import Annotated, Final

import msgspec
from msgspec import Meta

from attest_mav.filters.calibration import SensorCalibration, UncertainVector
from attest_mav.plausible import is_covariance

DAY_S: Final = 86400.0
MAX_SENSORS: Final = 16
"""Sensors that are kept; the ones that were learned last."""

_Component = Annotated[float, Meta(ge=-100.0, le=100.0)]
_Vector = tuple[_Component, _Component, _Component]
_Matrix = tuple[_Vector, _Vector, _Vector]


class KeptVector(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A vector in the body with the covariance of its error."""

    mean: _Vector
    """In the unit of the error."""
    covariance: _Matrix
    """In that unit squared."""

    def __post_init__(self) -> None:
        """Refuse a matrix that is no covariance."""
        if not is_covariance(self.covariance):
            raise ValueError("expected a covariance: symmetric, no negative variance")


class KeptCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Errors of one inertial sensor."""

    accel_bias: KeptVector
    """m/s^2."""
    hard_iron: KeptVector
    """gauss."""
    learned_unix_s: Annotated[float, Meta(ge=0.0)]
    """When they were learned, s since 1970."""

    def at(self, unix_s: float) -> SensorCalibration:
        """The errors as a filter takes them at this time of day; a clock that is behind makes them no younger.

        The age is in whole days, so that live flight and replay, whose clocks differ, begin with the same numbers.
        """
        bias, iron = self.accel_bias, self.hard_iron
        return SensorCalibration(
            UncertainVector(bias.mean, bias.covariance),
            UncertainVector(iron.mean, iron.covariance),
            DAY_S * max(0.0, (unix_s - self.learned_unix_s) // DAY_S),
        )


KeptCalibrations = dict[Annotated[str, Meta(pattern=r"^\d{1,3}/[A-Z0-9_]{1,40}$")], KeptCalibration]
"""By ``SYSTEM/MESSAGE``: the vehicle's id and the sensor's inertial message."""


class CalibrationFile(msgspec.Struct, frozen=True):
    """A file with the errors of sensors; the state file of a service is one too, and its other keys do not matter."""

    calibrations: KeptCalibrations
    """May be empty."""


def parse_calibrations(text: bytes) -> KeptCalibrations:
    """The errors in a file; ValueError says what is wrong."""
    return msgspec.json.decode(text, type=CalibrationFile).calibrations


def calibrations_text(kept: KeptCalibrations) -> bytes:
    """The errors as the text of a file."""
    return msgspec.json.format(msgspec.json.encode(CalibrationFile(kept))) + b"\n"


def kept_calibration(learned: SensorCalibration, unix_s: float) -> KeptCalibration:
    """The form that is kept. unix_s: when it was learned."""
    return KeptCalibration(_kept(learned.accel_bias), _kept(learned.hard_iron), unix_s)


def calibrations_of(kept: Mapping[str, KeptCalibration], system: int, unix_s: float) -> dict[str, SensorCalibration]:
    """The errors of this vehicle's sensors at this time of day, by inertial message."""
    own = f"{system}/"
    return {name.removeprefix(own): one.at(unix_s) for name, one in kept.items() if name.startswith(own)}


def newest(kept: Mapping[str, KeptCalibration]) -> dict[str, KeptCalibration]:
    """The sensors that were learned last, at most ``MAX_SENSORS`` of them."""
    ordered = sorted(kept.items(), key=lambda item: item[1].learned_unix_s)
    return dict(ordered[-MAX_SENSORS:])


def _kept(vector: UncertainVector) -> KeptVector:
    return KeptVector(vector.mean, vector.covariance)
