"""One inertial sensor as a message reports it: conversion by its unit row, and the checks its numbers must pass."""

from math import sqrt
from typing import Final

from attest_mav.algebra import is_finite_number, largest
from attest_mav.mavlink.decode.units import (
    MAX_ACCEL_MPS2,
    MAX_FIELD_GAUSS,
    MIN_ACCEL_MPS2,
    MIN_FIELD_GAUSS,
    SATURATED_RAW,
    MagnitudeCheck,
    UnitRow,
)
from attest_mav.samples import ImuSample, Sample
from attest_mav.types import EXACT, Quantum, Vec3

STALE_TURN_RAD: Final = 1.0
STALE_TIME_S: Final = 0.5
"""A field that stays the same to the last bit through such a turn and for so long is not being measured."""


class SensorReader:
    """Readings of one sensor to samples, in SI units.

    refusal, field_refusal: why there are no samples, or none with a magnetometer; empty when all is well. refused:
    readings that gave no sample. note: what a user should know about the source.
    """

    def __init__(self, source: str, system: int, component: int, row: UnitRow) -> None:
        self.source: Final = source
        self.system: Final = system
        self.component: Final = component
        self.row: Final = row
        self.refusal = ""
        self.field_refusal = ""
        self.refused = 0
        self.note = row.note
        self._quantum: Final = _quantum(row)
        self._accel_check: Final = MagnitudeCheck(MIN_ACCEL_MPS2, MAX_ACCEL_MPS2, (1.0,))
        self._field_check: Final = MagnitudeCheck(MIN_FIELD_GAUSS, MAX_FIELD_GAUSS, row.field_powers)
        self._held: list[ImuSample] = []
        self._field: Vec3 = (0.0, 0.0, 0.0)
        self._field_t_ns = 0
        self._last_t_ns = 0
        self._turn_rad = 0.0

    def accept(
        self, t_ns: int, rx_ns: int, accel: Vec3, gyro: Vec3, field: Vec3, field_sent: bool, clipped: bool = False
    ) -> list[Sample]:
        """Samples from one reading in the message's own units; none while the start-up checks hold it back, then all.

        field_sent: False when the message says that its magnetometer fields are not new. clipped: True when it says
        that a sensor has reached the end of its range.
        """
        row = self.row
        if not _finite(accel, gyro):
            return self._refuse("a reading is not finite")
        if _is_zero(accel) and _is_zero(gyro):
            return self._refuse("it carries no accelerometer and no gyro (all zero)")
        is_full = row.integer and (_largest(accel) >= SATURATED_RAW or _largest(gyro) >= SATURATED_RAW)
        rates = (gyro[0] * row.gyro, gyro[1] * row.gyro, gyro[2] * row.gyro)
        has_field = row.has_field and self._is_fresh(field, t_ns, rates) and field_sent
        settled = self._accel_check.passed and (self._field_check.passed or not has_field)
        mag: Vec3 | None = None
        if has_field:
            k = row.mag * self._field_check.factor if settled else row.mag
            mag = (field[0] * k, field[1] * k, field[2] * k)
        sample = ImuSample(
            self.source,
            self.system,
            self.component,
            t_ns,
            rx_ns,
            rates,
            (accel[0] * row.accel, accel[1] * row.accel, accel[2] * row.accel),
            mag,
            clipped or is_full,
            self._quantum,
        )
        if not settled:
            return self._start_up(sample)
        self.refusal = ""
        return [sample]

    def _refuse(self, reason: str) -> list[Sample]:
        self.refused += 1
        self.refusal = f"{self.source} of system {self.system}: {reason}"
        return []

    def _is_fresh(self, field: Vec3, t_ns: int, rates: Vec3) -> bool:
        """Whether the fields are a measurement: finite, not zero, and not stuck while the vehicle turns."""
        if field == self._field:
            dt_s = (t_ns - self._last_t_ns) * 1e-9
            if 0.0 < dt_s < STALE_TIME_S:
                self._turn_rad += dt_s * sqrt(rates[0] * rates[0] + rates[1] * rates[1] + rates[2] * rates[2])
        else:
            self._field = field
            self._field_t_ns = t_ns
            self._turn_rad = 0.0
        self._last_t_ns = t_ns
        if _is_zero(field) or not is_finite_number(field[0] + field[1] + field[2]):
            return False
        return self._turn_rad < STALE_TURN_RAD or (t_ns - self._field_t_ns) * 1e-9 < STALE_TIME_S

    def _start_up(self, sample: ImuSample) -> list[Sample]:
        """Offers a sample to the checks that have not passed; what has been held back once they have decided."""
        mag = sample.mag
        field = self._field_check
        if mag is not None and not field.passed:
            field.offer(_norm(mag))
            self._report_field()
        accel = self._accel_check
        self._held.append(sample)
        if not accel.passed:
            accel.offer(_norm(sample.accel))
            if accel.failed:
                self._held.pop(0)
                self._refuse(_expectation("accelerometer", accel, "m/s^2", "0.5 to 2 g"))
            if not accel.passed:
                return []
        self.refusal = ""
        released: list[Sample] = [self._with_judged_field(held) for held in self._held]
        self._held = []
        return released

    def _with_judged_field(self, sample: ImuSample) -> ImuSample:
        """The sample with its field as the check has judged it by now: scaled, or left out."""
        mag = sample.mag
        if mag is not None:
            k = self._field_check.factor
            mag = (mag[0] * k, mag[1] * k, mag[2] * k) if self._field_check.passed else None
        return sample.with_readings(sample.gyro, sample.accel, mag)

    def _report_field(self) -> None:
        """Puts the verdict on the magnetometer into words."""
        field = self._field_check
        self.field_refusal = ""
        if field.failed:
            reason = _expectation("magnetometer", field, "gauss", "a field around a vehicle")
            self.field_refusal = f"{self.source} of system {self.system}: {reason}"
        elif field.passed and field.factor != 1.0:
            fix = f"its magnetometer came {1.0 / field.factor:.0f} times too large and was corrected"
            self.note = f"{self.note}; {fix}" if self.note else fix


def _expectation(sensor: str, check: MagnitudeCheck, unit: str, meaning: str) -> str:
    """The sentence of a refusal: what was read, what was expected."""
    return (
        f"the {sensor} reads {check.median:.6g} {unit} (median of {check.WINDOW}), "
        f"expected {check.low:.3g} to {check.high:.3g} {unit} ({meaning}): wrong units or a faulty sensor"
    )


def _quantum(row: UnitRow) -> Quantum:
    """The resolution of the readings of a row."""
    if row.integer:
        return Quantum(row.gyro, row.accel, row.mag)
    return Quantum(0.0, 0.0, row.mag) if row.integer_field else EXACT


def _finite(accel: Vec3, gyro: Vec3) -> bool:
    return is_finite_number(accel[0] + accel[1] + accel[2] + gyro[0] + gyro[1] + gyro[2])


def _is_zero(v: Vec3) -> bool:
    return v[0] == 0.0 and v[1] == 0.0 and v[2] == 0.0


def _largest(v: Vec3) -> float:
    """Largest absolute component."""
    return largest(abs(v[0]), abs(v[1]), abs(v[2]))


def _norm(v: Vec3) -> float:
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
