"""All gyros off alike beside an autopilot that is right, and one that is wrong: the magnetic field tells them apart."""

from math import inf, radians

import pytest

from attest_mav.algebra import add, q_heading, q_mul
from attest_mav.samples import AttitudeSample, ImuSample

from .flying import fly

FAULT_S = 20.0
UNTIL_S = 40.0
SOON_S = 2.5
"""The autopilot's heading has passed its limit for the hold time by then."""


def gyros_off(rate_deg):
    """The samples with gyros that are off by this from ``FAULT_S`` on, deg/s."""
    rate = tuple(radians(axis) for axis in rate_deg)

    def heard(sample):
        if isinstance(sample, ImuSample) and sample.t_ns >= FAULT_S * 1e9:
            return sample.with_readings(add(sample.gyro, rate), sample.accel, sample.mag)
        return sample

    return heard


@pytest.mark.parametrize(
    ("scenario", "rate_deg"),
    [
        ("hover", (0.0, 0.0, 3.0)),
        ("hover", (0.0, 0.0, -8.0)),
        ("square", (0.0, 0.0, 3.0)),
        ("coordinated-turns", (0.0, 0.0, -8.0)),
        ("still", (3.0, 0.0, 0.0)),
    ],
)
def test_a_right_autopilot_is_not_accused(scenario, rate_deg):
    heard = gyros_off(rate_deg)
    flight = fly(UNTIL_S, "velocity-aided", right=True, scenario=scenario, armed=True, heard=heard)
    assert flight.worst(from_s=FAULT_S)[1] > 4.0 or flight.worst(from_s=FAULT_S)[0] > 2.0
    assert flight.first_disagreement_s() == inf


@pytest.mark.parametrize("scenario", ["hover", "square"])
def test_an_autopilot_whose_heading_drifts_away_is_accused(scenario):
    def heard(sample):
        if isinstance(sample, AttitudeSample) and sample.t_ns >= FAULT_S * 1e9:
            off = q_heading(radians(8.0) * (sample.t_ns * 1e-9 - FAULT_S))
            return sample.with_attitude(q_mul(off, sample.q_nb), frame_known=True)
        return sample

    flight = fly(30.0, "velocity-aided", scenario=scenario, heard=heard)
    assert FAULT_S < flight.first_disagreement_s() < FAULT_S + SOON_S
