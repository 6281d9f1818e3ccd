"""Two magnetometers that contradict each other beside an autopilot that is right, and one that is wrong.

The accelerometer of the first sensor is stuck, so the second sensor's lane is the selected one, and follows its own
magnetometer. The first magnetometer goes on.
"""

from math import degrees, inf, radians

import pytest

from attest_mav.algebra import add, heading_between, q_heading, q_mul, scale
from attest_mav.samples import AttitudeSample, ImuSample

from .flying import fly

FIRST, SECOND = "RAW_IMU", "SCALED_IMU2"
STUCK_S = 8.0
FAULT_S = 20.0
IRON = (0.0, 0.1, 0.0)
"""gauss: what comes near the second magnetometer within 10 s."""
STUCK = (5.0, 5.0, 5.0)
CALIBRATION = (0.0, 0.05, 0.0)
"""gauss: error of the second magnetometer's calibration."""
BACK_S = 13.0
"""The first sensor is in order from 9 s on, and used again."""


def first_stuck(sample):
    if isinstance(sample, ImuSample) and sample.source == FIRST and sample.t_ns >= STUCK_S * 1e9:
        return sample.with_readings(sample.gyro, STUCK, sample.mag)
    return sample


def second_by_iron(sample):
    """The second magnetometer is drawn aside more and more from 10 s on."""
    if isinstance(sample, ImuSample) and sample.source == SECOND and sample.mag is not None:
        share = min(1.0, max(0.0, sample.t_ns * 1e-10 - 1.0))
        return sample.with_readings(sample.gyro, sample.accel, add(sample.mag, scale(IRON, share)))
    return first_stuck(sample)


def autopilot_drifts(sample):
    """The autopilot's heading drifts away by 8 deg/s."""
    if isinstance(sample, AttitudeSample) and sample.t_ns >= FAULT_S * 1e9:
        off = q_heading(radians(8.0) * (sample.t_ns * 1e-9 - FAULT_S))
        return sample.with_attitude(q_mul(off, sample.q_nb), frame_known=True)
    return first_stuck(sample)


def flown(until_s, scenario, heard, right):
    return fly(
        until_s,
        "velocity-aided",
        right=right,
        armed=True,
        scenario=scenario,
        heard=heard,
        others=(SECOND,),
        fast_rate_hz=25.0,
    )


@pytest.mark.parametrize(("scenario", "least_off"), [("square", 8.0), ("still", 15.0)])
def test_a_right_autopilot_is_not_accused_of_its_heading_by_one_of_two_magnetometers(scenario, least_off):
    flight = flown(35.0, scenario, second_by_iron, right=True)
    assert flight.worst(from_s=STUCK_S)[1] > least_off
    assert flight.first_disagreement_s() == inf


def test_an_autopilot_whose_heading_drifts_away_from_both_is_accused():
    flight = flown(25.0, "square", autopilot_drifts, right=False)
    assert FAULT_S < flight.first_disagreement_s() < FAULT_S + 2.5


def briefly_stuck(sample):
    """The first accelerometer is stuck from 6 to 9 s; the second magnetometer is off throughout."""
    if not isinstance(sample, ImuSample):
        return sample
    if sample.source == SECOND and sample.mag is not None:
        return sample.with_readings(sample.gyro, sample.accel, add(sample.mag, CALIBRATION))
    if sample.source == FIRST and 6.0 <= sample.t_ns * 1e-9 < 9.0:
        return sample.with_readings(sample.gyro, STUCK, sample.mag)
    return sample


def test_a_sensor_that_is_used_again_follows_its_own_magnetometer():
    flight = flown(13.2, "square", briefly_stuck, right=True)
    headings = {
        lane: [
            abs(degrees(heading_between(one.q_nb, flight.vehicle.truth(one.t_ns).q_nb)))
            for one in flight.estimates
            if one.lane == lane and one.t_ns >= BACK_S * 1e9
        ]
        for lane in (FIRST, SECOND)
    }
    assert min(headings[SECOND]) > 7.0
    assert max(headings[FIRST]) < 5.5
