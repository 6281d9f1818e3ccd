"""How far attitudes are from the true ones, as the authors of BROAD define it.

The error is q_imu conj(q_opt), in the world's axes (ENU); no alignment to the truth is made. With (w, x, y, z) its
components: total = 2 acos |w|, heading = 2 atan |z / w|, inclination = 2 acos sqrt(w^2 + z^2). Each is averaged as a
root mean square over the samples that count.
"""

from dataclasses import dataclass

import numpy as np

from attest_mav.evaluation.broad.trial import Trial
from attest_mav.evaluation.motion import Array, conjugate, multiply


@dataclass(frozen=True)
class Errors:
    """Root mean squares over the samples that count, degrees."""

    total: float
    heading: float
    inclination: float


def angles(estimate: Array, truth: Array) -> Array:
    """Total, heading and inclination error of each sample, rad, shape (n, 3); all are in [0, pi]."""
    w, _, _, z = multiply(estimate, conjugate(truth)).T
    total = 2.0 * np.arccos(np.minimum(np.abs(w), 1.0))
    # atan |z / w|, which is defined where w = 0 too.
    heading = 2.0 * np.arctan2(np.abs(z), np.abs(w))
    inclination = 2.0 * np.arccos(np.minimum(np.sqrt(w * w + z * z), 1.0))
    return np.column_stack((total, heading, inclination))


def errors(trial: Trial, estimate: Array) -> Errors:
    """Figures of a run. estimate: sensor to ENU, one a sample, shape (n, 4)."""
    each = angles(estimate[trial.counted], trial.opt[trial.counted])
    total, heading, inclination = np.degrees(np.sqrt(np.mean(each * each, axis=0))).tolist()
    return Errors(total, heading, inclination)
