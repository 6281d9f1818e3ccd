"""Scenarios of paper 1: the gradient-descent filter on a platform and in a hand, at several gains beta.

100 Hz for 120 s, figures from 20 s on, started at the true attitude; form (31) with Euler's rule, as printed, and
the reference field fixed. The paper shows curves and prints no figures.
"""

from dataclasses import dataclass
from math import radians, sqrt
from typing import Final

import numpy as np

from attest_mav.evaluation.attitude_error import Accuracy, accuracy
from attest_mav.evaluation.harness import Scenario, TrialMap
from attest_mav.evaluation.motion import Motion, Wave, gauss_markov, motion, times, waves
from attest_mav.evaluation.papers.paper1_equations import identity_gap, jacobian_gap
from attest_mav.evaluation.simulation import SensorErrors, imu_samples, run_filter
from attest_mav.filters.gradient_descent.filter import FixedField, GradientDescent
from attest_mav.types import G_MPS2

RATE_HZ: Final = 100.0
DURATION_S: Final = 120.0
SKIP_S: Final = 20.0

FIELD: Final = FixedField(0.5, sqrt(0.75))
"""Dip 60 degrees, unit length."""

ERRORS: Final = SensorErrors(
    gyro_noise=radians(0.06), gyro_bias=radians(0.15), accel_noise=0.004 * G_MPS2, mag_noise=0.008
)
NO_BIAS: Final = SensorErrors(gyro_noise=radians(0.06), accel_noise=0.004 * G_MPS2, mag_noise=0.008)

BETAS: Final = (0.003, 0.01, 0.02, 0.033, 0.05, 0.1, 0.5)
"""The gains among which the best is sought."""


@dataclass(frozen=True)
class Handling:
    """How the sensors are moved: sinusoids of the angles, and the rms of the acceleration per axis, m/s^2."""

    roll: tuple[Wave, ...]
    pitch: tuple[Wave, ...]
    yaw: tuple[Wave, ...]
    acceleration: float
    correlation_s: float = 0.25


PLATFORM: Final = Handling((Wave(10, 21),), (Wave(8, 17),), (Wave(30, 60),), 0.0)
HANDHELD: Final = Handling((Wave(30, 7), Wave(8, 1.3)), (Wave(25, 5), Wave(8, 1.7)), (Wave(90, 20), Wave(10, 2.1)), 0.7)


@dataclass(frozen=True)
class Trial:
    """One recording, run through the filter once for each gain."""

    handling: Handling
    errors: SensorErrors
    betas: tuple[float, ...]
    seed: int
    run: int


def run_trial(trial: Trial) -> list[Accuracy]:
    """The accuracy at each gain."""
    rng = np.random.default_rng([trial.seed, trial.run])
    truth = handled(trial.handling, rng)
    samples = imu_samples(truth, (FIELD.b_x, 0.0, FIELD.b_z), trial.errors, rng)
    filters = [GradientDescent(beta=beta, exponential=False, field=FIELD) for beta in trial.betas]
    runs = [run_filter(each, truth.start, samples, truth.dt_s) for each in filters]
    return [accuracy(attitudes, truth.q_nb, RATE_HZ, SKIP_S) for attitudes in runs]


def handled(handling: Handling, rng: np.random.Generator) -> Motion:
    """One motion with random phases and accelerations."""
    t = times(DURATION_S, RATE_HZ)
    angles = (waves(t, handling.roll, rng), waves(t, handling.pitch, rng), waves(t, handling.yaw, rng))
    acceleration = gauss_markov((len(t), 3), handling.acceleration, handling.correlation_s, 1.0 / RATE_HZ, rng)
    return motion(angles, acceleration, 1.0 / RATE_HZ)


@dataclass(frozen=True)
class Campaign:
    """So many trials of one kind, and the means of their figures."""

    runs: int
    seed: int
    trial_map: TrialMap

    def means(self, handling: Handling, *betas: float, errors: SensorErrors = ERRORS) -> list[Accuracy]:
        """Mean accuracy at each gain."""
        trials = [Trial(handling, errors, betas, self.seed, run) for run in range(self.runs)]
        by_beta = zip(*self.trial_map(run_trial, trials), strict=True)
        return [_mean(list(runs)) for runs in by_beta]


