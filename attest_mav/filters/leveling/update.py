"""The scalar measurements of the leveling filter: a component of the velocity, and the length of the down vector."""

from attest_mav.algebra import dot, scale, unit_axis
from attest_mav.filters.base import BodyVelocity
from attest_mav.filters.leveling.model import LevelState, updated
from attest_mav.filters.leveling.state import LengthFusion
from attest_mav.matrices import quadratic
from attest_mav.plausible import MAX_SPEED


def fuse_velocity(x: LevelState, axis: int, measured: float, variance: float) -> tuple[LevelState, float, float]:
    """x after measuring the velocity along one axis of the body, the residual, and its variance."""
    # A tuple of floats is not indexed by a variable: compiled, that would make Python objects of all its elements.
    along = unit_axis(axis)
    residual = measured - dot(along, x.velocity)
    innovation_variance = quadratic(x.p_vv, along) + variance
    return (updated(x, along, (0.0, 0.0, 0.0), residual, variance), residual, innovation_variance)


def constrain_length(x: LevelState, variance: float) -> tuple[LevelState, LengthFusion]:
    """x after the constraint that the down vector has unit length."""
    residual = 1.0 - dot(x.down, x.down)
    jacobian = scale(x.down, 2.0)
    record = LengthFusion(residual, quadratic(x.p_dd, jacobian) + variance)
    return (updated(x, (0.0, 0.0, 0.0), jacobian, residual, variance), record)


def lateral_velocity(velocity: BodyVelocity) -> tuple[float, float]:
    """The speeds along the body's y and z, m/s, 0 where one is not known."""
    side = velocity.side if velocity.lateral_known and abs(velocity.side) < MAX_SPEED else 0.0
    return (side, velocity.down if velocity.lateral_known and abs(velocity.down) < MAX_SPEED else 0.0)
