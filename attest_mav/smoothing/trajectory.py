"""The smoothed attitude at every inertial sample of a flight."""

from dataclasses import dataclass
from math import isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.filters.velocity_aided.lags import LowPassDelay, low_pass_delay_by
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.model import FIELD_LAG, B, S
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import (
    Array,
    from_vector,
    matrices,
    matrices_of_vectors,
    multiply,
    quaternions,
    turned,
    unit,
    vectors_of_matrices,
)
from attest_mav.smoothing.smoother import Result, Smoother
from attest_mav.types import North

CHUNK: Final = 32768
"""Readings whose matrices are held at a time."""


@dataclass(frozen=True)
class Trajectory:
    """Arrays with a row for each inertial sample."""

    t_ns: NDArray[np.int64]
    """Sensor clock, ns."""
    t_s: Array
    """Time from the second sample on, over restarts of that clock too, s."""
    q_nb: Array
    """Body to NED, (n, 4)."""
    rates: Array
    """Of the body, without bias, rad/s, (n, 3)."""
    tilt_sigma: Array
    """1-sigma of the angle between true and smoothed vertical, rad."""
    heading_sigma: Array
    """1-sigma of the rotation about the vertical, rad."""
    north: North
    """The north that headings refer to."""
    noise: str
    """The class of measurement noise under which the flight is most likely."""


def smoothed_trajectory(readings: Recording, parameters: FlightParameters) -> Trajectory:
    """Smooth a flight. parameters: of the live filter, with the vehicle's settings in them."""
    result = Smoother(readings, parameters).result()
    return at_samples(readings, result, parameters)


def at_samples(readings: Recording, result: Result, parameters: FlightParameters) -> Trajectory:
    """The attitudes between the nodes, turned on by the low-pass's delay as those of the live filter are."""
    intervals, smoothed = result.intervals, result.smoothed
    node_s = readings.t_s[intervals.nodes]
    before = np.clip(np.searchsorted(node_s, readings.t_s, side="right") - 1, 0, len(node_s) - 2)
    share = np.minimum(1.0, (readings.t_s - node_s[before]) / intervals.dt_s[before])
    low_passed = _low_passed(result, before, share)
    bias, scale = smoothed.x[before][:, B], smoothed.x[before][:, S]
    rates = readings.gyro - bias - scale * readings.gyro
    delay = _low_pass_delay(result, readings, parameters)
    q_nb, along = _turned_on(readings, low_passed, rates, delay)
    variances = smoothed.spread[:, :3]
    spread = variances[before] + share[:, np.newaxis] * (variances[before + 1] - variances[before])
    tilt = np.sqrt(spread[:, 0] + spread[:, 1] + along[:, 0] ** 2 + along[:, 1] ** 2)
    heading = np.sqrt(spread[:, 2] + along[:, 2] ** 2)
    north = North.TRUE if isfinite(readings.declination) else North.MAGNETIC
    return Trajectory(readings.t_ns, readings.t_s, q_nb, rates, tilt, heading, north, result.noise.name)


def _low_passed(result: Result, before: NDArray[np.int64], share: Array) -> Array:
    """The attitude that the low-passed sensors see at each reading. before: the node before it; share: of its interval.

    The turn that the gyro misses from one node to the next is spread over the time between them.
    """
    intervals, attitude = result.intervals, result.smoothed.attitude
    predicted = np.matmul(attitude[:-1], intervals.turn)
    missed = vectors_of_matrices(np.matmul(np.swapaxes(predicted, 1, 2), attitude[1:]))
    missed[intervals.is_gap] = 0.0
    out = np.empty((len(before), 4))
    for begin in range(0, len(before), CHUNK):
        rows = slice(begin, begin + CHUNK)
        node = before[rows]
        carried = np.matmul(attitude[node], matrices(intervals.turn_at[rows]))
        closing = matrices_of_vectors(share[rows, np.newaxis] * missed[node])
        out[rows] = quaternions(np.matmul(carried, closing))
    out[-1] = quaternions(attitude[-1])
    return out


def _low_pass_delay(result: Result, readings: Recording, parameters: FlightParameters) -> LowPassDelay:
    """The group delay of the low-pass, by the lag of the magnetometer where its corner is only assumed."""
    usual_s = float(np.median(np.diff(readings.t_s)))
    last = result.smoothed
    return low_pass_delay_by(float(last.x[-1, FIELD_LAG]), float(last.spread[-1, FIELD_LAG]), usual_s, parameters)


def _turned_on(readings: Recording, q_nb: Array, rates: Array, delay: LowPassDelay) -> tuple[Array, Array]:
    """The attitudes of now, and the rotation in NED along which an error of the delay acts times its sigma, rad."""
    step_s = np.diff(readings.t_s, prepend=readings.t_s[:1] - 1.0)
    acceleration = np.diff(readings.gyro, axis=0, prepend=readings.gyro[:1]) / step_s[:, np.newaxis]
    for stretch in readings.stretches:
        acceleration[stretch.begin] = 0.0
    lag_s = delay.delay_s
    now = unit(multiply(q_nb, from_vector(lag_s * rates + 0.5 * lag_s**2 * acceleration)))
    along = delay.sigma_s * turned(matrices(now), rates + lag_s * acceleration)
    return now, along