def _mean(runs: list[Accuracy]) -> Accuracy:
    figures = np.mean([(run.total, run.tilt, run.heading, run.hf) for run in runs], axis=0)
    return Accuracy(*figures.tolist())


def platform_slow(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P1-a."""
    (slow,) = Campaign(runs, seed, trial_map).means(PLATFORM, 0.01)
    return {"total_deg": slow.total, "hf_deg": slow.hf}


def platform_best(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P1-b."""
    (best,) = Campaign(runs, seed, trial_map).means(PLATFORM, 0.05)
    return {"total_deg": best.total, "tilt_deg": best.tilt, "hf_deg": best.hf}


def platform_fast(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P1-c."""
    slow, fast = Campaign(runs, seed, trial_map).means(PLATFORM, 0.01, 0.5)
    return {"total_deg": fast.total, "hf_deg": fast.hf, "hf_ratio": fast.hf / slow.hf}


def handheld(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P1-d."""
    usual, fast = Campaign(runs, seed, trial_map).means(HANDHELD, 0.033, 0.5)
    return {
        "total_deg": usual.total,
        "hf_deg": usual.hf,
        "total_deg_fast": fast.total,
        "hf_deg_fast": fast.hf,
    }


def best_gains(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P1-e."""
    campaign = Campaign(runs, seed, trial_map)
    return {
        "platform_beta": lowest_at(BETAS, [each.total for each in campaign.means(PLATFORM, *BETAS)]),
        "handheld_beta": lowest_at(BETAS, [each.total for each in campaign.means(HANDHELD, *BETAS)]),
    }


def lowest_at(betas: tuple[float, ...], totals: list[float]) -> float:
    """Where the error is least: the bottom of the parabola, over log beta, through the lowest point and its neighbours.

    A lowest point at either end has no neighbour on one side and stands for itself.
    """
    k = totals.index(min(totals))
    if k in {0, len(betas) - 1}:
        return betas[k]
    curvature, slope, _ = np.polyfit(np.log(betas[k - 1 : k + 2]), totals[k - 1 : k + 2], 2)
    return float(np.exp(-0.5 * slope / curvature))


def without_bias(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P1-g."""
    (slow,) = Campaign(runs, seed, trial_map).means(PLATFORM, 0.01, errors=NO_BIAS)
    return {"total_deg": slow.total}


def equations(runs: int, seed: int, _trial_map: TrialMap) -> dict[str, float]:
    """P1-f: the largest differences over random attitudes, readings and parameters."""
    rng = np.random.default_rng([seed])
    return {
        "identity": max(identity_gap(rng) for _ in range(runs)),
        "jacobian": max(jacobian_gap(rng) for _ in range(runs)),
    }


SCENARIOS: Final = (
    Scenario(
        "P1-a",
        "platform, beta 0.01",
        10,
        {"total_deg": (0.35, 0.71), "hf_deg": (0.0100, 0.0112)},
        platform_slow,
    ),
    Scenario(
        "P1-b",
        "platform, beta 0.05",
        10,
        {"total_deg": (0.14, 0.22), "tilt_deg": (0.10, 0.12), "hf_deg": (0.051, 0.057)},
        platform_best,
    ),
    Scenario(
        "P1-c",
        "platform, beta 0.5",
        20,
        {"total_deg": (0.48, 0.50), "hf_deg": (0.385, 0.407), "hf_ratio": (33.0, 41.0)},
        platform_fast,
    ),
    Scenario(
        "P1-d",
        "handheld, beta 0.033 and 0.5 (fast)",
        20,
        {
            "total_deg": (1.9, 2.6),
            "hf_deg": (0.0225, 0.0255),
            "total_deg_fast": (5.6, 6.8),
            "hf_deg_fast": (0.51, 0.57),
        },
        handheld,
    ),
    Scenario(
        "P1-e",
        "the beta with the least total error",
        5,
        {"platform_beta": (0.02, 0.1), "handheld_beta": (0.01, 0.05)},
        best_gains,
    ),
    Scenario(
        "P1-f",
        "(26)-(30) against (31) slowed; Jacobian against differences",
        500,
        {"identity": (0.0, 1e-12), "jacobian": (0.0, 1e-6)},
        equations,
    ),
    Scenario("P1-g", "platform without gyro bias, beta 0.01", 10, {"total_deg": (0.058, 0.085)}, without_bias),
)
