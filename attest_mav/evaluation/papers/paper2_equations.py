"""The equations of paper 2 against what they were made from: gains, Jacobians, and what the printed factors do."""

from dataclasses import replace
from math import nan, sqrt

import numpy as np

from attest_mav.algebra import down_in_body, q_mul, q_to_euler, q_unit
from attest_mav.evaluation.motion import Array
from attest_mav.evaluation.papers.rotation_stand import PRINTED
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
from attest_mav.filters.robust_adaptive.model import measurement_jacobian
from attest_mav.matrices4 import Mat4
from attest_mav.samples import ImuSample
from attest_mav.types import North, Quat

STEP = 1e-5
"""Of the central differences."""


def gain_gap(rng: np.random.Generator) -> float:
    """Largest difference between the corrections by (10) as mended and by the filter's rows, which follow (13)."""
    q = random_quat(rng)
    half = rng.standard_normal((4, 4))
    p = 0.1 * half @ half.T + 0.01 * np.eye(4)
    z = rng.standard_normal(4)
    inflation = rng.uniform(1.0, 5.0, 4)
    alpha = rng.uniform(0.2, 1.0)
    h = np.array(measurement_jacobian(q, vertical=True))
    weight = np.diag(1.0 / (inflation * [0.1, 0.1, 0.1, 0.3]))
    by_information = np.linalg.solve(h.T @ weight @ h + alpha * np.linalg.inv(p), h.T @ weight @ z)
    chosen = RobustAdaptive(r_accel=0.1, r_heading=0.3)
    by_rows, _ = chosen.correction(_mat4(p / alpha), measurement_jacobian(q, vertical=True), _quat(z), _quat(inflation))
    return float(np.abs(np.array(by_rows) - by_information).max())


def jacobian_gap(rng: np.random.Generator) -> float:
    """Largest difference between the measurement rows and central differences, where Euler's heading has some."""
    q = random_quat(rng)
    while abs(q_to_euler(q)[1]) > 1.3:
        q = random_quat(rng)
    numeric = np.column_stack([_difference(q, axis) for axis in range(4)])
    gap = float(np.abs(np.array(measurement_jacobian(q, vertical=False)) - numeric).max())
    return max(gap, *(_vertical_row_gap(q, axis) for axis in range(3)))


def _difference(q: Quat, axis: int) -> Array:
    """Central difference of specific force and heading by one component of the quaternion."""
    shift = STEP * np.eye(4)[axis]
    difference = _predicted(_quat(np.array(q) + shift)) - _predicted(_quat(np.array(q) - shift))
    difference[3] = (difference[3] + np.pi) % (2.0 * np.pi) - np.pi
    return difference / (2.0 * STEP)


def _predicted(q: Quat) -> Array:
    """Unit specific force and heading, h(q)."""
    return np.array([*(-x for x in down_in_body(q)), q_to_euler(q)[2]])


def _vertical_row_gap(q: Quat, axis: int) -> float:
    """How far the vertical heading row is from 1 a radian of turn about the vertical, and 0 about north and east."""
    turn = [0.0, 0.0, 0.0, 0.0]
    turn[axis + 1] = 0.5
    row = np.array(measurement_jacobian(q, vertical=True)[3])
    return float(abs(row @ q_mul(_quat(turn), q) - (1.0 if axis == 2 else 0.0)))


def undone_gain(k: float) -> float:
    """Gain of the printed filter over that of the plain one for one row with P << R that errs by k sigma."""
    printed = replace(PRINTED, p0=1e-12, q_step=0.0)
    plain = replace(printed, robust=False, adaptive=False)
    heading = k * sqrt(printed.r_heading)
    return _turned(printed, heading) / _turned(plain, heading)


def _turned(chosen: RobustAdaptive, heading: float) -> float:
    """How far one reading of the heading alone turns the filter, rad."""
    start = Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.TRUE, (0.0, 0.0, -1.0), None)
    no_accel = ImuSample("STAND", 1, 1, 0, 0, (0.0, 0.0, 0.0), (nan, nan, nan), None)
    return q_to_euler(chosen.step(chosen.initial(start), 0.01, no_accel, FilterInputs(heading=heading)).q_nb)[2]


def random_quat(rng: np.random.Generator) -> Quat:
    """A random attitude."""
    return q_unit(_quat(rng.standard_normal(4)))


def _quat(values: Array | list[float]) -> Quat:
    w, x, y, z = (float(value) for value in values)
    return (w, x, y, z)


def _mat4(m: Array) -> Mat4:
    return (_quat(m[0]), _quat(m[1]), _quat(m[2]), _quat(m[3]))
