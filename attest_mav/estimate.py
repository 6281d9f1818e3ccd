"""The estimate that one lane gives for one inertial sample; units and frames as in ``types``."""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.innovation import Innovation
from attest_mav.record import Record
from attest_mav.types import North, Quat, Vec3


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Estimate(Record):
    """Attitude of one lane's filter at one IMU sample.

    lane: the IMU message. filter_name: the filter. q_nb: body to NED, sign-continuous. rates: bias-corrected body
    angular rate, rad/s. north: reference of the heading. tilt_sigma, heading_sigma: 1-sigma, rad, NaN where the
    filter has no covariance. dt_s: the step that led here, s. delay_s: how much later than usual the sample came, s.
    innovations: of the aids that had something to say in this step. sigma_is_proven: the sigmas cover the errors in
    flight too. accel_bias: of the accelerometer, m/s^2, body; None where the filter does not estimate it.
    """

    def __init__(
        self,
        lane: str,
        filter_name: str,
        t_ns: int,
        rx_ns: int,
        q_nb: Quat,
        rates: Vec3,
        north: North,
        tilt_sigma: float,
        heading_sigma: float,
        dt_s: float,
        delay_s: float = 0.0,
        innovations: tuple[Innovation, ...] = (),
        sigma_is_proven: bool = False,
        accel_bias: Vec3 | None = None,
    ) -> None:
        self.lane: Final = lane
        self.filter_name: Final = filter_name
        self.t_ns: Final = t_ns
        self.rx_ns: Final = rx_ns
        self.q_nb: Final = q_nb
        self.rates: Final = rates
        self.north: Final = north
        self.tilt_sigma: Final = tilt_sigma
        self.heading_sigma: Final = heading_sigma
        self.dt_s: Final = dt_s
        self.delay_s: Final = delay_s
        self.innovations: Final = innovations
        self.sigma_is_proven: Final = sigma_is_proven
        self.accel_bias: Final = accel_bias
