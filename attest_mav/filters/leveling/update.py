"""The measurements of the leveling filter: the velocity along each axis, and the length of the down vector."""

from math import isinf, nan

from attest_mav.algebra import dot, scale, unit_axis
from attest_mav.filters.base import BodyVelocity
from attest_mav.filters.leveling.model import LevelState, updated
from attest_mav.filters.leveling.state import LengthFusion, VelocityFusion, VelocityModel
from attest_mav.innovation import Aid
from attest_mav.matrices import quadratic
from attest_mav.plausible import MAX_SPEED


def fuse_velocity(x: LevelState, axis: int, measured: float, variance: float) -> tuple[LevelState, float, float]:
    """x after measuring the velocity along one axis of the body, the residual, and its variance."""
    # A tuple of floats is not indexed by a variable: compiled, that would make Python objects of all its elements.
    along = unit_axis(axis)
    residual = measured - dot(along, x.velocity)
    innovation_variance = quadratic(x.p_vv, along) + variance
    return (updated(x, along, (0.0, 0.0, 0.0), residual, variance), residual, innovation_variance)


def hold_velocity(
    x: LevelState, model: VelocityModel, variance: float, due: bool
) -> tuple[LevelState, VelocityModel, VelocityFusion | None]:
    """The measurements of the stationary model, eq. (32), or, with a large variance, of one without a speed."""
    if not due or isinf(variance):
        return (x, model, None)
    x, z_x, s_x = fuse_velocity(x, 0, model.velocity[0], variance)
    x, z_y, s_y = fuse_velocity(x, 1, model.velocity[1], variance)
    x, z_z, s_z = fuse_velocity(x, 2, model.velocity[2], variance)
    aid = Aid.ZERO_VELOCITY if model.stationary else Aid.CONSTANT_VELOCITY
    return (x, model, VelocityFusion(aid, model.velocity, (z_x, z_y, z_z), (s_x, s_y, s_z)))


def fuse_speed(
    x: LevelState, velocity: BodyVelocity, r_speed: float, r_sideslip: float
) -> tuple[LevelState, VelocityFusion]:
    """The measurements of the moving model, eq. (29), with those for a vehicle that goes where it points.

    r_speed, r_sideslip: variances along the nose and across it, (m/s)^2; an infinite one across leaves these out.
    """
    z_y, z_z, s_y, s_z = nan, nan, nan, nan
    x, z_x, s_x = fuse_velocity(x, 0, velocity.forward, r_speed)
    if velocity.lateral_known and not isinf(r_sideslip):
        if abs(velocity.side) < MAX_SPEED:
            x, z_y, s_y = fuse_velocity(x, 1, velocity.side, r_sideslip)
        if abs(velocity.down) < MAX_SPEED:
            x, z_z, s_z = fuse_velocity(x, 2, velocity.down, r_sideslip)
    observation = (velocity.forward, velocity.side, velocity.down)
    return (x, VelocityFusion(Aid.SPEED, observation, (z_x, z_y, z_z), (s_x, s_y, s_z)))


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
