"""Each reading with the step that ends at it: its mean rate, and the noise that hides between two samples.

Each step is that of ``velocity_aided.prediction``.
"""

from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.imu_memory import MAX_STEP_RATIO
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import (
    FAST_TURN,
    HELD_SAMPLES,
    OTHER_AXES,
    SATURATED_ACCEL,
    SATURATED_RATE,
)
from attest_mav.filters.velocity_aided.reset import UNSEEN_RATE
from attest_mav.smoothing.held_largest import HeldLargest
from attest_mav.smoothing.readings import Readings, Recording
from attest_mav.smoothing.rotations import Array
from attest_mav.smoothing.tables import Rows, Table

STEP: Final = np.dtype([("dt_s", "<f8"), ("rate", "<f8", 3), ("turn_noise", "<f8"), ("unseen_accel", "<f8", 3)])
MEMORY: Final = 2
"""Readings before a step that its second difference reaches back to."""


@dataclass(frozen=True)
class Steps:
    """Consecutive readings with the step that ends at each."""

    dt_s: Array
    """0 at the first reading of a stretch."""
    rate: Array
    """Mean rate of the step as the gyro shows it, rad/s."""
    turn_noise: Array
    """Variance of the attitude that the step adds about each axis, beside the part that grows with the rate, rad^2."""
    unseen_accel: Array
    """Variance of the velocity that hides between two samples, over dt squared, per axis of the body, (m/s^2)^2."""


def steps_of(rows: Rows) -> Steps:
    """The columns of a table of steps."""
    return Steps(*(np.ascontiguousarray(rows[one.name]) for one in fields(Steps)))


def all_steps(recording: Recording, parameters: FlightParameters) -> Table:
    """The steps of all readings."""
    steps = recording.scratch.table(STEP)
    stepping = _Stepping(recording, parameters)
    for first, end in recording.readings.runs():
        steps.write(first, stepping.rows(first, end))
    return steps


class _Stepping:
    """Makes the steps of a recording, a run of readings after the other."""

    def __init__(self, recording: Recording, parameters: FlightParameters) -> None:
        self._recording, self._parameters = recording, parameters
        self._begins = np.array([stretch.begin for stretch in recording.stretches])
        hold_s = max(parameters.aliasing_hold_s, HELD_SAMPLES * recording.usual_s)
        self._bend, self._accel = HeldLargest(hold_s), HeldLargest(hold_s)

    def rows(self, first: int, end: int) -> Rows:
        """The steps of the next readings."""
        begin = max(first - MEMORY, 0)
        readings = self._recording.rows(begin, end)
        at_begin = self._begins[(self._begins >= begin) & (self._begins < end)] - begin
        dt_s, gyro_change, accel_change = (
            _changes(one, at_begin) for one in (readings.t_s, readings.gyro, readings.accel)
        )
        gyro_bend, accel_bend = gyro_change - _before(gyro_change), accel_change - _before(accel_change)
        before_s = _before(dt_s)
        even = (MAX_STEP_RATIO * dt_s > before_s) & (before_s > dt_s / MAX_STEP_RATIO)
        rate = readings.gyro - 0.5 * gyro_change - np.where(even[:, np.newaxis], gyro_bend / 12.0, 0.0)
        return self._filled(first - begin, readings, dt_s, rate, gyro_bend, accel_bend)

    def _filled(
        self, new: int, readings: Readings, dt_s: Array, rate: Array, gyro_bend: Array, accel_bend: Array
    ) -> Rows:
        """The rows from number ``new`` on."""
        parameters = self._parameters
        bend = self._bend.take(self._hidden_rate(readings, dt_s, gyro_bend)[new:], readings.t_s[new:])
        accel = np.where(readings.saturated[:, np.newaxis], SATURATED_ACCEL, np.abs(accel_bend))
        accel = self._accel.take(accel[new:], readings.t_s[new:])
        out = np.empty(len(bend), STEP)
        out["dt_s"], out["rate"] = dt_s[new:], rate[new:]
        unseen_turn = UNSEEN_RATE * readings.gap_s[new:]
        out["turn_noise"] = (parameters.gyro_aliasing * bend * dt_s[new:]) ** 2 + unseen_turn**2
        least = OTHER_AXES**2 * (accel**2).sum(axis=1, keepdims=True)
        out["unseen_accel"] = parameters.accel_aliasing**2 * np.maximum(accel**2, least)
        return out

    def _hidden_rate(self, readings: Readings, dt_s: Array, gyro_bend: Array) -> Array:
        """The second difference of the gyro that its low-pass lets hide between samples, rad/s."""
        parameters = self._parameters
        fourth = (parameters.low_pass_hz * dt_s) ** 4  # as attest_mav.low_pass.aliased_share
        share = fourth / (1.0 + fourth) if parameters.low_pass_hz > 0.0 else np.ones_like(dt_s)
        bend = share * np.sqrt((gyro_bend**2).sum(axis=1))
        rate = np.sqrt((readings.gyro**2).sum(axis=1))
        out: Array = np.where(readings.saturated, np.where(rate > FAST_TURN, rate, SATURATED_RATE), bend)
        return out


def _changes(values: Array, begins: Array) -> Array:
    """Each row less its predecessor; zero in the first row and at the beginnings of stretches."""
    out = np.diff(values, axis=0, prepend=values[:1])
    out[begins] = 0.0
    return out


def _before(values: Array) -> Array:
    """Each row's predecessor; zero before the first."""
    out = np.zeros_like(values)
    out[1:] = values[:-1]
    return out
