"""Motion of a body at one instant.

Attitudes are made of yaw-pitch-roll angles and their rates. Going from those to body rates is regular in every
attitude (only the way back is not), so a tumbling body may pass through any of them.
"""

from math import atan2, cos, hypot, sin

from attest_mav.algebra import q_from_euler, rotate_back
from attest_mav.sim.jets import Jet
from attest_mav.types import G_MPS2, Quat, Vec3


class Motion:
    """The true state at one instant.

    q_nb: body to NED, true north. rates: body angular rate, rad/s. v_ned: m/s. a_ned: acceleration over ground,
    m/s^2 (zero at rest). euler: (roll, pitch, yaw), rad, not wrapped.
    """

    __slots__ = ("a_ned", "euler", "q_nb", "rates", "v_ned")

    def __init__(self, euler: Vec3, rates: Vec3, v_ned: Vec3, a_ned: Vec3) -> None:
        self.euler = euler
        self.rates = rates
        self.v_ned = v_ned
        self.a_ned = a_ned
        self.q_nb: Quat = q_from_euler(*euler)

    def specific_force(self) -> Vec3:
        """f_b = C(q)^T (a_n - g_n), m/s^2: what an ideal accelerometer at the centre of mass reads."""
        a = self.a_ned
        return rotate_back(self.q_nb, (a[0], a[1], a[2] - G_MPS2))


def body_rates(roll: float, pitch: float, euler_rates: Vec3) -> Vec3:
    """Body angular rate, rad/s, from the rates of (roll, pitch, yaw)."""
    d_roll, d_pitch, d_yaw = euler_rates
    sin_roll, cos_roll = sin(roll), cos(roll)
    sin_pitch, cos_pitch = sin(pitch), cos(pitch)
    return (
        d_roll - d_yaw * sin_pitch,
        d_pitch * cos_roll + d_yaw * sin_roll * cos_pitch,
        -d_pitch * sin_roll + d_yaw * cos_roll * cos_pitch,
    )


def lifted_motion(north: Jet, east: Jet, down: Jet, yaw: Jet) -> Motion:
    """A motion whose specific force lies along the body's up axis, as under a multicopter's thrust.

    The body's z axis is then parallel to w = g - a, and with the heading given that fixes roll and pitch; their
    rates follow from the jerk.
    """
    cos_yaw, sin_yaw = cos(yaw[0]), sin(yaw[0])
    # w and its derivative in axes that follow the heading but stay level.
    x = -cos_yaw * north[2] - sin_yaw * east[2]
    y = sin_yaw * north[2] - cos_yaw * east[2]
    z = G_MPS2 - down[2]
    dx = -cos_yaw * north[3] - sin_yaw * east[3] + yaw[1] * y
    dy = sin_yaw * north[3] - cos_yaw * east[3] - yaw[1] * x
    dz = -down[3]
    h = hypot(x, z)
    dh = (x * dx + z * dz) / h
    roll, pitch = atan2(-y, h), atan2(x, z)
    d_roll = (y * dh - dy * h) / (h * h + y * y)
    d_pitch = (dx * z - x * dz) / (h * h)
    return Motion(
        (roll, pitch, yaw[0]),
        body_rates(roll, pitch, (d_roll, d_pitch, yaw[1])),
        (north[1], east[1], down[1]),
        (north[2], east[2], down[2]),
    )
