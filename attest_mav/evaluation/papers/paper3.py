"""Scenarios of paper 3: the leveling filter on an underwater vehicle, moving on an S-shaped course and standing.

100 runs of 30 s with starts wrong by 45 degrees (one sigma). Figures are of the errors, estimate minus truth, at the
end of the runs unless they say otherwise. The paper does not print its tuning; these settings give its figures.
"""

from dataclasses import dataclass, replace
from math import inf
from typing import Final

import numpy as np

from attest_mav.evaluation.harness import Scenario, TrialMap
from attest_mav.evaluation.motion import Array
from attest_mav.evaluation.papers.underwater import (
    GRAVITY,
    STANDING,
    STRAIGHT,
    WINDING,
    Course,
    Sensors,
    Setting,
    angle_errors,
    states,
    voyage,
)
from attest_mav.filters.leveling.filter import Leveling

PAPER: Final = Leveling(
    q_velocity=1e-5,
    q_down=3e-9,
    r_speed=0.01,
    r_stationary=0.01,
    r_sideslip=inf,
    r_length_start=0.5,
    r_length=0.5,
    p0_velocity=1.0,
    p0_down=1.0,
    gravity=GRAVITY,
)
"""Parameters that reproduce the paper's figures on the winding course."""
LOOSE_LENGTH: Final = replace(PAPER, r_length_start=0.7, r_length=0.7)
PAPER_STANDING: Final = replace(PAPER, q_down=1e-9, r_length_start=1e-3, r_length=1e-3, spacing_s=0.0)
"""Parameters that reproduce its figures at rest."""
NO_SIDESLIP: Final = replace(LOOSE_LENGTH, r_sideslip=0.09)
NAVIGATION: Final = replace(NO_SIDESLIP, r_length=0.1, p0_down=0.05)
"""Recommended for navigation-grade sensors."""

TUNINGS: Final = {
    "paper": PAPER,
    "paper standing": PAPER_STANDING,
    "no sideslip": NO_SIDESLIP,
    "navigation": NAVIGATION,
}
"""By the names that trials carry to their processes: compiled, a frozen record does not survive pickling."""

NO_BIASES: Final = Sensors(gyro_bias=(0.0, 0.0, 0.0), accel_bias=0.0, speed_bias=0.0)


@dataclass(frozen=True)
class Trial:
    """One run of the filter of that tuning in a setting."""

    tuning: str
    setting: Setting
    seed: int
    run: int


def run_trial(trial: Trial) -> Array:
    """Errors of roll, pitch and yaw at each sample, degrees, shape (n, 3)."""
    run = voyage(trial.setting, np.random.default_rng([trial.seed, trial.run]))
    return angle_errors(states(TUNINGS[trial.tuning], run), run.truth)


def ensemble(tuning: str, setting: Setting, runs: int, seed: int, trial_map: TrialMap) -> Array:
    """The errors of all runs, shape (runs, n, 3)."""
    return np.array(list(trial_map(run_trial, [Trial(tuning, setting, seed, run) for run in range(runs)])))


def final_figures(errors: Array) -> dict[str, float]:
    """Mean, standard deviation over the runs and largest size of the last errors, degrees."""
    last = errors[:, -1, :2]
    mean_roll, mean_pitch = last.mean(axis=0).tolist()
    std_roll, std_pitch = last.std(axis=0).tolist()
    return {
        "mean_roll_deg": mean_roll,
        "mean_pitch_deg": mean_pitch,
        "std_roll_deg": std_roll,
        "std_pitch_deg": std_pitch,
        "worst_deg": float(np.abs(last).max()),
    }


def down_sigma(chosen: Leveling, setting: Setting) -> Array:
    """One sigma of the three components of the down vector at each sample, shape (n, 3).

    Always with the same draw of the sensors' noise. The noise moves the estimate and with it the unit-length row,
    which is what shows a straight run's roll at all: there sigma after 10 s was between 0.35 and 0.70 over 100 draws.
    """
    after = states(chosen, voyage(setting, np.random.default_rng([0])))
    variances: Array = np.array([[state.level.p_dd[axis][axis] for axis in range(3)] for state in after])
    return variances**0.5


def covariance_setting(course: Course, *, stationary: bool) -> Setting:
    """A run for the covariance alone: started at the truth."""
    return Setting(course=course, stationary=stationary, start_deg=0.0)


