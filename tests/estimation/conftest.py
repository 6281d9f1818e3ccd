"""Samples made by hand for the estimation tests: a vehicle that turns about the vertical at a steady rate."""

from collections.abc import Callable
from math import cos, sin

import pytest

from attest_mav.samples import AttitudeSample, ImuSample
from attest_mav.types import G_MPS2, AttitudeForm, AttitudeRole, Quat, Vec3

MakeImu = Callable[..., ImuSample]
MakeAttitude = Callable[..., AttitudeSample]

FIELD_NED = (0.24, 0.0, -0.5)
"""A southern field, gauss, north component along magnetic north."""


def body_field(yaw: float) -> Vec3:
    """FIELD_NED in the axes of a level vehicle with that heading."""
    n, _, d = FIELD_NED
    return (n * cos(yaw), -n * sin(yaw), d)


@pytest.fixture
def imu() -> MakeImu:
    """imu(t_s, yaw=..., rate=..., ...): a level vehicle's reading."""

    def make(
        t_s: float,
        yaw: float = 0.0,
        rate: float = 0.0,
        accel: Vec3 = (0.0, 0.0, -G_MPS2),
        field: bool = True,
        source: str = "RAW_IMU",
        gyro: Vec3 | None = None,
    ) -> ImuSample:
        t_ns = round(t_s * 1e9)
        mag = body_field(yaw) if field else None
        return ImuSample(source, 1, 1, t_ns, t_ns, gyro or (0.0, 0.0, rate), accel, mag)

    return make


@pytest.fixture
def attitude() -> MakeAttitude:
    """attitude(t_s, q): what the autopilot says."""

    def make(t_s: float, q_nb: Quat, source: str = "ATTITUDE") -> AttitudeSample:
        t_ns = round(t_s * 1e9)
        form = AttitudeForm.QUATERNION if source == "ATTITUDE_QUATERNION" else AttitudeForm.EULER
        return AttitudeSample(source, 1, 1, t_ns, t_ns, q_nb, (0.0, 0.0, 0.0), AttitudeRole.AUTOPILOT, form)

    return make
