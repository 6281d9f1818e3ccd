"""White noise of gyro and accelerometer over a whole recording, as the live filter measures it in flight.

Mean products of second differences, see ``attest_mav.filters.velocity_aided.white_noise``, here over blocks of samples
and with their median: a manoeuvre or a gap changes few of them.
"""

from dataclasses import replace
from math import sqrt
from typing import Final

import numpy as np

from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.readings import Recording
from attest_mav.smoothing.rotations import Array

BLOCK: Final = 500
"""Samples of a block."""
ACCEL_NOISE: Final = 0.035
"""m/s per root s. Least noise of the accelerometer; the live filter's allows for what it has not seen yet."""


def with_white_noise(parameters: FlightParameters, recording: Recording) -> FlightParameters:
    """The parameters with the noise that the readings show; of the gyro where that is larger."""
    if len(recording.t_s) < BLOCK:
        return parameters
    dt_s = float(np.median(np.diff(recording.t_s)))
    return replace(
        parameters,
        gyro_noise=max(parameters.gyro_noise, sqrt(white_variance(recording.gyro) * dt_s)),
        accel_noise=max(min(parameters.accel_noise, ACCEL_NOISE), sqrt(white_variance(recording.accel) * dt_s)),
    )


def white_variance(readings: Array) -> float:
    """Variance of the white noise of each axis of at least ``BLOCK`` readings, one a row; 0 where motion hides it."""
    difference = np.diff(readings, n=2, axis=0)
    axes = difference.shape[1]
    by_one = -np.einsum("ij,ij->i", difference[2:], difference[1:-1]) / (4.0 * axes)
    by_two = np.einsum("ij,ij->i", difference[2:], difference[:-2]) / axes
    blocks = max(1, len(by_one) // BLOCK)
    one, two = (np.array([part.mean() for part in np.array_split(each, blocks)]) for each in (by_one, by_two))
    return float(np.median(np.maximum(0.0, np.minimum(one, two))))
