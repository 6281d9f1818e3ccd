"""ArduPilot's trim in the attitudes that it reports, in the form of each message: by its own formulas.

The inertial messages and the truth are without it.
"""

from attest_mav.algebra import q_conj, q_exp, q_from_euler, q_mul, q_to_euler, scale, sub
from attest_mav.types import Quat, Vec3


def trimmed_angles(q_nb: Quat, trim: Vec3) -> Vec3:
    """ATTITUDE: the trim is subtracted from roll, pitch and yaw, rad; nothing is wrapped."""
    return sub(q_to_euler(q_nb), trim)


def trimmed_quaternion(q_nb: Quat, trim: Vec3) -> Quat:
    """ATTITUDE_QUATERNION: turned back by the trim as one rotation vector."""
    return q_mul(q_nb, q_exp(scale(trim, -0.5)))


def trimmed_matrix(q_nb: Quat, trim: Vec3) -> Quat:
    """AHRS2: turned back by the rotation of the trim's three angles."""
    return q_mul(q_nb, q_conj(q_from_euler(trim[0], trim[1], trim[2])))
