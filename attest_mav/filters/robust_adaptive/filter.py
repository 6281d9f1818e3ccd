"""Robust adaptive extended Kalman filter of the attitude quaternion (paper 2).

The state is the quaternion itself. The measurements are the three components of the unit specific force and the
heading. One whose innovation is too large for its variance counts less or not at all (robust, eqs. (15), (16)); when
those that are left still disagree more than they should, the prediction counts less (adaptive, eq. (28)).
With both switched off it is the plain extended Kalman filter. docs/filters/robust-adaptive.md lists the corrections to
the paper, and why the recommended logic is not the printed one.

The filter takes the accelerometer for gravity: it bears outliers, but not a turn that lasts.
"""

from dataclasses import dataclass
from math import inf, isinf, isnan, nan, sqrt
from typing import Final, cast

from attest_mav.algebra import norm, q_exp, q_mul, q_norm, q_unit, scale, sub
from attest_mav.filters.base import MAX_CORRECTION_DT_S, AttitudeFilter, FilterInputs, FilterState, Start
from attest_mav.filters.parameter_check import check_parameters
from attest_mav.filters.robust_adaptive.model import (
    accel_innovation,
    fused,
    heading_innovation,
    measurement_jacobian,
    nominal,
    nominal_nis,
    predicted_covariance,
    present,
    state_variances_of,
)
from attest_mav.filters.robust_adaptive.state import RobustAdaptiveState, unchanged, without_measurement
from attest_mav.matrices4 import (
    Mat4,
    add4,
    diagonal4,
    floor_diagonal4,
    largest_variance4,
    no_negative_variance4,
    scaled4,
    symmetric4,
)
from attest_mav.plausible import is_force, is_rate
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, Quat

MIN_LENGTH: Final = 0.5
"""A quaternion that a correction leaves shorter than this, like a covariance with a negative variance or NaN, is
beyond mending: the attitude becomes NaN, which asks for a new start."""
MIN_VARIANCE: Final = 1e-14
"""Floor of the quaternion's variances."""
MAX_VARIANCE: Final = 1.0
"""No component of a unit quaternion errs by more than this: the adaptive factor inflates no further."""
SATURATION_NOISE: Final = 10.0
"""The process noise of a step with a saturated sensor is this many times the usual."""


_POSITIVE: Final = (
    "c",
    "c_reject",
    "reacquire_s",
    "average_s",
    "max_disagreement",
    "min_alpha",
    "r_accel",
    "r_heading",
    "p0",
)
"""Parameters that are not zero either."""


