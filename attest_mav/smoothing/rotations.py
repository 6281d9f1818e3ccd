"""Rotations of many instants at once, as arrays: the forms of ``attest_mav.algebra`` for the last axes of an array."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.types import Vec3

Array = NDArray[np.float64]
"""Vectors have a last axis of 3, quaternions (w, x, y, z) of 4, matrices last axes of 3 by 3."""


def vec3(v: Array) -> Vec3:
    """Three numbers as the compiled core takes them."""
    x, y, z = v.tolist()
    return (x, y, z)


def _levi_civita() -> Array:
    """The 3 by 9 matrix that makes the flat cross matrix of a vector."""
    out = np.zeros((3, 9))
    for axis, (minus, plus) in enumerate(((5, 7), (6, 2), (1, 3))):
        out[axis, minus], out[axis, plus] = -1.0, 1.0
    return out


_CROSS: Final = _levi_civita()
IDENTITY: Final = np.eye(3)
TINY: Final = 1e-30
"""An angle that divides by itself, in the place of zero."""


def multiply(a: Array, b: Array) -> Array:
    """Hamilton products a * b of quaternions."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    out[..., 0] = aw * bw - ax * bx - ay * by - az * bz
    out[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    out[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    out[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return out


def conjugate(q: Array) -> Array:
    """The inverse rotations."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def from_vector(turn: Array) -> Array:
    """The quaternions of rotation vectors, rad."""
    half = 0.5 * np.sqrt((turn * turn).sum(axis=-1))
    out = np.empty((*turn.shape[:-1], 4))
    out[..., 0] = np.cos(half)
    out[..., 1:] = 0.5 * np.sinc(half / np.pi)[..., np.newaxis] * turn
    return out


def matrices(q: Array) -> Array:
    """The rotation matrices of unit quaternions."""
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    out = np.empty((*q.shape[:-1], 3, 3))
    out[..., 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[..., 0, 1] = 2.0 * (x * y - w * z)
    out[..., 0, 2] = 2.0 * (x * z + w * y)
    out[..., 1, 0] = 2.0 * (x * y + w * z)
    out[..., 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[..., 1, 2] = 2.0 * (y * z - w * x)
    out[..., 2, 0] = 2.0 * (x * z - w * y)
    out[..., 2, 1] = 2.0 * (y * z + w * x)
    out[..., 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    return out


def quaternions(matrix: Array) -> Array:
    """The unit quaternions of rotation matrices: the column of 4 q q^T that is largest, normalised."""
    m = matrix
    trace = np.trace(m, axis1=-2, axis2=-1)
    square = np.empty((*m.shape[:-2], 4, 4))
    square[..., 0, 0] = 1.0 + trace
    for axis in range(3):
        square[..., axis + 1, axis + 1] = 1.0 + 2.0 * m[..., axis, axis] - trace
        one, other = (axis + 1) % 3, (axis + 2) % 3
        square[..., 0, axis + 1] = square[..., axis + 1, 0] = m[..., other, one] - m[..., one, other]
        square[..., one + 1, other + 1] = square[..., other + 1, one + 1] = m[..., one, other] + m[..., other, one]
    largest = np.argmax(np.diagonal(square, axis1=-2, axis2=-1), axis=-1)
    return unit(np.take_along_axis(square, largest[..., np.newaxis, np.newaxis], axis=-2)[..., 0, :])


def matrices_of_vectors(turn: Array) -> Array:
    """The rotation matrices of rotation vectors, rad (Rodrigues)."""
    angle = np.sqrt((turn * turn).sum(axis=-1))[..., np.newaxis, np.newaxis] + TINY
    k = cross_matrices(turn)
    half = np.sin(0.5 * angle) / angle
    out: Array = IDENTITY + (np.sin(angle) / angle) * k + (2.0 * half * half) * np.matmul(k, k)
    return out


def vectors_of_matrices(matrix: Array) -> Array:
    """The rotation vectors of rotation matrices, rad, well below half a turn."""
    twice = np.matmul(matrix.reshape(*matrix.shape[:-2], 9), _CROSS.T)
    length = np.sqrt((twice * twice).sum(axis=-1, keepdims=True)) + TINY
    cosine = np.trace(matrix, axis1=-2, axis2=-1)[..., np.newaxis] - 1.0
    return np.asarray(np.arctan2(length, cosine) / length * twice)


def cross_matrices(v: Array) -> Array:
    """[v]x, the matrices with [v]x w = v x w."""
    return np.asarray(np.matmul(v, _CROSS).reshape(*v.shape, 3))


def turned(matrix: Array, v: Array) -> Array:
    """Matrix times vector, for each pair."""
    return np.asarray(np.matmul(matrix, v[..., np.newaxis])[..., 0])


def unit(q: Array) -> Array:
    """The same with length 1."""
    out: Array = q / np.sqrt((q * q).sum(axis=-1, keepdims=True))
    return out
