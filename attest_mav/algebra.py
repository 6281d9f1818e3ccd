"""Vectors, quaternions and small matrices as tuples of floats.

A vector is ``Vec3``, a quaternion ``Quat`` = (w, x, y, z), a matrix ``Mat3`` = three rows. Tuples of fixed length
are unboxed by the compiler, which is why everything here is written out. Quaternions follow Hamilton; see
``attest_mav.types`` for the frames.
"""

from collections.abc import Iterable
from math import acos, asin, atan2, cos, pi, sin, sqrt
from typing import Final

from attest_mav.types import Mat3, Quat, Vec3

_ATAN2: Final = atan2
"""A constant of the module is found faster than an imported name once compiled."""

# --- numbers -------------------------------------------------------------------------------------------------------


def square(x: float) -> float:
    """x x: compiled, the operator ** makes objects of its operands and calls pow()."""
    return x * x


def is_finite_number(x: float) -> bool:
    """True when x is neither NaN nor infinite: compiled, ``math.isfinite`` makes an object of its argument."""
    return x - x == 0.0


def hypotenuse(a: float, b: float) -> float:
    """sqrt(a^2 + b^2), for sizes whose squares are numbers too."""
    return sqrt(a * a + b * b)


def largest(a: float, b: float, c: float) -> float:
    """The largest of three: compiled, max() of more than two makes objects of them."""
    larger = a if a >= b else b
    return larger if larger >= c else c


def median(values: Iterable[float]) -> float:
    """The middle one of the values in order, or the mean of the middle two. Loading ``statistics`` takes 3 ms."""
    ordered = sorted(values)
    middle = len(ordered) // 2
    return ordered[middle] if len(ordered) % 2 else 0.5 * (ordered[middle - 1] + ordered[middle])


# --- vectors -------------------------------------------------------------------------------------------------------


def add(a: Vec3, b: Vec3) -> Vec3:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Vec3, b: Vec3) -> Vec3:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a: Vec3, k: float) -> Vec3:
    """k a."""
    return (k * a[0], k * a[1], k * a[2])


def dot(a: Vec3, b: Vec3) -> float:
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec3, b: Vec3) -> Vec3:
    """Vector product a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def norm(a: Vec3) -> float:
    """Euclidean length."""
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def unit(a: Vec3) -> Vec3:
    """a / |a|; a must not be zero."""
    return scale(a, 1.0 / norm(a))


def unit_axis(axis: int) -> Vec3:
    """The unit vector along axis 0, 1 or 2."""
    return (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)


def is_finite(a: Vec3) -> bool:
    """True when no component is NaN or infinite."""
    return is_finite_number(a[0] + a[1] + a[2])


# --- angles --------------------------------------------------------------------------------------------------------


def wrap_pi(angle: float) -> float:
    """The same angle in (-pi, pi], rad."""
    if -pi < angle <= pi:
        return angle
    if -2.0 * pi <= angle <= 2.0 * pi:
        return angle - 2.0 * pi if angle > 0.0 else angle + 2.0 * pi
    wrapped = angle - 2.0 * pi * float(round(angle / (2.0 * pi)))
    return pi if wrapped <= -pi else wrapped


def clamp(value: float, low: float, high: float) -> float:
    """value, limited to [low, high]."""
    return low if value < low else high if value > high else value


# --- quaternions ---------------------------------------------------------------------------------------------------


def q_mul(a: Quat, b: Quat) -> Quat:
    """Hamilton product a * b."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def q_conj(q: Quat) -> Quat:
    """Conjugate: the inverse rotation of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def q_norm(q: Quat) -> float:
    """Length of the quaternion."""
    return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])


def q_unit(q: Quat) -> Quat:
    """q / |q|; q must not be zero."""
    k = 1.0 / q_norm(q)
    return (k * q[0], k * q[1], k * q[2], k * q[3])


def q_dot(a: Quat, b: Quat) -> float:
    """Inner product of two quaternions."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


