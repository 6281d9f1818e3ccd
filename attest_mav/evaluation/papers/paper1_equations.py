"""The equations of paper 1 written out as they are printed (misprints mended), to hold the filter against.

Nothing here is shared with the filter: misfit (14) and Jacobian (15) are for any field direction, and the complete
filter (26)-(30) keeps its two attitudes apart until they are blended.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Final

import numpy as np

from attest_mav.evaluation.motion import Array
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import FixedField, GradientDescent
from attest_mav.filters.gradient_descent.gradients import full_gradient, gravity_gradient
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North, Quat, Vec3

GRAVITY: Final = np.array([0.0, 0.0, 1.0])
ZERO: Final[Vec3] = (0.0, 0.0, 0.0)
AXES: Final[tuple[Vec3, ...]] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
DIFFERENCE: Final = 1e-6
"""Half the step of the central differences: their error is near 1e-10."""


def misfit(q: Array, d: Array, s: Array) -> Array:
    """f of (14): the direction d, NED, that q predicts in the body, minus the measured s."""
    q1, q2, q3, q4 = q
    predicted = (
        2 * d[0] * (0.5 - q3**2 - q4**2) + 2 * d[1] * (q1 * q4 + q2 * q3) + 2 * d[2] * (q2 * q4 - q1 * q3),
        2 * d[0] * (q2 * q3 - q1 * q4) + 2 * d[1] * (0.5 - q2**2 - q4**2) + 2 * d[2] * (q1 * q2 + q3 * q4),
        2 * d[0] * (q1 * q3 + q2 * q4) + 2 * d[1] * (q3 * q4 - q1 * q2) + 2 * d[2] * (0.5 - q2**2 - q3**2),
    )
    return np.array(predicted) - s


def jacobian(q: Array, d: Array) -> Array:
    """J of (15), shape (3, 4)."""
    q1, q2, q3, q4 = q
    x, y, z = 2 * d
    return np.array(
        [
            [y * q4 - z * q3, y * q3 + z * q4, -2 * x * q3 + y * q2 - z * q1, -2 * x * q4 + y * q1 + z * q2],
            [-x * q4 + z * q2, x * q3 - 2 * y * q2 + z * q1, x * q2 + z * q4, -x * q1 - 2 * y * q4 + z * q3],
            [x * q3 - y * q2, x * q4 - y * q1 - 2 * z * q2, x * q1 + y * q4 - 2 * z * q3, x * q2 + y * q3],
        ]
    )


def differences(q: Array, d: Array) -> Array:
    """The same by central differences of the misfit."""
    steps = DIFFERENCE * np.eye(4)
    columns = [misfit(q + step, d, np.zeros(3)) - misfit(q - step, d, np.zeros(3)) for step in steps]
    return np.column_stack(columns) / (2 * DIFFERENCE)


@dataclass(frozen=True, eq=False)
class Reading:
    """One random reading: angular rate, and unit directions of the measured gravity and field, body."""

    gyro: Array
    down: Array
    mag: Array


def complete_step(q: Array, reading: Reading, field: Array, beta: float, alpha: float, dt_s: float) -> Array:
    """(26)-(30): the attitude after one step of the complete filter with accelerometer and magnetometer."""
    f_g, f_b = misfit(q, GRAVITY, reading.down), misfit(q, field, reading.mag)
    gradient = jacobian(q, GRAVITY).T @ f_g + jacobian(q, field).T @ f_b  # (25)
    rate = q_rate(q, reading.gyro)
    mu = alpha * float(np.linalg.norm(rate)) * dt_s  # (28)
    gamma = beta / (mu / dt_s + beta)  # (30)
    descended = q - mu * gradient / np.linalg.norm(gradient)  # (26)
    turned = q + rate * dt_s  # (9)
    blended = gamma * descended + (1 - gamma) * turned  # (29)
    return unit(blended)


def q_rate(q: Array, gyro: Array) -> Array:
    """(7): half of q times (0, gyro)."""
    w, x, y, z = q
    matrix = np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
    return 0.5 * matrix @ gyro


def identity_gap(rng: np.random.Generator) -> float:
    """Largest component of the difference between ``complete_step`` and the filter's own, for one random case."""
    q, field = unit(rng.standard_normal(4)), random_field(rng)
    reading = Reading(rng.standard_normal(3), unit(rng.standard_normal(3)), unit(rng.standard_normal(3)))
    beta, alpha, dt_s = rng.uniform(0.005, 0.5), rng.uniform(1.0, 200.0), rng.uniform(0.002, 0.05)
    chosen = GradientDescent(beta=beta, full_fusion=True, alpha=alpha, exponential=False, field=field)
    accel, mag = _vec(-G_MPS2 * reading.down), _vec(reading.mag)
    sample = ImuSample("RANDOM", 1, 1, 0, 0, _vec(reading.gyro), accel, mag)
    state = chosen.initial(Start(_quat(q), ZERO, North.TRUE, accel, mag))
    ours = np.array(chosen.step(state, dt_s, sample, FilterInputs()).q_nb)
    return float(np.max(np.abs(ours - complete_step(q, reading, _direction(field), beta, alpha, dt_s))))


def jacobian_gap(rng: np.random.Generator) -> float:
    """Largest entry of the filter's Jacobians minus their central differences, for one random attitude and field.

    The filter's gradients are linear in the misfit: those of the three unit misfits are the rows of its Jacobian.
    """
    q, field = unit(rng.standard_normal(4)), random_field(rng)
    gravity_rows = np.array([gravity_gradient(_quat(q), axis) for axis in AXES])
    field_rows = np.array([full_gradient(_quat(q), ZERO, axis, field.b_x, field.b_z) for axis in AXES])
    gaps = (gravity_rows - differences(q, GRAVITY), field_rows - differences(q, _direction(field)))
    return float(np.max(np.abs(gaps)))


def unit(v: Array) -> Array:
    """v / |v|."""
    return np.asarray(v / np.linalg.norm(v))


def random_field(rng: np.random.Generator) -> FixedField:
    """A unit field of any dip that leaves a tenth of it horizontal."""
    b_z = rng.uniform(-0.995, 0.995)
    return FixedField(sqrt(1.0 - b_z * b_z), b_z)


def _direction(field: FixedField) -> Array:
    return np.array([field.b_x, 0.0, field.b_z])


def _vec(v: Array) -> Vec3:
    return (float(v[0]), float(v[1]), float(v[2]))


def _quat(q: Array) -> Quat:
    return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))
