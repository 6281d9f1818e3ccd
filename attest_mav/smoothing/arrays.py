"""Recordings that are arrays already, for example of a sensor held in the hand, through the smoother."""

from collections.abc import Iterator
from math import nan

import numpy as np

from attest_mav.errors import UsageError
from attest_mav.filters.base import FilterInputs, FilterState, Start
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.smoothing.noise import with_wide_priors
from attest_mav.smoothing.readings import Recorder
from attest_mav.smoothing.rotations import Array
from attest_mav.smoothing.trajectory import Trajectory, smoothed_trajectory
from attest_mav.types import North, Vec3, VelocityOrigin

SOURCE = "array"


def smooth_arrays(
    t_s: Array,
    gyro: Array,
    accel: Array,
    mag: Array | None = None,
    velocity: Array | None = None,
    declination: float = nan,
    parameters: FlightParameters | None = None,
) -> Trajectory:
    """Smooth a recording. Body axes are forward, right, down; every array has a row for each instant.

    t_s: (n,), s, growing. gyro: (n, 3), rad/s. accel: (n, 3), specific force, m/s^2, (0, 0, -g) at rest and level.
    mag: (n, 3), gauss; a row of NaN, or one that repeats the row before, is no new reading. velocity: (n, 3), north,
    east, down, m/s, a row of NaN where there is none; without any the sensor is taken to stay in place in the mean.
    declination: rad, east positive; NaN leaves headings magnetic. parameters: of the sensors, as for the flight
    filter; None for its defaults with wide priors.

    The trajectory begins with the second row. UsageError for arrays that do not fit together.
    """
    _check(t_s, gyro, accel, mag, velocity)
    chosen = with_wide_priors(FlightParameters()) if parameters is None else parameters
    recorder = Recorder(chosen)
    zero: Vec3 = (0.0, 0.0, 0.0)
    state: FilterState = recorder.initial(Start((1.0, 0.0, 0.0, 0.0), zero, North.RELATIVE, zero, None, at_rest=False))
    fixes = _fixes(t_s, velocity)
    before_s = float(t_s[0])
    next(fixes)
    for sample, fix in zip(_samples(t_s, gyro, accel, mag), fixes, strict=True):
        now_s = sample.t_ns * 1e-9
        inputs = FilterInputs(declination=declination, velocity=fix, zero_mean_velocity=velocity is None)
        state = recorder.step(state, now_s - before_s, sample, inputs)
        before_s = now_s
    readings = recorder.readings()
    if readings is None:
        raise UsageError("the arrays show no attitude to begin with; expected some seconds of plausible readings")
    return smoothed_trajectory(readings, chosen)


def _check(t_s: Array, gyro: Array, accel: Array, mag: Array | None, velocity: Array | None) -> None:
    """Refuse arrays that do not fit together."""
    if t_s.ndim != 1 or len(t_s) < 2 or not bool(np.all(np.diff(t_s) > 0.0)):
        raise UsageError("t_s: expected one dimension with two or more times that grow")
    vectors = {"gyro": gyro, "accel": accel, "mag": mag, "velocity": velocity}
    for name, array in vectors.items():
        if array is not None and array.shape != (len(t_s), 3):
            raise UsageError(f"{name} has the shape {array.shape}; expected {(len(t_s), 3)}, a row for each time")


def _samples(t_s: Array, gyro: Array, accel: Array, mag: Array | None) -> Iterator[ImuSample]:
    """All rows but the first."""
    for row in range(1, len(t_s)):
        t_ns = round(1e9 * float(t_s[row]))
        field = None if mag is None or not np.isfinite(mag[row]).all() else _vector(mag[row])
        yield ImuSample(SOURCE, 0, 0, t_ns, t_ns, _vector(gyro[row]), _vector(accel[row]), field)


def _fixes(t_s: Array, velocity: Array | None) -> Iterator[VelocitySample | None]:
    """The newest velocity at each row, None before the first."""
    newest: VelocitySample | None = None
    for row in range(len(t_s)):
        if velocity is not None and np.isfinite(velocity[row]).all():
            t_ns = round(1e9 * float(t_s[row]))
            v_ned = _vector(velocity[row])
            newest = VelocitySample(
                SOURCE, 0, 0, t_ns, t_ns, v_ned, vertical_known=True, origin=VelocityOrigin.RECEIVER
            )
        yield newest


def _vector(row: Array) -> Vec3:
    x, y, z = row.tolist()
    return x, y, z
