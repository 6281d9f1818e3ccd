"""The backward pass: Rauch, Tung and Striebel's smoother on the multiplicative error.

G = P Phi^T (P-)^-1 from each node to the next; the error of the smoothed state against the predicted one, with the
attitude's as a rotation vector in NED, goes back through G. (Rauch, Tung and Striebel, AIAA Journal 3, 1965; Sarkka,
Bayesian Filtering and Smoothing, chapter 8.)
"""

from dataclasses import dataclass

import numpy as np

from attest_mav.smoothing.forward import Block
from attest_mav.smoothing.model import T
from attest_mav.smoothing.rotations import Array, matrices_of_vectors, vectors_of_matrices


@dataclass
class Smoothed:
    """The smoothed state at each node."""

    attitude: Array
    """Body to NED, a matrix."""
    x: Array
    """The 21 components; those of the attitude are zero."""
    p: Array
    """Covariance of the attitude, 3 by 3, rad^2."""
    spread: Array
    """Variances of all 21 errors."""


@dataclass
class Last:
    """The smoothed state of the node behind a block."""

    attitude: Array
    x: Array
    p: Array


def smooth_block(block: Block, chosen: int, last: Last | None, out: Smoothed, first: int) -> Last:
    """Smooth the nodes of a block, from its end to its beginning, into ``out`` from row ``first`` on.

    last: the smoothed state of the block's last node, if there are nodes behind it; that node is then left as it is.
    """
    nodes = len(block.attitude)
    at = nodes - 1
    if last is None:
        last = Last(block.attitude[at, chosen], block.x[at, chosen], block.p[at, chosen])
        _store(out, first + at, last)
    gains = _gains(block, chosen)
    for row in range(nodes - 2, -1, -1):
        last = _stepped_back(block, chosen, row, gains[row], last)
        _store(out, first + row, last)
    return last


def _gains(block: Block, chosen: int) -> Array:
    """G of each node but the last. P- is scaled by its diagonal before it is inverted: its units differ by 1e6."""
    predicted = block.p_predicted[1:, chosen]
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(predicted, axis1=1, axis2=2), 1e-30))
    scaled = predicted * scale[:, :, np.newaxis] * scale[:, np.newaxis, :]
    # A state that is left out has no variance: the identity keeps its row solvable.
    empty = np.diagonal(predicted, axis1=1, axis2=2) <= 0.0
    scaled[:, range(scaled.shape[1]), range(scaled.shape[1])] += np.where(empty, 1.0, 0.0)
    through = np.matmul(block.phi[1:, chosen], block.p[:-1, chosen])
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


def _store(out: Smoothed, row: int, state: Last) -> None:
    out.attitude[row], out.x[row] = state.attitude, state.x
    out.p[row], out.spread[row] = state.p[T, T], np.diagonal(state.p)
