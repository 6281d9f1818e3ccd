"""Figures 2 and 3 of paper 2: errors of the plain and of the robust adaptive filter on the rotating stand.

Drawn in setting S2, in which the plain filter errs as much as the paper shows.
"""

from typing import TYPE_CHECKING

import numpy as np

from attest_mav.evaluation.harness import TrialMap
from attest_mav.evaluation.motion import Array
from attest_mav.evaluation.papers.figure_style import BLUE, GREY, ORANGE, dress, legend, sheet
from attest_mav.evaluation.papers.paper2 import LIMIT_DEG
from attest_mav.evaluation.papers.rotation_stand import (
    LOGIC,
    PAPER_LEVEL,
    PLAIN,
    PRINTED,
    RATE_HZ,
    angle_errors,
    stand_run,
)
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AXES = ("roll", "pitch", "yaw")


def plain_filter(seed: int, _trial_map: TrialMap) -> "Figure":
    """Figure 2."""
    errors = _errors(seed, PLAIN)
    figure = sheet(8.0, 5.6, "Paper 2, figure 2: extended Kalman filter, bursts of heading and force (S2)")
    for axis, axes in enumerate(figure.subplots(3, 1, sharex=True)):
        axes.plot(_time_s(errors), errors[:, axis], color=BLUE, linewidth=0.8)
        dress(axes, AXES[axis], "time, s" if axis == 2 else "", "error, deg")
    return figure


def robust_adaptive(seed: int, _trial_map: TrialMap) -> "Figure":
    """Figure 3: the printed algorithm, and the recommended logic with the same noise settings."""
    printed, recommended = _errors(seed, PRINTED), _errors(seed, LOGIC)
    figure = sheet(9.0, 5.6, "Paper 2, figure 3: robust adaptive filter, the same readings")
    grid = figure.subplots(3, 2, sharex=True, sharey="col")
    for axis in range(3):
        for column, (errors, colour, title) in enumerate(
            ((printed, ORANGE, "as printed"), (recommended, BLUE, "recommended logic"))
        ):
            axes = grid[axis, column]
            axes.plot(_time_s(errors), errors[:, axis], color=colour, linewidth=0.8)
            axes.axhline(LIMIT_DEG, color=GREY, linewidth=0.8, linestyle="--", label="0.2 deg, the paper's claim")
            axes.axhline(-LIMIT_DEG, color=GREY, linewidth=0.8, linestyle="--")
            dress(axes, f"{AXES[axis]}, {title}", "time, s" if axis == 2 else "", "error, deg")
    legend(grid[0, 1], "upper right")
    return figure


def _errors(seed: int, chosen: RobustAdaptive) -> Array:
    return angle_errors(chosen, stand_run(PAPER_LEVEL, np.random.default_rng([seed, 0])))


def _time_s(errors: Array) -> Array:
    return np.arange(1, len(errors) + 1, dtype=np.float64) / RATE_HZ
