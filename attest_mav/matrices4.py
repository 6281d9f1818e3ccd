"""The covariance of a quaternion: 4 x 4 matrices as tuples of rows, like those in ``attest_mav.matrices``."""

from attest_mav.algebra import q_dot
from attest_mav.types import Quat

Mat4 = tuple[Quat, Quat, Quat, Quat]
"""Four rows."""


def diagonal4(k: float) -> Mat4:
    """k I."""
    return ((k, 0.0, 0.0, 0.0), (0.0, k, 0.0, 0.0), (0.0, 0.0, k, 0.0), (0.0, 0.0, 0.0, k))


def scale4(v: Quat, k: float) -> Quat:
    """k v."""
    return (k * v[0], k * v[1], k * v[2], k * v[3])


def add4(a: Quat, b: Quat) -> Quat:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3])


def transpose4(m: Mat4) -> Mat4:
    """m^T."""
    (a, b, c, d), (e, f, g, h), (i, j, k, n), (p, q, r, s) = m
    return ((a, e, i, p), (b, f, j, q), (c, g, k, r), (d, h, n, s))


def mat_vec4(m: Mat4, v: Quat) -> Quat:
    """m v."""
    (a, b, c, d), (e, f, g, h), (i, j, k, n), (p, q, r, s) = m
    w, x, y, z = v
    return (
        a * w + b * x + c * y + d * z,
        e * w + f * x + g * y + h * z,
        i * w + j * x + k * y + n * z,
        p * w + q * x + r * y + s * z,
    )


def rank_one4(m: Mat4, u: Quat, v: Quat) -> Mat4:
    """m + u v^T."""
    (a, b, c, d), (e, f, g, h), (i, j, k, n), (p, q, r, s) = m
    w, x, y, z = v
    t0, t1, t2, t3 = u
    return (
        (a + t0 * w, b + t0 * x, c + t0 * y, d + t0 * z),
        (e + t1 * w, f + t1 * x, g + t1 * y, h + t1 * z),
        (i + t2 * w, j + t2 * x, k + t2 * y, n + t2 * z),
        (p + t3 * w, q + t3 * x, r + t3 * y, s + t3 * z),
    )


def quadratic4(m: Mat4, h: Quat) -> float:
    """h^T m h."""
    return q_dot(h, mat_vec4(m, h))


def correction4(p: Mat4, h: Quat, r: float) -> tuple[Quat, Mat4]:
    """The Kalman gain of one scalar row z = h x + noise of variance r, and the covariance after it (Joseph form).

    k = P h / (h^T P h + r);  P <- (I - k h^T) P (I - k h^T)^T + k r k^T, worked out as M + (r k - M h) k^T with
    M = (I - k h^T) P.
    """
    g = mat_vec4(p, h)
    k = scale4(g, 1.0 / (q_dot(h, g) + r))
    m = rank_one4(p, scale4(k, -1.0), g)
    rest = add4(scale4(k, r), scale4(mat_vec4(m, h), -1.0))
    return (k, rank_one4(m, rest, k))


def symmetric4(m: Mat4) -> Mat4:
    """(m + m^T) / 2."""
    (a, b, c, d), (e, f, g, h), (i, j, k, n), (p, q, r, s) = m
    b, c, d = 0.5 * (b + e), 0.5 * (c + i), 0.5 * (d + p)
    g, h, n = 0.5 * (g + j), 0.5 * (h + q), 0.5 * (n + r)
    return ((a, b, c, d), (b, f, g, h), (c, g, k, n), (d, h, n, s))


def add_diagonal4(m: Mat4, v: float) -> Mat4:
    """m + v I."""
    (a, b, c, d), (e, f, g, h), (i, j, k, n), (p, q, r, s) = m
    return ((a + v, b, c, d), (e, f + v, g, h), (i, j, k + v, n), (p, q, r, s + v))


def floor_diagonal4(m: Mat4, least: float) -> Mat4:
    """m with no element of its diagonal below ``least``."""
    (a, b, c, d), (e, f, g, h), (i, j, k, n), (p, q, r, s) = m
    return ((max(a, least), b, c, d), (e, max(f, least), g, h), (i, j, max(k, least), n), (p, q, r, max(s, least)))


def scaled4(m: Mat4, k: float) -> Mat4:
    """k m."""
    return (scale4(m[0], k), scale4(m[1], k), scale4(m[2], k), scale4(m[3], k))


def largest_variance4(m: Mat4) -> float:
    """Largest element of the diagonal."""
    a, b, c, d = m[0][0], m[1][1], m[2][2], m[3][3]
    first = a if a > b else b
    second = c if c > d else d
    return first if first > second else second


def no_negative_variance4(m: Mat4) -> bool:
    """True while no element of the diagonal is negative or NaN."""
    return m[0][0] >= 0.0 and m[1][1] >= 0.0 and m[2][2] >= 0.0 and m[3][3] >= 0.0
