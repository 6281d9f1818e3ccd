"""Sensor errors on a true motion, and a filter run over the readings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from attest_mav.evaluation.motion import Array, Motion, to_body
from attest_mav.evaluation.readings import samples_of
from attest_mav.filters.base import AttitudeFilter, FilterInputs, Start
from attest_mav.samples import ImuSample
from attest_mav.types import North, Quat, Vec3

NO_ERROR: Vec3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SensorErrors:
    """White noise by its 1-sigma per axis and sample, and the size of a constant gyro bias of random sign per axis.

    gyro_noise, gyro_bias: rad/s. accel_noise: m/s^2. mag_noise: in the unit of the field.
    """

    gyro_noise: float = 0.0
    gyro_bias: float = 0.0
    accel_noise: float = 0.0
    mag_noise: float = 0.0


def imu_samples(motion: Motion, field_ned: Vec3, errors: SensorErrors, rng: np.random.Generator) -> list[ImuSample]:
    """Readings of the sensors on that motion in that field.

    The draws do not depend on the sizes of the errors, so runs that differ only in these share their noise.
    """
    shape = motion.rate.shape
    bias = errors.gyro_bias * rng.choice((-1.0, 1.0), 3)
    gyro = motion.rate + bias + errors.gyro_noise * rng.standard_normal(shape)
    accel = motion.force + errors.accel_noise * rng.standard_normal(shape)
    mag = to_body(motion.q_nb, np.array(field_ned)) + errors.mag_noise * rng.standard_normal(shape)
    return samples_of(gyro, accel, mag, motion.dt_s)


def run_filter(chosen: AttitudeFilter, start: Quat, samples: Sequence[ImuSample], dt_s: float) -> Array:
    """Attitudes after each sample, shape (n, 4), from a known start without bias correction."""
    state = chosen.initial(Start(start, NO_ERROR, North.TRUE, samples[0].accel, samples[0].mag))
    inputs = FilterInputs()
    attitudes = []
    for sample in samples:
        state = chosen.step(state, dt_s, sample, inputs)
        attitudes.append(state.q_nb)
    return np.array(attitudes)
