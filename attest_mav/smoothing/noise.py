"""Classes of measurement noise. The one under which a whole flight is most likely is used for it.

The priors of what lasts (biases, iron, delays) are wide and the same in all classes: one flight cannot show how large
they usually are. A class that joins small noise with small biases is chosen for its noise, and its sigma is then wrong.
(Multiple-model estimation: Maybeck, Stochastic Models, Estimation, and Control, vol. 2, chapter 10.)
"""

from dataclasses import dataclass, replace
from math import radians
from typing import Final

from attest_mav.filters.velocity_aided.parameters import FlightParameters


@dataclass(frozen=True)
class NoiseClass:
    """Standard deviations of the measurements as innovations show them."""

    name: str
    velocity: float
    """m/s."""
    field: float
    """Share of the field."""


CLASSES: Final = (NoiseClass("good", 0.05, 0.004), NoiseClass("typical", 0.14, 0.008), NoiseClass("poor", 0.28, 0.02))
"""From the smallest noise to the largest."""
LASTING_VELOCITY: Final = 16.0
"""Errors of fixes last for seconds, which innovations do not show: the update's variance is larger by this factor. The
likelihood of an innovation is that of the variance without it."""
LASTING_FIELD: Final = 4.0
"""The same of the magnetometer."""
SHARE: Final = 0.25
"""Weight of one innovation in the likelihood, because those that follow each other are alike."""
LARGEST_SQUARE: Final = 36.0
"""A normalised squared innovation counts for no more in the likelihood."""


def with_wide_priors(parameters: FlightParameters) -> FlightParameters:
    """The live filter's parameters for the smoother: sensors may be as poor as any that fly."""
    return replace(
        parameters,
        accel_bias_sigma=max(parameters.accel_bias_sigma, 0.2) if parameters.accel_bias_sigma > 0.0 else 0.0,
        hard_iron=max(parameters.hard_iron, 0.02) if parameters.hard_iron > 0.0 else 0.0,
        gyro_bias_sigma=max(parameters.gyro_bias_sigma, radians(0.7)),
        fix_delay_sigma=max(parameters.fix_delay_sigma, 0.06),
    )
