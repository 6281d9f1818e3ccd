"""Figures 3, 4 and 6 to 9 of paper 3: covariance of the leveling filter, ensemble mean and deviation of its errors."""

from typing import TYPE_CHECKING, Final

import numpy as np

from attest_mav.evaluation.harness import TrialMap
from attest_mav.evaluation.motion import Array
from attest_mav.evaluation.papers.figure_style import BLUE, GREEN, GREY, ORANGE, dress, legend, sheet
from attest_mav.evaluation.papers.paper3 import (
    LOOSE_LENGTH,
    STANDING_AS_PRINTED,
    covariance_setting,
    down_sigma,
    ensemble,
)
from attest_mav.evaluation.papers.underwater import STANDING, STRAIGHT, WINDING, Setting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RUNS: Final = 100


def covariances(_seed: int, _trial_map: TrialMap) -> "Figure":
    """Figures 3 and 4."""
    cases = (
        ("standing, stationary model", STANDING, True),
        ("straight run", STRAIGHT, False),
        ("winding course", WINDING, False),
    )
    figure = sheet(9.6, 3.4, "Paper 3, figures 3 and 4: one sigma of the down vector's components")
    for axes, (title, course, stationary) in zip(figure.subplots(1, 3, sharey=True), cases, strict=True):
        sigma = down_sigma(LOOSE_LENGTH, covariance_setting(course, stationary=stationary))
        for axis, (name, colour) in enumerate((("a1 (pitch)", BLUE), ("a2 (roll)", ORANGE), ("a3", GREEN))):
            axes.semilogy(_time_s(len(sigma), 100.0), sigma[:, axis], color=colour, linewidth=1.2, label=name)
        dress(axes, title, "time, s", "sigma" if stationary else "")
    legend(figure.axes[0], "upper right")
    return figure


def moving(seed: int, trial_map: TrialMap) -> "Figure":
    """Figures 6 and 7."""
    title = "Paper 3, figures 6 and 7: winding course, 100 runs from starts 45 deg wrong"
    return _ensemble_figure(title, "paper", Setting(), (0.083, 0.058), seed, trial_map)


def standing(seed: int, trial_map: TrialMap) -> "Figure":
    """Figures 8 and 9."""
    title = "Paper 3, figures 8 and 9: standing, 100 runs from starts 45 deg wrong"
    return _ensemble_figure(title, "paper standing", STANDING_AS_PRINTED, (-0.051, 0.054), seed, trial_map)


def _ensemble_figure(
    title: str, tuning: str, setting: Setting, printed: tuple[float, float], seed: int, trial_map: TrialMap
) -> "Figure":
    """Mean and standard deviation of the errors over time; dashed: the mean that the paper prints for the end."""
    errors = ensemble(tuning, setting, RUNS, seed, trial_map)
    time_s = _time_s(errors.shape[1], setting.rate_hz)
    figure = sheet(9.0, 3.6, title)
    mean_axes, deviation_axes = figure.subplots(1, 2)
    for axis, (name, colour) in enumerate((("roll", ORANGE), ("pitch", BLUE))):
        mean_axes.plot(time_s, errors[:, :, axis].mean(axis=0), color=colour, linewidth=1.2, label=name)
        mean_axes.axhline(printed[axis], color=colour, linewidth=0.8, linestyle="--")
        deviation_axes.semilogy(time_s, errors[:, :, axis].std(axis=0), color=colour, linewidth=1.2, label=name)
    mean_axes.plot([], [], color=GREY, linewidth=0.8, linestyle="--", label="printed, at 30 s")
    mean_axes.set_yscale("symlog", linthresh=0.1)
    dress(mean_axes, "ensemble mean of the error (linear below 0.1 deg)", "time, s", "deg")
    dress(deviation_axes, "standard deviation of the error", "time, s", "deg")
    legend(mean_axes, "upper right")
    legend(deviation_axes, "upper right")
    return figure


def _time_s(count: int, rate_hz: float) -> Array:
    return np.arange(1, count + 1, dtype=np.float64) / rate_hz