@dataclass(frozen=True)
class RobustAdaptive(AttitudeFilter):
    """Parameters; the defaults are the recommended logic and noise."""

    printed: bool = False
    """Whether the algorithm runs as the paper prints it: inflation without rejection, the adaptive factor (28) from one
    sample, a heading measurement that turns about all axes. This form is for study of the paper, not for flight."""
    robust: bool = True
    """False sets all inflations to 1."""
    adaptive: bool = True
    """False sets the adaptive factor to 1."""
    c: float = 1.5
    """sigmas. A measurement whose normalised innovation is larger counts less."""
    c_reject: float = 6.0
    """sigmas. A measurement whose normalised innovation is larger is rejected (recommended logic)."""
    reacquire_s: float = 5.0
    """s. If a measurement is rejected continuously for this time, the filter assumes that its own state is wrong and
    accepts the measurement with nominal variance (recommended logic); infinite: never."""
    average_s: float = 0.5
    """s. Length of the mean normalised innovation squared of the measurements that are not inflated."""
    max_disagreement: float = 2.0
    """1. Above this mean the prediction's covariance is inflated."""
    min_alpha: float = 0.2
    """1. To 1 / ``min_alpha`` at most."""
    r_accel: float = 1e-3
    """1. Variance of a component of the unit specific force; too small and accelerations tilt the attitude."""
    r_heading: float = 2.7e-3
    """rad^2. Variance of the heading."""
    gyro_noise: float = 2.7e-7
    """rad^2/s. Power of the gyro's noise, with a share for what is left of its bias."""
    q_step: float = 0.0
    """1. Variance added to each quaternion component a step, as the paper has it; it depends on the rate."""
    p0: float = 1e-4
    """1. Variance of each component at the start."""
    max_accel_error_g: float = 0.3
    """g. The accelerometer is used while its length is this near to 1 g."""

    def __post_init__(self) -> None:
        """Refuse parameters that make no sense."""
        check_parameters(self, positive=_POSITIVE)

    @property
    def name(self) -> str:
        """``robust-adaptive``."""
        return "robust-adaptive"

    def initial(self, start: Start) -> RobustAdaptiveState:
        """Start from the alignment."""
        return without_measurement(start.q_nb, start.gyro_bias, diagonal4(self.p0), 1.0, (0.0, 0.0, 0.0, 0.0))

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> RobustAdaptiveState:
        """One step of (14): predict, weigh the measurements and the prediction, correct.

        Without a usable gyro the state stays as it is.
        """
        before = cast("RobustAdaptiveState", state)
        gyro = sub(sample.gyro, before.gyro_bias)
        if not is_rate(gyro):
            return unchanged(before)
        turn = q_exp(scale(gyro, 0.5 * dt_s))
        q = q_unit(q_mul(before.q_nb, turn))
        noise_factor = SATURATION_NOISE if sample.saturated else 1.0
        noise = 0.25 * noise_factor * self.gyro_noise * dt_s
        p = predicted_covariance(before.covariance, turn, q, noise, noise_factor * self.q_step)

        z = self._residual(q, sample, inputs)
        jacobian = measurement_jacobian(q, not self.printed)
        state_variances = state_variances_of(p, jacobian)
        inflation, rejected_s = self.weigh_measurements(z, state_variances, before.rejected_s, dt_s)
        mean_nis, alpha = self.weigh_prediction(z, state_variances, inflation, before.mean_nis, dt_s)
        alpha = max(alpha, min(1.0, largest_variance4(p) / MAX_VARIANCE))
        p = scaled4(p, 1.0 / alpha)

        dq, p = self.correction(p, jacobian, z, inflation)
        q = add4(q, dq)
        is_sound = q_norm(q) >= MIN_LENGTH and no_negative_variance4(p)
        return RobustAdaptiveState(
            q_unit(q) if is_sound else (nan, nan, nan, nan),
            before.gyro_bias,
            not (isinf(inflation[0]) and isinf(inflation[1]) and isinf(inflation[2])),
            not isinf(inflation[3]),
            floor_diagonal4(p, MIN_VARIANCE),
            z,
            self._innovation_variance(state_variances),
            inflation,
            alpha,
            mean_nis,
            rejected_s,
            sample,
        )

    def _residual(self, q: Quat, sample: ImuSample, inputs: FilterInputs) -> Quat:
        """Measured minus predicted, eq. (17); NaN for a measurement without a usable reading."""
        heading = heading_innovation(q, sample.mag, inputs.heading)
        length = norm(sample.accel)
        in_gate = abs(length / G_MPS2 - 1.0) <= self.max_accel_error_g
        if sample.saturated or not in_gate or not is_force(sample.accel) or length == 0.0:
            return (nan, nan, nan, heading)
        x, y, z = accel_innovation(q, sample.accel)
        return (x, y, z, heading)

    def _innovation_variance(self, state_variances: Quat) -> Quat:
        """Variances of the residuals, the state's and the measurement's before any inflation."""
        x, y, z, heading = state_variances
        return (x + self.r_accel, y + self.r_accel, z + self.r_accel, heading + self.r_heading)

    def weigh_measurements(self, z: Quat, state_variances: Quat, rejected_s: Quat, dt_s: float) -> tuple[Quat, Quat]:
        """The inflation of every measurement, eq. (16), and for how long each has been rejected, s.

        state_variances: diagonal of H P H^T.
        """
        x, wait_x = self._weigh_measurement(z[0], state_variances[0] + self.r_accel, rejected_s[0], dt_s)
        y, wait_y = self._weigh_measurement(z[1], state_variances[1] + self.r_accel, rejected_s[1], dt_s)
        down, wait_down = self._weigh_measurement(z[2], state_variances[2] + self.r_accel, rejected_s[2], dt_s)
        heading, wait_heading = self._weigh_measurement(z[3], state_variances[3] + self.r_heading, rejected_s[3], dt_s)
        return ((x, y, down, heading), (wait_x, wait_y, wait_down, wait_heading))

    def _weigh_measurement(self, z: float, variance: float, rejected_s: float, dt_s: float) -> tuple[float, float]:
        """The inflation of a measurement whose innovation z should have ``variance``, and for how long it is rejected.

        If a measurement is rejected continuously for ``reacquire_s``, the filter assumes that its own state is wrong
        and accepts the measurement with nominal variance until it agrees. Accepting it by degrees would reset the time
        and stall.
        """
        if isnan(z) or not variance > 0.0:
            return (inf, rejected_s)
        size = abs(z) / sqrt(variance)
        if not self.robust or size <= self.c:
            return (1.0, 0.0)
        if self.printed:
            return (size / self.c, 0.0)
        if rejected_s >= self.reacquire_s:
            return (1.0, rejected_s)
        if size < self.c_reject:
            return (size / self.c, 0.0)
        return (inf, rejected_s + dt_s)

    def weigh_prediction(
        self, z: Quat, state_variances: Quat, inflation: Quat, mean_nis: float, dt_s: float
    ) -> tuple[float, float]:
        """The mean normalised innovation squared of the measurements that are not inflated, and the factor alpha."""
        if not self.adaptive:
            return (mean_nis, 1.0)
        if self.printed:
            return (mean_nis, self._printed_alpha(z, state_variances, inflation))
        r = self.r_accel
        total = (
            nominal_nis(z[0], state_variances[0] + r, inflation[0])
            + nominal_nis(z[1], state_variances[1] + r, inflation[1])
            + nominal_nis(z[2], state_variances[2] + r, inflation[2])
            + nominal_nis(z[3], state_variances[3] + self.r_heading, inflation[3])
        )
        count = nominal(inflation[0]) + nominal(inflation[1]) + nominal(inflation[2]) + nominal(inflation[3])
        if count == 0.0:
            return (mean_nis, 1.0)
        gain = min(1.0, min(dt_s, MAX_CORRECTION_DT_S) / self.average_s)
        mean_nis += gain * (total / count - mean_nis)
        if mean_nis <= self.max_disagreement:
            return (mean_nis, 1.0)
        return (mean_nis, max(self.min_alpha, self.max_disagreement / mean_nis))

    def _printed_alpha(self, z: Quat, state_variances: Quat, inflation: Quat) -> float:
        """(28): the trace of the expected innovation covariance over that of one sample's."""
        r = self.r_accel
        expected = (
            present(z[0], state_variances[0] + inflation[0] * r)
            + present(z[1], state_variances[1] + inflation[1] * r)
            + present(z[2], state_variances[2] + inflation[2] * r)
            + present(z[3], state_variances[3] + inflation[3] * self.r_heading)
        )
        seen = (
            present(z[0], z[0] * z[0])
            + present(z[1], z[1] * z[1])
            + present(z[2], z[2] * z[2])
            + present(z[3], z[3] * z[3])
        )
        return expected / seen if seen > expected else 1.0

    def correction(self, p: Mat4, jacobian: Mat4, z: Quat, inflation: Quat) -> tuple[Quat, Mat4]:
        """The correction of the quaternion, and the covariance after the measurements in use, one after the other.

        With independent noises this equals (14) with all measurements at once.
        """
        r = self.r_accel
        dq: Quat = (0.0, 0.0, 0.0, 0.0)
        dq, p = fused(dq, p, jacobian[0], z[0], inflation[0] * r)
        dq, p = fused(dq, p, jacobian[1], z[1], inflation[1] * r)
        dq, p = fused(dq, p, jacobian[2], z[2], inflation[2] * r)
        dq, p = fused(dq, p, jacobian[3], z[3], inflation[3] * self.r_heading)
        return (dq, symmetric4(p))
