"""White noise of gyro and accelerometer over a whole recording, as the live filter measures it in flight.

Mean products of second differences, see ``attest_mav.filters.velocity_aided.white_noise``, here over blocks of samples
and with their median: a manoeuvre or a gap changes few of them.
"""

from dataclasses import replace
from itertools import pairwise
from math import sqrt
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import Array
from attest_mav.smoothing.tables import Table

BLOCK: Final = 500
"""Samples of a block."""
REACH: Final = 4
"""Readings that a product reaches back to."""
ACCEL_NOISE: Final = 0.035
"""m/s per root s. Least noise of the accelerometer; the live filter's allows for what it has not seen yet."""


def with_white_noise(parameters: FlightParameters, recording: Recording) -> FlightParameters:
    """The parameters with the noise that the readings show; of the gyro where that is larger."""
    if len(recording.readings) < BLOCK:
        return parameters
    gyro, accel = (white_variance(recording.readings, name) for name in ("gyro", "accel"))
    return replace(
        parameters,
        gyro_noise=max(parameters.gyro_noise, sqrt(gyro * recording.usual_s)),
        accel_noise=max(min(parameters.accel_noise, ACCEL_NOISE), sqrt(accel * recording.usual_s)),
    )


def white_variance(readings: Table, name: str) -> float:
    """Variance of the white noise of each axis of at least ``BLOCK`` readings, a column; 0 where motion hides it."""
    products = len(readings) - REACH
    blocks = max(1, products // BLOCK)
    length, longer = divmod(products, blocks)
    ends = [number * length + min(number, longer) for number in range(blocks + 1)]
    return float(np.median([_of_block(readings.rows(begin, end + REACH)[name]) for begin, end in pairwise(ends)]))


def _of_block(readings: Array) -> float:
    """That of one block, whose products reach over ``REACH`` readings more."""
    difference = np.diff(readings, n=2, axis=0)
    axes = difference.shape[1]
    by_one = -np.einsum("ij,ij->i", difference[2:], difference[1:-1]) / (4.0 * axes)
    by_two = np.einsum("ij,ij->i", difference[2:], difference[:-2]) / axes
    return max(0.0, float(min(by_one.mean(), by_two.mean())))
