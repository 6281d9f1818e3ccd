"""Consistency of a filter: its errors and innovations, each in units of its own sigma.

The tilt error is a turn about two horizontal axes, and every filter's tilt sigma is the root of the sum of both
variances. So of a consistent filter whose axes are alike 63.2, 98.2 and 99.99 % of the tilt errors lie within 1, 2
and 3 sigma (1 - exp(-k^2)); with all of the error in one axis it would be 68.3, 95.4 and 99.7 %, which is what the
heading error has. The rms of error / sigma is 1 for both: above 1 the sigma is too small, below 1 too large. Errors
are correlated in time, so a short log shows few independent ones. The mean NIS is 1 if the noises are as assumed, and
smaller if the filter allows for correlated errors.
"""

from math import sqrt
from typing import Final

from attest_mav.algebra import is_finite_number
from attest_mav.innovation import Aid, Innovation


class SigmaCount:
    """Counts errors by their size in sigmas."""

    def __init__(self) -> None:
        self.samples = 0
        self._within_1 = 0
        self._within_2 = 0
        self._within_3 = 0
        self._square_sum = 0.0

    def add(self, error: float, sigma: float) -> None:
        """Take an error with its sigma, in one unit. A sigma that is not finite and positive is ignored."""
        if not (is_finite_number(sigma) and sigma > 0.0):
            return
        ratio = error / sigma
        square = ratio * ratio
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
        """Take the NIS of a step."""
        if is_finite_number(nis):
            self.count += 1
            self._sum += nis

    @property
    def mean(self) -> float:
        """The mean; there must be a count."""
        return self._sum / self.count


class Consistency:
    """The counts of one filter, over the samples that are part of its figures."""

    def __init__(self) -> None:
        self.tilt: Final = SigmaCount()
        self.heading: Final = SigmaCount()
        self.velocity: Final = NisMean()
        """Innovations of the velocity, which need no reference."""
        self.magnetometer: Final = NisMean()
        """Innovations of the magnetometer, which need no reference."""
        self.has_sigma = False
        """True once an estimate had a tilt sigma."""

    def take_step(self, tilt_sigma: float, innovations: tuple[Innovation, ...]) -> None:
        """Take the tilt sigma (rad) and the innovations of a step."""
        if is_finite_number(tilt_sigma):
            self.has_sigma = True
        for innovation in innovations:
            if innovation.aid == Aid.VELOCITY:
                self.velocity.add(innovation.nis)
            elif innovation.aid == Aid.MAGNETOMETER:
                self.magnetometer.add(innovation.nis)
