"""Autopilots that do not tell the low-pass of their inertial messages, on virtual time.

20 Hz are assumed, 4 on rovers. A wrong assumption puts the attitude ahead or behind by its delay times the turn rate;
turns show by the magnetometer how late the inertial messages are, as far as that sensor's own delay is known.
"""

from math import inf, sqrt

import pytest

from .flying import fly

SHARE = 0.99


@pytest.mark.parametrize(
    ("scenario", "corner_hz", "heading_limit"),
    [
        ("tumbling", 5.0, 4.0),
        ("tumbling", 10.0, 2.0),
        ("tumbling", 42.0, 1.0),
        ("tumbling", 80.0, 1.0),
        ("square", 5.0, 1.5),
        ("square", 80.0, 0.9),
        ("rover", 2.0, 12.0),
        ("rover", 4.0, 1.7),
        ("rover", 10.0, 6.0),
        ("rover", 20.0, 9.0),
    ],
)
def test_sigma_covers_a_low_pass_that_is_not_told(scenario, corner_hz, heading_limit):
    """At 6 rad/s a rover's assumed 4 Hz are off by 19 deg where 2 Hz are true, and by 15 where 20 are."""
    flight = fly(40.0, "velocity-aided", scenario=scenario, low_pass_hz=corner_hz)
    normalised = flight.normalised(from_s=10.0)
    for errors in zip(*normalised, strict=True):
        assert sum(abs(one) < 3.0 for one in errors) > SHARE * len(errors)
        assert sqrt(sum(one * one for one in errors) / len(errors)) < 1.3
    assert flight.worst(from_s=10.0)[1] < heading_limit
    assert flight.first_disagreement_s() == inf
