"""State of the robust adaptive filter, and the records of its step."""

from math import inf, isinf, isnan, nan, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import norm, scale
from attest_mav.filters.base import FilterState
from attest_mav.filters.robust_adaptive.model import attitude_variances
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.matrices4 import Mat4
from attest_mav.samples import ImuSample
from attest_mav.types import Quat, Vec3


@mypyc_attr(acyclic=True, free_list_len=1)  # as GradientDescentState
class RobustAdaptiveState(FilterState):
    """State after a step.

    The vectors of four belong to x, y and z of the unit specific force (body) and the heading (rad).
    """

    def __init__(
        self,
        q_nb: Quat,
        gyro_bias: Vec3,
        accel_used: bool,
        mag_used: bool,
        covariance: Mat4,
        residual: Quat,
        innovation_variance: Quat,
        inflation: Quat,
        alpha: float,
        mean_nis: float,
        rejected_s: Quat,
        sample: ImuSample | None,
    ) -> None:
        tilt, heading = attitude_variances(q_nb, covariance)
        super().__init__(q_nb, gyro_bias, accel_used, mag_used, sqrt(max(tilt, 0.0)), sqrt(max(heading, 0.0)))
        self.covariance: Final = covariance
        """Of (w, x, y, z), symmetric."""
        self.residual: Final = residual
        """Measured minus predicted, NaN where there was no usable reading."""
        self.innovation_variance: Final = innovation_variance
        """Of the residuals, before any inflation."""
        self.inflation: Final = inflation
        """Factor on the measurement's variance, infinite where it was rejected or absent."""
        self.alpha: Final = alpha
        """The adaptive factor, in (0, 1]."""
        self.mean_nis: Final = mean_nis
        """Running mean of the normalised innovation squared, near 1 when the model fits."""
        self.rejected_s: Final = rejected_s
        """For how long each measurement has been rejected, s."""
        self.sample: Final = sample
        """The sample of the step, None before the first and where the gyro could not be used."""

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """Gravity and heading of this step, made when they are asked for."""
        sample = self.sample
        if sample is None:
            return ()
        gravity = self._gravity(sample)
        if isnan(self.residual[3]):
            if sample.mag is None:
                return (gravity,)
            return (gravity, Innovation(Aid.HEADING, Fusion.IMPLAUSIBLE, sample.t_ns))
        residual, variance = (self.residual[3],), (self.innovation_variance[3],)
        return (gravity, Innovation(Aid.HEADING, _fusion(self.inflation[3]), sample.t_ns, (), residual, variance))

    def _gravity(self, sample: ImuSample) -> Innovation:
        """The record of the accelerometer: its components are judged one by one, and the record says the worst."""
        x, y, z, _ = self.residual
        if isnan(x):
            return Innovation(Aid.GRAVITY, Fusion.IMPLAUSIBLE, sample.t_ns)
        observation = scale(sample.accel, 1.0 / norm(sample.accel))
        v_x, v_y, v_z, _ = self.innovation_variance
        worst = max(self.inflation[0], self.inflation[1], self.inflation[2])
        return Innovation(Aid.GRAVITY, _fusion(worst), sample.t_ns, observation, (x, y, z), (v_x, v_y, v_z))


def _fusion(inflation: float) -> Fusion:
    """The fate of a measurement with this inflation."""
    if isinf(inflation):
        return Fusion.OUTSIDE_GATE
    return Fusion.INFLATED if inflation > 1.0 else Fusion.USED


def without_measurement(
    q_nb: Quat, gyro_bias: Vec3, covariance: Mat4, mean_nis: float, rejected_s: Quat
) -> RobustAdaptiveState:
    """A state that no measurement has led to."""
    nothing: Quat = (nan, nan, nan, nan)
    absent: Quat = (inf, inf, inf, inf)
    return RobustAdaptiveState(
        q_nb, gyro_bias, False, False, covariance, nothing, nothing, absent, 1.0, mean_nis, rejected_s, None
    )


def unchanged(before: RobustAdaptiveState) -> RobustAdaptiveState:
    """The state as it was, after a step without a usable gyro."""
    return without_measurement(before.q_nb, before.gyro_bias, before.covariance, before.mean_nis, before.rejected_s)
