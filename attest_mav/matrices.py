"""Covariances: small matrices as tuples of rows.

A covariance of several vectors is kept in blocks of 3 x 3, each named after the two vectors that it relates: the
propagation then reads like its equations and skips the zeros. Every function returns a new value. The functions are
those that the filters need, written out because the compiler unboxes tuples of fixed length, and only these.
"""

from math import cos, sin, sqrt

from attest_mav.algebra import dot
from attest_mav.types import Mat3, Vec3


def diagonal(k: float) -> Mat3:
    """k I."""
    return ((k, 0.0, 0.0), (0.0, k, 0.0), (0.0, 0.0, k))


def transpose(m: Mat3) -> Mat3:
    """m^T."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((a, d, g), (b, e, h), (c, f, i))


def mat_add(a: Mat3, b: Mat3) -> Mat3:
    """a + b."""
    (a1, a2, a3), (a4, a5, a6), (a7, a8, a9) = a
    (b1, b2, b3), (b4, b5, b6), (b7, b8, b9) = b
    return ((a1 + b1, a2 + b2, a3 + b3), (a4 + b4, a5 + b5, a6 + b6), (a7 + b7, a8 + b8, a9 + b9))


def mat_scale(m: Mat3, k: float) -> Mat3:
    """k m."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((k * a, k * b, k * c), (k * d, k * e, k * f), (k * g, k * h, k * i))


def mat_t_vec(m: Mat3, v: Vec3) -> Vec3:
    """m^T v."""
    (a, b, c), (d, e, f), (g, h, i) = m
    x, y, z = v
    return (a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z)


def mat_mul(m: Mat3, n: Mat3) -> Mat3:
    """m n."""
    (a, b, c), (d, e, f), (g, h, i) = m
    (p, q, r), (s, t, u), (x, y, z) = n
    return (
        (a * p + b * s + c * x, a * q + b * t + c * y, a * r + b * u + c * z),
        (d * p + e * s + f * x, d * q + e * t + f * y, d * r + e * u + f * z),
        (g * p + h * s + i * x, g * q + h * t + i * y, g * r + h * u + i * z),
    )


def mat_mul_t(m: Mat3, n: Mat3) -> Mat3:
    """m n^T."""
    return mat_mul(m, transpose(n))


def minus_outer(m: Mat3, u: Vec3, v: Vec3) -> Mat3:
    """m - u v^T."""
    (a, b, c), (d, e, f), (g, h, i) = m
    p, q, r = u
    x, y, z = v
    return (
        (a - p * x, b - p * y, c - p * z),
        (d - q * x, e - q * y, f - q * z),
        (g - r * x, h - r * y, i - r * z),
    )


def minus_mul(m: Mat3, a: Mat3, b: Mat3) -> Mat3:
    """m - a b."""
    (a1, a2, a3), (a4, a5, a6), (a7, a8, a9) = a
    (b1, b2, b3), (b4, b5, b6), (b7, b8, b9) = b
    (m1, m2, m3), (m4, m5, m6), (m7, m8, m9) = m
    return (
        (m1 - a1 * b1 - a2 * b4 - a3 * b7, m2 - a1 * b2 - a2 * b5 - a3 * b8, m3 - a1 * b3 - a2 * b6 - a3 * b9),
        (m4 - a4 * b1 - a5 * b4 - a6 * b7, m5 - a4 * b2 - a5 * b5 - a6 * b8, m6 - a4 * b3 - a5 * b6 - a6 * b9),
        (m7 - a7 * b1 - a8 * b4 - a9 * b7, m8 - a7 * b2 - a8 * b5 - a9 * b8, m9 - a7 * b3 - a8 * b6 - a9 * b9),
    )


def minus_mul_t(m: Mat3, a: Mat3, b: Mat3) -> Mat3:
    """m - a b^T."""
    return minus_mul(m, a, transpose(b))


def minus_cross(m: Mat3, u: Vec3, n: Mat3) -> Mat3:
    """m - [u]x n, where [u]x w is the cross product u x w."""
    x, y, z = u
    (n1, n2, n3), (n4, n5, n6), (n7, n8, n9) = n
    (m1, m2, m3), (m4, m5, m6), (m7, m8, m9) = m
    return (
        (m1 + z * n4 - y * n7, m2 + z * n5 - y * n8, m3 + z * n6 - y * n9),
        (m4 - z * n1 + x * n7, m5 - z * n2 + x * n8, m6 - z * n3 + x * n9),
        (m7 + y * n1 - x * n4, m8 + y * n2 - x * n5, m9 + y * n3 - x * n6),
    )


def plus_scaled_rows(m: Mat3, k: Vec3, n: Mat3) -> Mat3:
    """m + K n, with K the diagonal matrix of k."""
    (a, b, c), (d, e, f), (g, h, i) = m
    (r, s, t), (u, v, w), (x, y, z) = n
    p, q, o = k
    return (
        (a + p * r, b + p * s, c + p * t),
        (d + q * u, e + q * v, f + q * w),
        (g + o * x, h + o * y, i + o * z),
    )


