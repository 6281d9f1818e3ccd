"""Random numbers: every sensor has a generator of its own, so that what one draws changes nothing for the others."""

from random import Random

from attest_mav.types import Vec3


def generator(*words: str) -> Random:
    """The generator that these words seed."""
    return Random(" ".join(words))  # noqa: S311  # a simulation, no secret


def noise(rng: Random, sigma: float) -> Vec3:
    """Three independent normal numbers."""
    gauss = rng.gauss
    return (gauss(0.0, sigma), gauss(0.0, sigma), gauss(0.0, sigma))
