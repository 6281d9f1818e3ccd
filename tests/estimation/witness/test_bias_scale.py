"""The scale of the accelerometers' biases by the difference of two sensors that stand side by side."""

import pytest

from attest_mav.estimation.witness.bias_scale import follow_scale
from attest_mav.estimation.witness.dispute import LanePair
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.samples import ImuSample
from attest_mav.types import North

STEP_NS = 20_000_000
FIELD = (0.2, 0.0, 0.4)
ONE = VelocityAided(FlightParameters(accel_bias_sigma=0.12))


def stands_side_by_side(bias):
    """Two lanes after three seconds on the ground; the second accelerometer reads more by ``bias``."""
    lanes = [LaneWatch(name) for name in ("RAW_IMU", "SCALED_IMU2")]
    pair = LanePair(*lanes)
    states = {}
    for k in range(150):
        for lane, more in zip(lanes, ((0.0, 0.0, 0.0), bias), strict=True):
            force = (more[0], more[1], more[2] - 9.80665 - 1e-3 * (k % 2))
            sample = ImuSample(lane.name, 1, 1, k * STEP_NS, k * STEP_NS, (0.0, 0.0, 1e-4 * (k % 2)), force, FIELD)
            if lane.name not in states:
                states[lane.name] = ONE.initial(
                    Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.RELATIVE, force, FIELD)
                )
            inputs = FilterInputs(stationary=True)
            states[lane.name] = lane.step(ONE, states[lane.name], 0.02, sample, inputs)
        pair.pair_up()
    return pair


def covariances(pair):
    return [lane.state.navigation.estimate.covariance for lane in (pair.first, pair.second)]


def test_a_difference_makes_both_biases_less_certain_once():
    """s^2 = (3 * 0.0144 + (0.3^2 + 0.3^2) / 2) / 6 = 0.0222, less the prior's 0.0144."""
    pair = stands_side_by_side((0.3, -0.3, 0.0))
    before = covariances(pair)
    follow_scale(pair)
    after = covariances(pair)
    for one, other in zip(before, after, strict=True):
        assert other.aa[0][0] - one.aa[0][0] == pytest.approx(0.0078, rel=0.02)
        assert other.tt[0][0] - one.tt[0][0] == pytest.approx(0.0078 / 9.80665**2, rel=0.02)
        assert other.tt[2][2] == one.tt[2][2]
    follow_scale(pair)
    assert covariances(pair) == after


def test_sensors_that_agree_promise_nothing():
    pair = stands_side_by_side((0.05, 0.0, 0.0))
    before = covariances(pair)
    follow_scale(pair)
    assert covariances(pair) == before