def plus_scaled(m: Mat3, k: float, n: Mat3) -> Mat3:
    """m + k n."""
    (a, b, c), (d, e, f), (g, h, i) = m
    (r, s, t), (u, v, w), (x, y, z) = n
    return (
        (a + k * r, b + k * s, c + k * t),
        (d + k * u, e + k * v, f + k * w),
        (g + k * x, h + k * y, i + k * z),
    )


def inverse(m: Mat3) -> Mat3:
    """m^-1 by cofactors; m must not be singular."""
    (a, b, c), (d, e, f), (g, h, i) = m
    p, q, r = e * i - f * h, f * g - d * i, d * h - e * g
    k = 1.0 / (a * p + b * q + c * r)
    return (
        (k * p, k * (c * h - b * i), k * (b * f - c * e)),
        (k * q, k * (a * i - c * g), k * (c * d - a * f)),
        (k * r, k * (b * g - a * h), k * (a * e - b * d)),
    )


def add_diagonal(m: Mat3, k: float) -> Mat3:
    """m + k I."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((a + k, b, c), (d, e + k, f), (g, h, i + k))


def rotated_diagonal(m: Mat3, k: Vec3) -> Mat3:
    """M diag(k) M^T: the covariance of independent axes, turned by M."""
    a, b, c = m
    xx = a[0] * a[0] * k[0] + a[1] * a[1] * k[1] + a[2] * a[2] * k[2]
    xy = a[0] * b[0] * k[0] + a[1] * b[1] * k[1] + a[2] * b[2] * k[2]
    xz = a[0] * c[0] * k[0] + a[1] * c[1] * k[1] + a[2] * c[2] * k[2]
    yy = b[0] * b[0] * k[0] + b[1] * b[1] * k[1] + b[2] * b[2] * k[2]
    yz = b[0] * c[0] * k[0] + b[1] * c[1] * k[1] + b[2] * c[2] * k[2]
    zz = c[0] * c[0] * k[0] + c[1] * c[1] * k[1] + c[2] * c[2] * k[2]
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def floor_diagonal(m: Mat3, least: float) -> Mat3:
    """m with no element of its diagonal below ``least``."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((max(a, least), b, c), (d, max(e, least), f), (g, h, max(i, least)))


def no_negative_variance(m: Mat3) -> bool:
    """True while no element of the diagonal is negative or NaN."""
    return m[0][0] >= 0.0 and m[1][1] >= 0.0 and m[2][2] >= 0.0


def symmetric(m: Mat3) -> Mat3:
    """(m + m^T) / 2: rounding must not make a covariance lopsided."""
    (a, b, c), (d, e, f), (g, h, i) = m
    b, c, f = 0.5 * (b + d), 0.5 * (c + g), 0.5 * (f + h)
    return ((a, b, c), (b, e, f), (c, f, i))


def largest_variance(m: Mat3) -> float:
    """Largest element of the diagonal."""
    a, b, c = m[0][0], m[1][1], m[2][2]
    largest = a if a > b else b
    return largest if largest > c else c


def trace(m: Mat3) -> float:
    """Sum of the diagonal."""
    return m[0][0] + m[1][1] + m[2][2]


def quadratic(m: Mat3, h: Vec3) -> float:
    """h^T m h."""
    return dot(h, (dot(m[0], h), dot(m[1], h), dot(m[2], h)))


def axes_turn(angle: Vec3) -> Mat3:
    """exp(-[angle]x): the change of a fixed vector's coordinates when the axes turn by ``angle``, rad.

    Rodrigues: I - a [u]x + b [u]x^2, with a = sin t / t and b = (1 - cos t) / t^2 for the angle t.
    """
    x, y, z = angle
    xx, yy, zz = x * x, y * y, z * z
    t2 = xx + yy + zz
    if t2 < 0.01:
        # The next terms are below 1e-17 here; a step at the rates of a vehicle never takes the other branch.
        a = 1.0 - t2 * (1.0 / 6.0 - t2 * (1.0 / 120.0 - t2 * (1.0 / 5040.0 - t2 * (1.0 / 362880.0))))
        b = 0.5 - t2 * (1.0 / 24.0 - t2 * (1.0 / 720.0 - t2 * (1.0 / 40320.0 - t2 * (1.0 / 3628800.0))))
    else:
        t = sqrt(t2)
        a = sin(t) / t
        b = (1.0 - cos(t)) / t2
    ax, ay, az = a * x, a * y, a * z
    bxy, bxz, byz = b * x * y, b * x * z, b * y * z
    return (
        (1.0 - b * (yy + zz), bxy + az, bxz - ay),
        (bxy - az, 1.0 - b * (xx + zz), byz + ax),
        (bxz + ay, byz - ax, 1.0 - b * (xx + yy)),
    )
