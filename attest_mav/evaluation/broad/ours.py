"""Our filters over a trial: with the magnetometer (9D) and without it (6D).

The sensor's axes are the body's. The accelerometer of the data set shows specific force, as ours does, so that no sign
changes; microtesla become gauss. The message name is none that carries integers, and nothing is dequantised.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from attest_mav.algebra import scale
from attest_mav.errors import UnreadableDataError
from attest_mav.estimation.alignment import ecompass
from attest_mav.evaluation.broad.trial import Trial
from attest_mav.evaluation.motion import Array, multiply
from attest_mav.filters.base import AttitudeFilter, FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import BARE_SENSOR
from attest_mav.samples import ImuSample
from attest_mav.smoothing.recorder import Recorder
from attest_mav.smoothing.trajectory import smoothed_trajectory
from attest_mav.types import Vec3

START_S: Final = 0.1
"""The readings of so long are averaged for the start; all trials begin at rest."""

GAUSS_PER_MICROTESLA: Final = 0.01

PAPER_BETA: Final = 0.08
"""rad/s: the best of the paper's filter here with the magnetometer; without it half of that is."""


def printed(with_mag: bool) -> GradientDescent:
    """The gradient-descent filter as in its paper, which knows no limits of the accelerometer."""
    return GradientDescent(beta=PAPER_BETA if with_mag else 0.5 * PAPER_BETA, min_accel_g=0.0, max_accel_g=100.0)


def with_options(_with_mag: bool) -> GradientDescent:
    """The gradient-descent filter with its options, as docs/filters/gradient-descent.md recommends them."""
    return GradientDescent(beta=0.02, rest_bias=True, accel_time_s=2.5, heading_rate=0.01, field_gate=True)


SENSOR: Final = replace(BARE_SENSOR, low_pass_hz=64.0, mag_delay_s=0.0135, hard_iron=0.002)
"""Parameters of the flight filter for the data set's sensor: inertial readings 3.5 ms late, as behind a low-pass of
64 Hz, magnetometer readings 10 ms later. Over all directions its strength shows iron of at most 2 to 3 mG."""


def in_place() -> VelocityAided:
    """The flight filter without a velocity; nothing says that the sensor is under way, so it stays in place."""
    return VelocityAided(SENSOR)


def attitudes(chosen: AttitudeFilter, trial: Trial, with_mag: bool) -> Array:
    """Attitude after each sample, sensor to ENU, shape (n, 4); before a filter is aligned, what it shows."""
    samples = imu_samples(trial, with_mag)
    state = chosen.initial(start(trial, with_mag))
    inputs = FilterInputs(declination=0.0)
    dt_s = 1.0 / trial.rate_hz
    rows = np.empty((len(trial.gyr), 4))
    rows[0] = state.q_nb
    next(samples)  # the start is its attitude
    for number, sample in enumerate(samples, 1):
        state = chosen.step(state, dt_s, sample, inputs)
        rows[number] = state.q_nb
    return to_enu(rows)


def smoothed(trial: Trial, with_mag: bool) -> Array:
    """Attitude at each sample by the smoother, sensor to ENU, shape (n, 4); the first row repeats the second."""
    recorder = Recorder(SENSOR)
    attitudes(recorder, trial, with_mag)
    recording = recorder.recording()
    if recording is None:
        raise UnreadableDataError(f"{trial.name}: no attitude to begin with; expected readings of a sensor at rest")
    q_nb = smoothed_trajectory(recording, SENSOR).q_nb
    return to_enu(np.vstack((q_nb[:1], q_nb)))


def start(trial: Trial, with_mag: bool) -> Start:
    """Where a filter begins: the compass of the first readings, and no gyro bias."""
    first = slice(0, max(1, round(START_S * trial.rate_hz)))
    accel = _mean(trial.acc[first])
    mag = scale(_mean(trial.mag[first]), GAUSS_PER_MICROTESLA) if with_mag else None
    q_nb, north = ecompass(accel, mag)
    return Start(q_nb, (0.0, 0.0, 0.0), north, accel, mag)


def imu_samples(trial: Trial, with_mag: bool) -> Iterator[ImuSample]:
    """The readings, one a sample, from time 0 on."""
    fields: list[list[float]] = (GAUSS_PER_MICROTESLA * trial.mag).tolist()
    readings = zip(trial.gyr.tolist(), trial.acc.tolist(), fields, strict=True)
    for number, ((p, q, r), (a_x, a_y, a_z), (m_x, m_y, m_z)) in enumerate(readings):
        t_ns = round(number * 1e9 / trial.rate_hz)
        mag = (m_x, m_y, m_z) if with_mag else None
        yield ImuSample("BROAD", 1, 1, t_ns, t_ns, (p, q, r), (a_x, a_y, a_z), mag)


def to_enu(q_nb: Array) -> Array:
    """Attitudes to NED, shape (n, 4), as attitudes to ENU: half a turn about the axis between north and east."""
    half = np.sqrt(0.5)
    return multiply(np.array([[0.0, half, half, 0.0]]), q_nb)


def _mean(rows: Array) -> Vec3:
    x, y, z = np.mean(rows, axis=0).tolist()
    return (x, y, z)
