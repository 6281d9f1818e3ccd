"""How far a run's attitudes are from the true ones, in figures."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from attest_mav.evaluation.butterworth import highpass
from attest_mav.evaluation.motion import Array, conjugate, multiply

HF_CUTOFF_HZ: Final = 5.0
"""Hz. Errors above this frequency are vibration that the filter adds: no true motion here is so fast."""


@dataclass(frozen=True)
class Accuracy:
    """Root mean squares of the error vector, degrees.

    total: its length. tilt: its north and east parts. heading: its down part. hf: its length above 5 Hz.
    """

    total: float
    tilt: float
    heading: float
    hf: float


def error_vectors(estimate: Array, truth: Array) -> Array:
    """2 vec(estimate * conj(truth)) with the sign that makes its scalar positive: NED, rad for small errors."""
    error = multiply(estimate, conjugate(truth))
    return 2.0 * error[:, 1:] * np.where(error[:, :1] >= 0.0, 1.0, -1.0)


def accuracy(estimate: Array, truth: Array, rate_hz: float, skip_s: float) -> Accuracy:
    """Figures of the samples from ``skip_s`` after the start on; both arrays begin one interval after it."""
    errors = np.degrees(error_vectors(estimate, truth)[round(skip_s * rate_hz) - 1 :])
    return Accuracy(
        total=rms(errors),
        tilt=rms(errors[:, :2]),
        heading=rms(errors[:, 2:]),
        hf=rms(highpass(errors, HF_CUTOFF_HZ, rate_hz)),
    )


def rms(vectors: Array) -> float:
    """Root of the mean squared length of the rows."""
    return float(np.sqrt(np.mean(np.sum(vectors * vectors, axis=1))))
