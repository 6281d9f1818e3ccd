"""The lasting errors of one inertial sensor as earlier flights of the same vehicle have shown them.

One flight cannot tell them before its first manoeuvre: while a vehicle stands or hovers, a bias of the accelerometer
looks like a tilt, and hard iron like a heading. The vehicle's earlier flights can. (Errors that are constant over a run
and change from run to run: Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd
ed., section 4.4.1.)
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import norm, square, sub
from attest_mav.matrices import diagonal, mat_add
from attest_mav.record import Record
from attest_mav.types import Mat3, Vec3

UNSURE: Final = 0.5
"""1-sigma of an error that a change of the offset leaves, as a share of the change."""


@mypyc_attr(acyclic=True)  # as samples.Sample
class SensorIdentity(Record):
    """By what an autopilot knows a sensor; None where it has not told.

    device: its number of the device. orientation: its number of the rotation between board and body. offset: what its
    own calibration subtracts from the readings, in their unit.
    """

    def __init__(self, device: int | None = None, orientation: int | None = None, offset: Vec3 | None = None) -> None:
        self.device: Final = device
        self.orientation: Final = orientation
        self.offset: Final = offset

    def completed(self, earlier: "SensorIdentity") -> "SensorIdentity":
        """The same, with what is not told as it was earlier."""
        return SensorIdentity(
            earlier.device if self.device is None else self.device,
            earlier.orientation if self.orientation is None else self.orientation,
            earlier.offset if self.offset is None else self.offset,
        )


@mypyc_attr(acyclic=True)  # as samples.Sample
class SensorChange(Record):
    """What has become of a sensor, as far as that changes its errors.

    is_other: they tell nothing any more: the sensor is another one, turned, or its offset a quite different one.
    offset: the change of the offset, in its unit.
    """

    def __init__(self, is_other: bool, offset: Vec3) -> None:
        self.is_other: Final = is_other
        self.offset: Final = offset


@mypyc_attr(acyclic=True)  # as samples.Sample
class SensorChanges(Record):
    """What has become of the accelerometer and the magnetometer of one inertial message; None for nothing."""

    def __init__(self, accelerometer: SensorChange | None, magnetometer: SensorChange | None) -> None:
        self.accelerometer: Final = accelerometer
        self.magnetometer: Final = magnetometer

    @property
    def has_other(self) -> bool:
        """Whether one of their errors tells nothing any more."""
        return _is_other(self.accelerometer) or _is_other(self.magnetometer)

    @property
    def is_all_other(self) -> bool:
        """Whether none of them does."""
        return _is_other(self.accelerometer) and _is_other(self.magnetometer)


def _is_other(change: SensorChange | None) -> bool:
    return change is not None and change.is_other


def change_between(before: SensorIdentity, now: SensorIdentity, least: float, most: float) -> SensorChange | None:
    """The change of a sensor; None for none that is known.

    least: a change of the offset up to this is none. most: one beyond makes another sensor of it.
    """
    zero: Vec3 = (0.0, 0.0, 0.0)
    change = zero if before.offset is None or now.offset is None else sub(now.offset, before.offset)
    is_other = differ(before.device, now.device) or differ(before.orientation, now.orientation)
    if is_other or norm(change) > most:
        return SensorChange(True, zero)
    return SensorChange(False, change) if norm(change) > least else None


def differ(before: int | None, now: int | None) -> bool:
    """Whether two numbers differ that were told."""
    return before is not None and now is not None and before != now


@mypyc_attr(acyclic=True)  # as samples.Sample
class UncertainVector(Record):
    """A vector that is known with a covariance."""

    def __init__(self, mean: Vec3, covariance: Mat3) -> None:
        self.mean: Final = mean
        self.covariance: Final = covariance
        """Of its error, in the unit of ``mean`` squared; symmetric."""

    def after(self, change: SensorChange | None) -> "UncertainVector | None":
        """This error after a change of its sensor; None where it tells nothing any more.

        Whoever subtracts more leaves a smaller error. Half of the change is uncertain: a calibration changes scale
        factors too.
        """
        if change is None:
            return self
        if change.is_other:
            return None
        unsure = square(UNSURE * norm(change.offset))
        return UncertainVector(sub(self.mean, change.offset), mat_add(self.covariance, diagonal(unsure)))


@mypyc_attr(acyclic=True)  # as samples.Sample
class SensorErrors(Record):
    """Accelerometer bias and hard iron of one sensor."""

    def __init__(self, accel_bias: UncertainVector, hard_iron: UncertainVector) -> None:
        self.accel_bias: Final = accel_bias
        """Body, m/s^2; to be subtracted from the accelerometer."""
        self.hard_iron: Final = hard_iron
        """Body, gauss; to be subtracted from the magnetometer."""


@mypyc_attr(acyclic=True)  # as samples.Sample
class SensorCalibration(Record):
    """The same at the end of the flights that have shown them; None for an error that nothing has shown.

    accelerometer, magnetometer: the sensors that had them.
    """

    def __init__(
        self,
        accel_bias: UncertainVector | None,
        hard_iron: UncertainVector | None,
        age_s: float = 0.0,
        accelerometer: SensorIdentity | None = None,
        magnetometer: SensorIdentity | None = None,
    ) -> None:
        self.accel_bias: Final = accel_bias
        self.hard_iron: Final = hard_iron
        self.age_s: Final = age_s
        """Time since then, s, 0 or more."""
        self.accelerometer: Final = SensorIdentity() if accelerometer is None else accelerometer
        self.magnetometer: Final = SensorIdentity() if magnetometer is None else magnetometer

    def after(self, changes: SensorChanges) -> "SensorCalibration":
        """The calibration after changes of the two sensors."""
        bias, iron = self.accel_bias, self.hard_iron
        return SensorCalibration(
            None if bias is None else bias.after(changes.accelerometer),
            None if iron is None else iron.after(changes.magnetometer),
            self.age_s,
            self.accelerometer,
            self.magnetometer,
        )
