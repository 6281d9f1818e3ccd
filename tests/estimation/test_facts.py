"""A lane whose filter learns the vehicle's settings in the middle of its work.

The low-pass is what shows at once: a vehicle that turns at r is shown r * sqrt(2) / (2 pi f) further on than its
low-passed gyro says.
"""

from math import isnan, nan, pi, sqrt

import pytest

from attest_mav.algebra import heading_between
from attest_mav.estimate import Estimate
from attest_mav.estimation.events import LaneEvent
from attest_mav.estimation.pipeline import Pipeline, PipelineSettings
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import Setting, VehicleSettings

DT = 0.02
RATE = 0.5
"""rad/s."""
DELAY_20_HZ = sqrt(2.0) / (2.0 * pi * 20.0)
"""11.25 ms."""
MAG_DELAY = FlightParameters().mag_delay_s


CERTAIN = VelocityAided(FlightParameters(low_pass_delay_sigma=0.0))
"""It takes 20 Hz for certain until it is told, so that no other delay is estimated."""


def pipeline(one=CERTAIN):
    return Pipeline(PipelineSettings(), one)


def turn(imu, one, start, stop, corner_hz=20.0):
    """Samples of a level vehicle that stands for two seconds and then turns; the events of them.

    corner_hz: of the low-pass at the start, behind which the field lags as it is believed to, and turns no heading.
    """
    events = []
    for k in range(round(start / DT), round(stop / DT)):
        yaw = RATE * max(0.0, k * DT - 2.0 - MAG_DELAY + DELAY_20_HZ * 20.0 / corner_hz)
        events += one.handle(imu(k * DT, yaw, rate=RATE if k * DT > 2.0 else 0.0))
    return events


def ahead(one, other):
    """How far one's newest heading is ahead of the other's, in seconds of the turn."""
    return heading_between(one.estimate.q_nb, other.estimate.q_nb) / RATE


def low_pass(hz):
    return ParameterSample("PARAM_VALUE", 1, 1, 0, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, hz)


def test_a_filter_is_informed_while_it_runs_and_its_state_goes_on(imu):
    told, untold = pipeline(), pipeline()
    for one in (told, untold):
        turn(imu, one, 0.0, 3.0)
    assert ahead(untold, told) == 0.0
    assert told.handle(low_pass(10.0)) == []
    events = turn(imu, told, 3.0, 3.2)
    turn(imu, untold, 3.0, 3.2)
    assert not [event for event in events if isinstance(event, LaneEvent)]
    assert len([event for event in events if isinstance(event, Estimate)]) == 10
    assert ahead(told, untold) == pytest.approx(DELAY_20_HZ, rel=0.02)
    told.handle(low_pass(0.0))
    turn(imu, told, 3.2, 3.4)
    turn(imu, untold, 3.2, 3.4)
    assert ahead(told, untold) == pytest.approx(-DELAY_20_HZ, rel=0.02)


def test_what_is_taken_back_is_assumed_again(imu):
    told, untold = pipeline(), pipeline()
    told.handle(low_pass(10.0))
    for one, corner_hz in ((told, 10.0), (untold, 20.0)):
        turn(imu, one, 0.0, 3.0, corner_hz)
    told.handle(low_pass(nan))
    for one, corner_hz in ((told, 10.0), (untold, 20.0)):
        turn(imu, one, 3.0, 3.1, corner_hz)
    assert ahead(told, untold) == pytest.approx(0.0, abs=1e-4)


def test_a_lane_that_is_made_later_knows_it_too(imu):
    early, given, untold = pipeline(), pipeline(), pipeline()
    early.handle(low_pass(10.0))
    given.set_vehicle_settings(VehicleSettings(low_pass_hz=10.0))
    for one, corner_hz in ((early, 10.0), (given, 10.0), (untold, 20.0)):
        turn(imu, one, 0.0, 3.0, corner_hz)
    assert ahead(early, untold) == pytest.approx(DELAY_20_HZ, rel=0.02)
    assert ahead(early, given) == 0.0


def test_a_number_of_the_users_holds_against_the_autopilot(imu):
    fixed = pipeline(VelocityAided(CERTAIN.parameters, low_pass_from_vehicle=False))
    assert isnan(VelocityAided(low_pass_from_vehicle=False).default_settings.low_pass_hz)
    untold = pipeline()
    fixed.handle(low_pass(10.0))
    for one in (fixed, untold):
        turn(imu, one, 0.0, 3.0)
    assert ahead(fixed, untold) == 0.0
