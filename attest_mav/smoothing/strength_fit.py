"""Regression of hard iron by the strength of the field alone, for recordings whose attitudes are not known yet.

The readings u of a body that turns lie on a sphere about the iron b, whatever its attitude: with |u - b| constant,

    (|u|^2 - 1) / 2 = u . b + c,   u and b as shares of the first strength,

which is linear in b and c. A weighted regression with a prior gives b and its covariance; only turning adds to it.
(Ellipsoid fitting: Gebre-Egziabher et al., Journal of Aerospace Engineering 19, 2006.)
"""

from dataclasses import dataclass
from math import sqrt
from typing import Final

from attest_mav.algebra import dot, norm, scale, sub
from attest_mav.filters.velocity_aided.aids import iron_fit
from attest_mav.filters.velocity_aided.aids.iron_fit import Regression
from attest_mav.matrices import minus_outer
from attest_mav.types import Mat3, Vec3

FIELD_NOISE: Final = 0.05
"""Share of the field. 1-sigma of its strength from place to place indoors, at least."""


@dataclass(frozen=True)
class StrengthFit:
    """Weighted moments of the readings while the body turned."""

    first: Vec3
    """The first reading, gauss; its length is the unit of u."""
    turned: float
    """Weight of all readings: the angle through which the body turned, rad."""
    sum_u: Vec3
    """Integral of u."""
    sum_y: float
    """The same of y = (|u|^2 - 1) / 2."""
    sum_uu: Mat3
    """The same of u u^T."""
    sum_uy: Vec3
    """The same of u y."""
    sum_yy: float
    """The same of y^2."""

    @property
    def strength(self) -> float:
        """Of the first reading, gauss."""
        return norm(self.first)


@dataclass(frozen=True)
class FittedIron:
    """The iron by a fit, as shares of its unit."""

    iron: Vec3
    covariance: Mat3
    strength: float
    """Of the field without the iron."""
    unexplained: float
    """The variance of the strength that it leaves, as a share of that which no iron leaves."""


def fitted(fit: StrengthFit) -> FittedIron:
    """The iron by the fit."""
    weight = max(fit.turned, 1e-9)
    mean_u, mean_y = scale(fit.sum_u, 1.0 / weight), fit.sum_y / weight
    regression = Regression(
        weight,
        minus_outer(fit.sum_uu, mean_u, fit.sum_u),
        sub(fit.sum_uy, scale(fit.sum_u, mean_y)),
        fit.sum_yy - fit.sum_y * mean_y,
    )
    found = iron_fit.fitted(regression, FIELD_NOISE)
    iron = found.iron
    # c = (F^2 - 1 - |b|^2) / 2, with the strength F.
    strength_square = 1.0 + dot(iron, iron) + 2.0 * (mean_y - dot(mean_u, iron))
    unexplained = regression.left(iron) / regression.spread if regression.spread > 0.0 else 1.0
    return FittedIron(iron, found.covariance, sqrt(max(strength_square, 0.0)), unexplained)
