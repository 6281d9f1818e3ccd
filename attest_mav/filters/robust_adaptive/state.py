"""State and innovation record of the robust adaptive filter."""

from math import inf, nan, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterState
from attest_mav.filters.robust_adaptive.model import attitude_variances
from attest_mav.matrices4 import Mat4
from attest_mav.types import Quat, Vec3


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class RobustAdaptiveState(FilterState):
    """State after a step, with its innovation record.

    covariance: of (w, x, y, z), symmetric. The record has four places: x, y and z of the unit specific force (body)
    and the heading (rad). innovation: measured minus predicted, NaN where there was no reading. inflation: the factor
    on the row's variance, infinite where the row was rejected or absent. alpha: the adaptive factor, in (0, 1].
    disagreement: running mean of the squared standardised innovations, near 1 when the model fits.
    rejected_s: for how long each row has been rejected, s.
    """

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        covariance: Mat4,
        innovation: Quat,
        inflation: Quat,
        alpha: float,
        mean_nis: float,
        rejected_s: Quat,
    ) -> None:
        tilt, heading = attitude_variances(q_nb, covariance)
        super().__init__(q_nb, gyro_bias, accel_used, mag_used, sqrt(max(tilt, 0.0)), sqrt(max(heading, 0.0)))
        self.covariance: Final = covariance
        self.innovation: Final = innovation
        self.inflation: Final = inflation
        self.alpha: Final = alpha
        self.mean_nis: Final = mean_nis
        self.rejected_s: Final = rejected_s


def without_measurement(
    q_nb: Quat, gyro_bias: Vec3, covariance: Mat4, mean_nis: float, rejected_s: Quat
) -> RobustAdaptiveState:
    """A state that no row has led to."""
    nothing: Quat = (nan, nan, nan, nan)
    absent: Quat = (inf, inf, inf, inf)
    return RobustAdaptiveState(q_nb, gyro_bias, False, False, covariance, nothing, absent, 1.0, mean_nis, rejected_s)


def unchanged(before: RobustAdaptiveState) -> RobustAdaptiveState:
    """The state kept as it is."""
    return without_measurement(before.q_nb, before.gyro_bias, before.covariance, before.mean_nis, before.rejected_s)
