"""Motion between two samples: how long it is remembered, and whom it accuses."""

from math import exp

import pytest

from attest_mav.filters.velocity_aided.aids.gnss_velocity import fuse_velocity
from attest_mav.filters.velocity_aided.imu_memory import ImuMemory, initial_memory
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import predict
from attest_mav.filters.velocity_aided.reading import Reading
from attest_mav.samples import VelocitySample
from attest_mav.types import G_MPS2

from .conftest import RECEIVER, ZERO

REST = Reading(ZERO, (0.0, 0.0, -G_MPS2), saturated=False)
JOLT = Reading(ZERO, (0.0, 0.0, -G_MPS2 - 10.0), saturated=False)


@pytest.fixture(scope="module")
def navigation(plane_log):
    """The navigation after twenty seconds."""
    return plane_log.run(last=1000)[-1].navigation


@pytest.mark.parametrize(("dt_s", "left"), [(0.02, exp(-1.0 / 0.5)), (0.25, exp(-4.0 / 8.0))])
def test_a_jolt_is_remembered_for_half_a_second_or_eight_samples(navigation, dt_s, left):
    """A second after a jolt whose second difference is twice its size, 20 m/s^2."""
    nav, t_ns = navigation.estimate, 0
    memory = initial_memory(nav, REST, t_ns)
    for reading in [REST, JOLT, *[REST] * (round(1.0 / dt_s) + 1)]:
        t_ns += round(dt_s * 1e9)
        nav, memory = predict(nav, memory, reading, dt_s, t_ns, True, FlightParameters())
    assert memory.hidden_acceleration == pytest.approx(20.0 * left, rel=1e-6)


def hiding(imu, accel):
    """The memory of dead reckoning with this much acceleration between its samples, m/s^2."""
    return ImuMemory(
        imu.gyro,
        imu.accel,
        imu.gyro_change,
        imu.accel_change,
        imu.dt_s,
        imu.specific_force,
        imu.gyro_aliasing,
        (0.0, accel, 0.0),
        imu.gyro_white,
        imu.accel_white,
        imu.history,
    )


def test_an_acceleration_between_samples_is_no_contradiction_and_does_not_weaken_the_fix(navigation):
    """0.036 s of 100 m/s^2 are 3.6 m/s; the test allows for them, the update stays as it is."""
    gnss, t_ns = navigation.gnss, navigation.imu.history.newest.t_ns
    north, east, _ = navigation.estimate.velocity
    fix = VelocitySample("GPS_RAW_INT", 1, 1, t_ns, t_ns, (north + 4.0, east, 0.0), False, RECEIVER)
    parameters = FlightParameters(fix_jitter_s=0.036)
    calm_nav, calm = fuse_velocity(navigation.estimate, hiding(navigation.imu, 0.0), gnss, fix, True, parameters)
    nav, shaken = fuse_velocity(navigation.estimate, hiding(navigation.imu, 100.0), gnss, fix, True, parameters)
    assert shaken.innovation.variance[0] - calm.innovation.variance[0] == pytest.approx(3.6**2)
    assert shaken.innovation.nis < 2.0 < calm.innovation.nis
    assert nav.velocity == calm_nav.velocity