def moving(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P3-a."""
    return final_figures(ensemble("paper", Setting(), runs, seed, trial_map))


def moving_without_bias(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P3-b."""
    return final_figures(ensemble("paper", Setting(sensors=NO_BIASES), runs, seed, trial_map))


STANDING_AS_PRINTED: Final = Setting(
    course=STANDING, sensors=Sensors(gyro_bias=(1.0, -1.0, 1.0)), rate_hz=50.0, stationary=True
)
STANDING_SAME_TUNING: Final = Setting(course=STANDING, stationary=True)


def standing(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P3-c."""
    return final_figures(ensemble("paper standing", STANDING_AS_PRINTED, runs, seed, trial_map))


def standing_same_tuning(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P3-d."""
    errors = ensemble("paper", STANDING_SAME_TUNING, runs, seed, trial_map)
    after_2_s = errors[:, round(2.0 * STANDING_SAME_TUNING.rate_hz) - 1, :2]
    return {**final_figures(errors), "rms_2s_deg": float(np.sqrt((after_2_s**2).mean(axis=0)).max())}


def covariances(_runs: int, _seed: int, _trial_map: TrialMap) -> dict[str, float]:
    """P3-e: sigma of the sideways component of down, which is that of roll, after 10 s."""
    at_10_s = {
        "standing": down_sigma(LOOSE_LENGTH, covariance_setting(STANDING, stationary=True)),
        "straight": down_sigma(LOOSE_LENGTH, covariance_setting(STRAIGHT, stationary=False)),
        "winding": down_sigma(LOOSE_LENGTH, covariance_setting(WINDING, stationary=False)),
    }
    return {f"{name}_sigma": float(sigma[999, 1]) for name, sigma in at_10_s.items()}


def no_sideslip(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P3-f."""
    return final_figures(ensemble("no sideslip", Setting(), runs, seed, trial_map))


def full_attitude(runs: int, seed: int, trial_map: TrialMap) -> dict[str, float]:
    """P3-g: rms over the runs and their second halves."""
    errors = ensemble("navigation", Setting(magnetic=True, start_deg=5.0), runs, seed, trial_map)
    second_half = errors[:, errors.shape[1] // 2 :]
    roll, pitch, yaw = np.sqrt((second_half**2).mean(axis=(0, 1))).tolist()
    return {"rms_roll_deg": roll, "rms_pitch_deg": pitch, "rms_yaw_deg": yaw}


SCENARIOS: Final = (
    Scenario(
        "P3-a",
        "winding course, the paper's model",
        100,
        {
            "mean_roll_deg": (0.074, 0.105),
            "mean_pitch_deg": (0.053, 0.066),
            "std_roll_deg": (0.028, 0.054),
            "std_pitch_deg": (0.013, 0.025),
            "worst_deg": (0.0, 0.5),
        },
        moving,
        {"mean_roll_deg": 0.083, "mean_pitch_deg": 0.058, "std_roll_deg": 0.046, "std_pitch_deg": 0.019},
    ),
    Scenario(
        "P3-b",
        "the same without sensor biases",
        100,
        {"mean_roll_deg": (-0.015, 0.015), "mean_pitch_deg": (-0.008, 0.008)},
        moving_without_bias,
    ),
    Scenario(
        "P3-c",
        "standing, tuned to the paper",
        100,
        {
            "mean_roll_deg": (-0.0555, -0.0525),
            "mean_pitch_deg": (0.0530, 0.0553),
            "std_roll_deg": (0.0, 0.005),
            "std_pitch_deg": (0.0, 0.005),
        },
        standing,
        {"mean_roll_deg": -0.051, "mean_pitch_deg": 0.054, "std_roll_deg": 0.003, "std_pitch_deg": 0.004},
    ),
    Scenario(
        "P3-d",
        "standing, tuned as for the winding course",
        100,
        {
            "mean_roll_deg": (-0.0548, -0.0540),
            "mean_pitch_deg": (0.0599, 0.0607),
            "std_roll_deg": (0.0, 0.0005),
            "std_pitch_deg": (0.0, 0.0005),
            "rms_2s_deg": (0.0, 0.06),
        },
        standing_same_tuning,
        {"mean_roll_deg": -0.051, "mean_pitch_deg": 0.054, "std_roll_deg": 0.003, "std_pitch_deg": 0.004},
    ),
    Scenario(
        "P3-e",
        "covariance of roll after 10 s: standing, straight run, winding course",
        1,
        {"standing_sigma": (0.0, 0.0005), "straight_sigma": (0.35, 0.5), "winding_sigma": (0.0, 0.006)},
        covariances,
    ),
    Scenario(
        "P3-f",
        "winding course with side-slip rows",
        100,
        {
            "mean_roll_deg": (0.022, 0.027),
            "mean_pitch_deg": (0.033, 0.039),
            "std_roll_deg": (0.0, 0.004),
            "std_pitch_deg": (0.0, 0.007),
            "worst_deg": (0.0, 0.08),
        },
        no_sideslip,
        {"mean_roll_deg": 0.083, "mean_pitch_deg": 0.058, "std_roll_deg": 0.046, "std_pitch_deg": 0.019},
    ),
    Scenario(
        "P3-g",
        "full attitude with a magnetometer, recommended: rms from 15 to 30 s",
        100,
        {"rms_roll_deg": (0.0, 0.08), "rms_pitch_deg": (0.0, 0.04), "rms_yaw_deg": (0.0, 0.30)},
        full_attitude,
    ),
)
