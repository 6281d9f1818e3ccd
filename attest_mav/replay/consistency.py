"""Whether a filter's sigmas tell the truth: its errors and innovations, each in units of its own sigma.

The tilt error is a turn about two horizontal axes, and every filter's tilt sigma is the root of the sum of both
variances. So of a consistent filter whose axes are alike 63.2, 98.2 and 99.99 % of the tilt errors lie within 1, 2
and 3 sigma (1 - exp(-k^2)); with all of the error in one axis it would be 68.3, 95.4 and 99.7 %, which is what the
heading error has. The rms of error / sigma is 1 for both: a filter with more is too sure of itself, with less too
modest. Errors last, so a short log shows few independent ones. The mean NIS is 1 too where the noises are as assumed;
a filter that allows for more than it sees, as for errors that last, has less.
"""

from math import isfinite, sqrt
from typing import Final


class SigmaCount:
    """Counts errors by how many of their own sigmas they are large."""

    def __init__(self) -> None:
        self.samples = 0
        self._within_1 = 0
        self._within_2 = 0
        self._within_3 = 0
        self._square_sum = 0.0

    def add(self, error: float, sigma: float) -> None:
        """Take an error with its sigma, in one unit. Without a sigma that is finite and above zero it says nothing."""
        if not (isfinite(sigma) and sigma > 0.0):
            return
        square = (error / sigma) ** 2
        self.samples += 1
        self._square_sum += square
        if square <= 9.0:
            self._within_3 += 1
            if square <= 4.0:
                self._within_2 += 1
                if square <= 1.0:
                    self._within_1 += 1

    @property
    def within(self) -> tuple[float, float, float]:
        """Shares of the errors within 1, 2 and 3 sigma; there must be samples."""
        n = self.samples
        return (self._within_1 / n, self._within_2 / n, self._within_3 / n)

    @property
    def rms(self) -> float:
        """Root mean square of error / sigma; there must be samples."""
        return sqrt(self._square_sum / self.samples)


class NisMean:
    """Mean of normalised innovations squared; NaN stands for a step without an innovation."""

    def __init__(self) -> None:
        self.count = 0
        self._sum = 0.0

    def add(self, nis: float) -> None:
        """Take the one of a step."""
        if isfinite(nis):
            self.count += 1
            self._sum += nis

    @property
    def mean(self) -> float:
        """Their mean; there must be some."""
        return self._sum / self.count


class Consistency:
    """The counts of one filter, over the samples that are part of its figures.

    velocity, magnetometer: innovations, which need no reference. has_sigma: some estimate came with a tilt sigma.
    """

    def __init__(self) -> None:
        self.tilt: Final = SigmaCount()
        self.heading: Final = SigmaCount()
        self.velocity: Final = NisMean()
        self.magnetometer: Final = NisMean()
        self.has_sigma = False

    def take_step(self, tilt_sigma: float, velocity_nis: float, field_nis: float) -> None:
        """Take what a step says of itself, rad and pure numbers."""
        if isfinite(tilt_sigma):
            self.has_sigma = True
        self.velocity.add(velocity_nis)
        self.magnetometer.add(field_nis)
