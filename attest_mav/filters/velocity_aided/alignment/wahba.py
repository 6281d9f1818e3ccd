"""Wahba's problem: the attitude that best fits pairs of directions, by Newton's method from that of two of them.

Wahba, A least squares estimate of satellite attitude, SIAM Review 7 (1965); the start is the TRIAD of Shuster and Oh,
Three-axis attitude determination from vector observations, J. Guidance and Control 4 (1981). A closed solution would
need eigenvectors; from a start that is right to some degrees, five Newton steps leave nothing, and give the covariance.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import (
    add,
    cross,
    dot,
    mat_vec,
    norm,
    q_conj,
    q_exp,
    q_from_matrix,
    q_mul,
    q_unit,
    rotate,
    scale,
    unit,
)
from attest_mav.matrices import diagonal, inverse, mat_add, mat_scale, minus_outer
from attest_mav.record import Record
from attest_mav.types import Mat3, Quat, Vec3

STEPS: Final = 5
"""Newton steps: the start is right to a few degrees, and each step squares the error."""
LEAST_ANGLE: Final = 0.08
"""Sine of the angle (5 deg) below which two directions do not make an attitude."""


@mypyc_attr(acyclic=True)
class VectorPair(Record):
    """The same direction seen from the body and in NED."""

    def __init__(self, body: Vec3, world: Vec3, variance: float) -> None:
        self.body: Final = body
        """Unit length."""
        self.world: Final = world
        """NED, unit length."""
        self.variance: Final = variance
        """Of the angle between the two, about each axis, rad^2."""


@mypyc_attr(acyclic=True)
class AttitudeFit(Record):
    """The solution of Wahba's problem."""

    def __init__(self, q_nb: Quat, covariance: Mat3) -> None:
        self.q_nb: Final = q_nb
        """Body to NED."""
        self.covariance: Final = covariance
        """Of its error as a rotation in NED, rad^2."""


def solve_wahba(pairs: list[VectorPair]) -> AttitudeFit | None:
    """The best attitude, None while all pairs lie too near to the first."""
    first = pairs[0]
    second: VectorPair | None = None
    widest = LEAST_ANGLE
    for pair in pairs[1:]:
        angle = min(norm(cross(first.body, pair.body)), norm(cross(first.world, pair.world)))
        if angle > widest:
            widest = angle
            second = pair
    if second is None:
        return None
    q_nb = triad(first, second)
    covariance = diagonal(1.0)
    for _ in range(STEPS):
        information, torque = _normal_equations(q_nb, pairs)
        covariance = inverse(information)
        q_nb = q_unit(q_mul(q_exp(scale(mat_vec(covariance, torque), 0.5)), q_nb))
    return AttitudeFit(q_nb, covariance)


def triad(first: VectorPair, second: VectorPair) -> Quat:
    """The attitude that fits the first pair exactly and the second as well as that allows."""
    return q_mul(_frame(first.world, second.world), q_conj(_frame(first.body, second.body)))


def _frame(x: Vec3, towards: Vec3) -> Quat:
    """The rotation from axes with this first axis, and the second in the plane of both, to those x is given in."""
    z = unit(cross(x, towards))
    y = cross(z, x)
    return q_from_matrix(((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])))


def _normal_equations(q_nb: Quat, pairs: list[VectorPair]) -> tuple[Mat3, Vec3]:
    """Information matrix and gradient for a small turn theta: with c = C b, w - c = theta x c."""
    information = diagonal(0.0)
    torque: Vec3 = (0.0, 0.0, 0.0)
    for pair in pairs:
        c = rotate(q_nb, pair.body)
        weight = 1.0 / pair.variance
        information = mat_add(information, mat_scale(minus_outer(diagonal(dot(c, c)), c, c), weight))
        torque = add(torque, scale(cross(c, pair.world), weight))
    return information, torque
