"""The backward pass: Rauch, Tung and Striebel's smoother on the multiplicative error.

G = P Phi^T (P-)^-1 from each node to the next; the error of the smoothed state against the predicted one, with the
attitude's as a rotation vector in NED, goes back through G. (Rauch, Tung and Striebel, AIAA Journal 3, 1965; Sarkka,
Bayesian Filtering and Smoothing, chapter 8.)
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from attest_mav.smoothing.forward import Block
from attest_mav.smoothing.model import SIZE, T
from attest_mav.smoothing.rotations import Array, matrices_of_vectors, vectors_of_matrices
from attest_mav.smoothing.tables import Rows

NODE: Final = np.dtype([("attitude", "<f8", (3, 3)), ("x", "<f8", SIZE), ("spread", "<f8", SIZE)])
"""A row of a smoothed state."""
GAINS: Final = 256
"""Gains that are computed at a time."""


@dataclass
class Smoothed:
    """The smoothed states at consecutive nodes."""

    attitude: Array
    """Body to NED, a matrix."""
    x: Array
    """The 24 components; those of the attitude are zero."""
    spread: Array
    """Variances of all 24 errors."""


def smoothed_of(rows: Rows) -> Smoothed:
    """The columns of a table of smoothed states."""
    return Smoothed(rows["attitude"], rows["x"], rows["spread"])


@dataclass
class Last:
    """The smoothed state of the node behind a block."""

    attitude: Array
    x: Array
    p: Array


def smooth_block(block: Block, chosen: int, last: Last | None) -> tuple[Rows, Last]:
    """Smooth the nodes of a block, from its end to its beginning: their rows, and the state of the first one.

    last: the smoothed state of the block's last node, if there are nodes behind it; that node then has no row.
    """
    nodes = len(block.attitude)
    rows = np.empty(nodes if last is None else nodes - 1, NODE)
    if last is None:
        last = Last(block.attitude[-1, chosen], block.x[-1, chosen], block.p[-1, chosen])
        _store(rows, nodes - 1, last)
    for first in reversed(range(0, nodes - 1, GAINS)):
        end = min(first + GAINS, nodes - 1)
        gains = _gains(block, chosen, first, end)
        for row in range(end - 1, first - 1, -1):
            last = _stepped_back(block, chosen, row, gains[row - first], last)
            _store(rows, row, last)
    return rows, last


def _gains(block: Block, chosen: int, first: int, end: int) -> Array:
    """G of some nodes. P- is scaled by its diagonal before it is inverted: its units differ by 1e6."""
    predicted = block.p_predicted[first + 1 : end + 1, chosen]
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(predicted, axis1=1, axis2=2), 1e-30))
    scaled = predicted * scale[:, :, np.newaxis] * scale[:, np.newaxis, :]
    # A state that is left out has no variance: the identity keeps its row solvable.
    empty = np.diagonal(predicted, axis1=1, axis2=2) <= 0.0
    scaled[:, range(scaled.shape[1]), range(scaled.shape[1])] += np.where(empty, 1.0, 0.0)
    through = np.matmul(block.phi[first + 1 : end + 1, chosen], block.p[first:end, chosen])
    solved = np.linalg.solve(scaled, through * scale[:, :, np.newaxis])
    return np.swapaxes(solved * scale[:, :, np.newaxis], 1, 2)


def _stepped_back(block: Block, chosen: int, row: int, gain: Array, behind: Last) -> Last:
    """The smoothed state of a row by that of the next one."""
    error = behind.x - block.x_predicted[row + 1, chosen]
    error[T] = vectors_of_matrices(behind.attitude @ block.predicted_attitude[row + 1, chosen].T)
    delta = gain @ error
    x = block.x[row, chosen] + delta
    x[T] = 0.0
    p = block.p[row, chosen] + gain @ (behind.p - block.p_predicted[row + 1, chosen]) @ gain.T
    return Last(matrices_of_vectors(delta[T]) @ block.attitude[row, chosen], x, 0.5 * (p + p.T))


def _store(rows: Rows, row: int, state: Last) -> None:
    rows["attitude"][row], rows["x"][row], rows["spread"][row] = state.attitude, state.x, np.diagonal(state.p)
