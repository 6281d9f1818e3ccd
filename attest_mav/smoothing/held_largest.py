"""The largest value of late, each decaying with a time constant from its own time on."""

from typing import Final

import numpy as np

from attest_mav.smoothing.rotations import Array


class HeldLargest:
    """Takes values in order of time, a run of them after the other; those of several columns each on their own."""

    def __init__(self, hold_s: float) -> None:
        self._hold_s: Final = hold_s
        self._logarithm: float | Array = -np.inf

    def take(self, values: Array, t_s: Array) -> Array:
        """The largest of late at the time of each value, s."""
        gone = (t_s / self._hold_s).reshape(-1, *(1,) * (values.ndim - 1))
        with np.errstate(divide="ignore"):
            logarithms = np.log(values) + gone
        largest = np.maximum(np.maximum.accumulate(logarithms, axis=0), self._logarithm)
        if len(largest):
            self._logarithm = largest[-1]
        out: Array = np.exp(largest - gone)
        return out