def q_exp(u: Vec3) -> Quat:
    """exp of the pure quaternion (0, u): (cos |u|, sin |u| u/|u|). A rotation vector r has q = q_exp(r/2)."""
    angle_sq = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    if angle_sq < 1e-3:
        # Taylor's series: the next terms are below 1e-16 here, nothing is divided by zero, and it is faster.
        c = 1.0 - angle_sq * (0.5 - angle_sq * (1.0 / 24.0 - angle_sq * (1.0 / 720.0)))
        s = 1.0 - angle_sq * (1.0 / 6.0 - angle_sq * (1.0 / 120.0 - angle_sq * (1.0 / 5040.0)))
    else:
        angle = sqrt(angle_sq)
        c = cos(angle)
        s = sin(angle) / angle
    return (c, s * u[0], s * u[1], s * u[2])


def q_continuous(q: Quat, previous: Quat) -> Quat:
    """q or -q (the same rotation), whichever is nearer to ``previous``."""
    return q if q_dot(q, previous) >= 0.0 else (-q[0], -q[1], -q[2], -q[3])


def rotate(q: Quat, v: Vec3) -> Vec3:
    """q * v * conj(q): body to NED for q_nb."""
    return mat_vec(q_to_matrix(q), v)


def rotate_back(q: Quat, v: Vec3) -> Vec3:
    """conj(q) * v * q: NED to body for q_nb."""
    return rotate(q_conj(q), v)


def down_in_body(q: Quat) -> Vec3:
    """C(q)^T e_z: the down direction in body axes; the specific force at rest is -g times it."""
    w, x, y, z = q
    return (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z)


def q_heading(angle: float) -> Quat:
    """Rotation by ``angle`` (rad) about the vertical (NED z)."""
    return (cos(0.5 * angle), 0.0, 0.0, sin(0.5 * angle))


def q_from_euler(roll: float, pitch: float, yaw: float) -> Quat:
    """Quaternion of the yaw-pitch-roll sequence, rad."""
    cr, sr = cos(0.5 * roll), sin(0.5 * roll)
    cp, sp = cos(0.5 * pitch), sin(0.5 * pitch)
    cy, sy = cos(0.5 * yaw), sin(0.5 * yaw)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def q_to_euler(q: Quat) -> Vec3:
    """(roll, pitch, yaw), rad. For showing to people: differences of Euler angles mean nothing near 90 deg pitch."""
    w, x, y, z = q
    return (
        _ATAN2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z),
        asin(clamp(2.0 * (w * y - x * z), -1.0, 1.0)),
        _ATAN2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z),
    )


def tilt_between(a: Quat, b: Quat) -> float:
    """Angle between the gravity directions that two attitudes see in the body, rad."""
    da, db = down_in_body(a), down_in_body(b)
    return _ATAN2(norm(cross(da, db)), dot(da, db))


def heading_between(a: Quat, b: Quat) -> float:
    """Heading of a minus heading of b with their tilt difference set aside, rad in (-pi, pi].

    The angle is that of the turn about the vertical in a * conj(b) (swing-twist), which stays defined where Euler yaw
    does not.
    """
    e = q_mul(a, q_conj(b))
    return wrap_pi(2.0 * _ATAN2(e[3], e[0]))


def angle_of(q: Quat) -> float:
    """Rotation angle of a unit quaternion, rad in [0, pi]."""
    return 2.0 * acos(clamp(abs(q[0]), -1.0, 1.0))


# --- matrices ------------------------------------------------------------------------------------------------------


def q_to_matrix(q: Quat) -> Mat3:
    """C(q): body to NED for q_nb."""
    w, x, y, z = q
    return (
        (w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )


def mat_vec(m: Mat3, v: Vec3) -> Vec3:
    """m v."""
    (a, b, c), (d, e, f), (g, h, i) = m
    x, y, z = v
    return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)


def q_from_matrix(m: Mat3) -> Quat:
    """Unit quaternion of a rotation matrix, w >= 0, by Shepperd's method (the largest component first)."""
    (a, b, c), (d, e, f), (g, h, i) = m
    trace = a + e + i
    if trace >= a and trace >= e and trace >= i:
        q: Quat = (1.0 + trace, h - f, c - g, d - b)
    elif a >= e and a >= i:
        q = (h - f, 1.0 + a - e - i, b + d, c + g)
    elif e >= i:
        q = (c - g, b + d, 1.0 - a + e - i, f + h)
    else:
        q = (d - b, c + g, f + h, 1.0 - a - e + i)
    q = q_unit(q)
    return q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
