"""Figure 3 of paper 1: the Euler angles that the gradient-descent filter gives at a small and a large gain."""

from typing import TYPE_CHECKING, Final

import numpy as np

from attest_mav.algebra import q_to_euler
from attest_mav.evaluation.harness import TrialMap
from attest_mav.evaluation.motion import Array
from attest_mav.evaluation.papers.figure_style import BLUE, GREEN, GREY, ORANGE, dress, legend, sheet
from attest_mav.evaluation.papers.paper1 import ERRORS, FIELD, PLATFORM, handled
from attest_mav.evaluation.simulation import imu_samples, run_filter
from attest_mav.filters.gradient_descent.filter import GradientDescent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CLOSE_UP: Final = (60.0, 63.0)
"""Seconds shown enlarged."""


def euler_angles(seed: int, _trial_map: TrialMap) -> "Figure":
    """Both gains on the same readings, as a whole and close up."""
    rng = np.random.default_rng([seed, 0])
    truth = handled(PLATFORM, rng)
    samples = imu_samples(truth, (FIELD.b_x, 0.0, FIELD.b_z), ERRORS, rng)
    figure = sheet(9.0, 5.6, "Paper 1, figure 3: gradient descent on the platform")
    grid = figure.subplots(2, 2, width_ratios=(2.0, 1.2), sharex="col", sharey="col")
    for row, beta in enumerate((0.01, 0.5)):
        chosen = GradientDescent(beta=beta, exponential=False, field=FIELD)
        angles = _degrees(run_filter(chosen, truth.start, samples, truth.dt_s))
        _whole(grid[row, 0], truth.time_s, angles)
        _close_up(grid[row, 1], truth.time_s, angles, _degrees(truth.q_nb))
        dress(grid[row, 0], f"beta = {beta:g} rad/s", "time, s" if row == 1 else "", "estimate, deg")
        dress(grid[row, 1], "roll, close up", "time, s" if row == 1 else "", "deg")
    grid[0, 0].set_ylim(-36.0, 46.0)
    legend(grid[0, 0], "upper center", columns=3)
    legend(grid[0, 1])
    return figure


def _degrees(attitudes: Array) -> Array:
    """Roll, pitch and yaw, shape (n, 3)."""
    return np.degrees([q_to_euler((w, x, y, z)) for w, x, y, z in attitudes.tolist()])


def _whole(axes: "Axes", time_s: Array, angles: Array) -> None:
    for axis, (name, colour) in enumerate((("roll", BLUE), ("pitch", ORANGE), ("yaw", GREEN))):
        axes.plot(time_s, angles[:, axis], color=colour, linewidth=1.0, label=name)


def _close_up(axes: "Axes", time_s: Array, angles: Array, truth: Array) -> None:
    shown = (time_s >= CLOSE_UP[0]) & (time_s < CLOSE_UP[1])
    axes.plot(time_s[shown], truth[shown, 0], color=GREY, linewidth=2.5, label="true roll")
    axes.plot(time_s[shown], angles[shown, 0], color=BLUE, linewidth=1.0, label="estimate")
