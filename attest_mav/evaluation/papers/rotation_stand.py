"""The experiment of paper 2: a rotating stand whose heading and accelerometer are contaminated, and filters on it.

The stand turns about three axes for 40 s: roll and pitch through an angle A with periods of 11 and 17 s, yaw through
180 degrees in 40 s. The heading comes from an encoder, or in one setting from a magnetometer.
"""

from dataclasses import dataclass, replace
from math import inf, radians, sqrt
from typing import Final

import numpy as np

from attest_mav.algebra import q_heading, q_mul, q_to_euler
from attest_mav.evaluation.motion import Array, Motion, motion, times, to_body
from attest_mav.evaluation.readings import samples_of
from attest_mav.evaluation.simulation import NO_ERROR
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North

RATE_HZ: Final = 100.0
DURATION_S: Final = 40.0
IGNORED_S: Final = 2.0
"""The first seconds do not count."""
GYRO_NOISE: Final = radians(0.05)
"""rad/s, one sigma a sample and axis."""
ACCEL_NOISE: Final = 0.004 * G_MPS2
HEADING_NOISE: Final = 1e-3
"""rad."""
MAG_NOISE: Final = 0.008
"""Of the field."""
FIELD_NED: Final = (0.5, 0.0, sqrt(0.75))
"""Unit, dipping 60 degrees."""


@dataclass(frozen=True)
class Setting:
    """How the stand moves and what goes wrong.

    amplitude_deg: A. heading_deg: size of the heading's bursts, with a random sign, or drawn normally with
    ``heading_normal``. heading_rate_hz: bursts begin with this rate and last ``heading_samples``; where two overlap
    they add. side_g, side_share: normal outliers of the sideways specific force, g, on this share of the samples.
    magnetic: heading from a magnetometer. wrong_start_deg: error of the heading at the start.
    """

    amplitude_deg: float = 45.0
    heading_deg: float = 0.0
    heading_normal: bool = False
    heading_rate_hz: float = 0.0
    heading_samples: int = 1
    side_g: float = 0.0
    side_share: float = 0.0
    magnetic: bool = False
    wrong_start_deg: float = 0.0


CLEAN: Final = Setting()
"""S0."""
SPARSE: Final = Setting(heading_deg=3.5, heading_rate_hz=0.4, heading_samples=3)
"""S1: sparse, moderate bursts of the heading."""
PAPER_LEVEL: Final = Setting(
    amplitude_deg=5.0, heading_deg=5.0, heading_rate_hz=1.0, heading_samples=4, side_g=1.25, side_share=0.0107
)
"""S2: what gives a plain filter the errors that the paper shows for it."""
GROSS: Final = Setting(heading_deg=30.0, heading_normal=True, heading_rate_hz=1.0, side_g=1.0, side_share=0.03)
"""S3: gross single outliers."""
MAGNETIC: Final = Setting(magnetic=True)
"""S8."""
WRONG_START: Final = Setting(wrong_start_deg=30.0)
"""S10."""

PRINTED: Final = RobustAdaptive(
    printed=True,
    c=0.9,
    r_accel=1e-3,
    r_heading=1e-6,
    gyro_noise=0.0,
    q_step=1e-8,
    p0=1e-10,
    max_accel_error_g=inf,
)
"""The paper's algorithm with the paper's Q, R and P0."""
PLAIN: Final = replace(PRINTED, robust=False, adaptive=False)
"""The extended Kalman filter without either factor."""
ROBUST: Final = replace(PRINTED, adaptive=False)
"""The printed one without its adaptive factor."""
LOGIC: Final = replace(
    RobustAdaptive(), c=PRINTED.c, r_heading=PRINTED.r_heading, gyro_noise=0.0, q_step=PRINTED.q_step, p0=PRINTED.p0
)
"""The recommended logic with the paper's noise and c."""
RECOMMENDED: Final = RobustAdaptive()
"""The filter's defaults."""

VARIANTS: Final = {
    "plain": PLAIN,
    "printed": PRINTED,
    "robust": ROBUST,
    "logic": LOGIC,
    "recommended": RECOMMENDED,
}
"""By the names that trials carry to their processes: compiled, a frozen record does not survive pickling."""


@dataclass(frozen=True, eq=False)
class StandRun:
    """One run of the stand: where it starts, what the sensors said, and the true Euler angles at each sample, rad."""

    start: Start
    samples: list[ImuSample]
    inputs: list[FilterInputs]
    truth: Array


def stand_run(setting: Setting, rng: np.random.Generator) -> StandRun:
    """Simulate the sensors once."""
    true_motion, angles = _stand_motion(setting.amplitude_deg)
    count = len(angles)
    gyro = true_motion.rate + GYRO_NOISE * rng.standard_normal((count, 3))
    accel = true_motion.force + ACCEL_NOISE * rng.standard_normal((count, 3))
    outliers = (rng.random(count) < setting.side_share) * rng.standard_normal(count)
    accel[:, 1] += setting.side_g * G_MPS2 * outliers
    mag = to_body(true_motion.q_nb, np.array(FIELD_NED)) + MAG_NOISE * rng.standard_normal((count, 3))
    heading = angles[:, 2] + HEADING_NOISE * rng.standard_normal(count) + _bursts(setting, count, rng)
    wrong_start = q_mul(q_heading(radians(setting.wrong_start_deg)), true_motion.start)
    return StandRun(
        start=Start(wrong_start, NO_ERROR, North.TRUE, (0.0, 0.0, -G_MPS2), None),
        samples=samples_of(gyro, accel, mag if setting.magnetic else None, true_motion.dt_s),
        inputs=[FilterInputs(heading=None if setting.magnetic else psi) for psi in heading.tolist()],
        truth=angles,
    )


def _stand_motion(amplitude_deg: float) -> tuple[Motion, Array]:
    """The true motion, and its Euler angles, rad, shape (n, 3)."""
    t = times(DURATION_S, RATE_HZ)
    roll = radians(amplitude_deg) * np.sin(2.0 * np.pi * t / 11.0)
    pitch = radians(amplitude_deg) * np.sin(2.0 * np.pi * t / 17.0)
    yaw = np.pi * np.sin(2.0 * np.pi * t / 40.0)
    true_motion = motion((roll, pitch, yaw), np.zeros((len(t), 3)), 1.0 / RATE_HZ)
    return true_motion, np.column_stack((roll, pitch, yaw))[1:]


def _bursts(setting: Setting, count: int, rng: np.random.Generator) -> Array:
    """Error of the heading at each sample, rad."""
    begins = rng.random(count) < setting.heading_rate_hz / RATE_HZ
    sizes = rng.standard_normal(count) if setting.heading_normal else rng.choice((-1.0, 1.0), count)
    single = radians(setting.heading_deg) * sizes * begins
    return np.convolve(single, np.ones(setting.heading_samples))[:count]


def angle_errors(chosen: RobustAdaptive, run: StandRun) -> Array:
    """Estimated minus true roll, pitch and yaw at each sample, degrees, shape (n, 3)."""
    state = chosen.initial(run.start)
    estimate = []
    for sample, inputs in zip(run.samples, run.inputs, strict=True):
        state = chosen.step(state, 1.0 / RATE_HZ, sample, inputs)
        estimate.append(q_to_euler(state.q_nb))
    difference = np.array(estimate) - run.truth
    return np.degrees((difference + np.pi) % (2.0 * np.pi) - np.pi)


def peaks(errors: Array) -> Array:
    """Largest error of roll, pitch and yaw after the first seconds, degrees."""
    largest: Array = np.abs(errors[round(IGNORED_S * RATE_HZ) :]).max(axis=0)
    return largest
