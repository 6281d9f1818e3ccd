"""What is only assumed, was not seen, or is declared poor is in sigma."""

from math import degrees, hypot

import pytest

from attest_mav.filters.base import FilterInputs
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.vehicle_settings import VehicleSettings

from .conftest import RECEIVER


@pytest.fixture(scope="module")
def settled(plane_log):
    """A filter after thirty seconds of S-turns, and its last sample and inputs."""
    return plane_log.run(last=1500)[-1], plane_log.samples[1499], plane_log.inputs[1499]


def later(sample, seconds):
    t_ns = sample.t_ns + round(seconds * 1e9)
    return ImuSample(sample.source, 1, 1, t_ns, t_ns, sample.gyro, sample.accel, None, quantum=sample.quantum)


@pytest.mark.parametrize("gap_s", [0.3, 0.35])
def test_a_gap_may_have_hidden_a_rotation(settled, gap_s):
    state, sample, _ = settled
    seen = VelocityAided().step(state, gap_s, later(sample, gap_s), FilterInputs(zero_mean_velocity=False))
    unseen = VelocityAided().step(
        state, gap_s, later(sample, gap_s), FilterInputs(zero_mean_velocity=False, samples_missing=True)
    )
    assert degrees(seen.tilt_sigma) < 5.0
    assert unseen.tilt_sigma == pytest.approx(hypot(seen.tilt_sigma, gap_s, gap_s), rel=0.01)


@pytest.mark.parametrize(("dt_s", "missing", "aligned"), [(1.2, False, True), (1.2, True, False), (3.5, False, False)])
def test_a_slow_stream_has_no_gap_in_it(settled, dt_s, missing, aligned):
    state, sample, _ = settled
    inputs = FilterInputs(zero_mean_velocity=False, samples_missing=missing)
    assert VelocityAided().step(state, dt_s, later(sample, dt_s), inputs).aligned is aligned


def test_an_assumed_low_pass_makes_a_turning_heading_uncertain(settled):
    """A corner that the autopilot told is not wrong. After S-turns an assumed one is uncertain by as much as the
    magnetometer's delay leaves it: sigmas of 20 and 30 ms make 16.6 ms."""
    state, sample, inputs = settled
    first, second = (
        ImuSample("RAW_IMU", 1, 1, sample.t_ns + k * 20_000_000, 0, (0.0, 0.0, 6.0), sample.accel, None) for k in (1, 2)
    )
    assumed = VelocityAided()
    told = assumed.with_vehicle_settings(VehicleSettings(low_pass_hz=20.0))
    unsure, sure = (one.step(one.step(state, 0.02, first, inputs), 0.02, second, inputs) for one in (assumed, told))
    lag = hypot(unsure.heading_sigma, unsure.tilt_sigma) ** 2 - hypot(sure.heading_sigma, sure.tilt_sigma) ** 2
    assert lag**0.5 == pytest.approx(0.0166 * 6.0, rel=0.05)


def test_a_fix_that_is_declared_poor_weighs_little_and_contradicts_nothing(settled):
    state, sample, inputs = settled
    fix = inputs.velocity
    t_ns = sample.t_ns + 20_000_000
    moved = (fix.v_ned[0] + 5.0, fix.v_ned[1], 0.0)

    def velocity_after(sigma):
        one = VelocitySample(fix.source, 1, 1, fix.t_ns + 200_000_000, t_ns, moved, False, RECEIVER, sigma)
        sample_then = ImuSample(
            "RAW_IMU", 1, 1, fix.t_ns + 300_000_000, 0, sample.gyro, sample.accel, None, quantum=sample.quantum
        )
        dt_s = (sample_then.t_ns - sample.t_ns) * 1e-9
        return VelocityAided().step(state, dt_s, sample_then, FilterInputs(velocity=one, zero_mean_velocity=False))

    good, poor = velocity_after(None), velocity_after(10.0)
    assert good.navigation.gnss.innovation.nis > 10.0
    assert poor.navigation.gnss.innovation.nis < 1.0
    shift = good.navigation.estimate.velocity[0] - poor.navigation.estimate.velocity[0]
    assert shift > 0.02
