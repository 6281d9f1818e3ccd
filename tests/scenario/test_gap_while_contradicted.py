"""A link gap while the receiver contradicts the sensors: no explanation goes on beyond the attitude that it is of."""

from math import degrees

import pytest

from attest_mav.algebra import heading_between
from attest_mav.estimation.events import LaneEventKind
from attest_mav.samples import VelocitySample

from .flying import fly

FAULT_S = 20.0
GAP_S = (20.5, 24.0)
ALIGNED_S = 27.0


def heard_with(jump):
    """Velocities that jump by so much from ``FAULT_S`` on, until a gap in all that is heard, m/s."""

    def heard(sample):
        now_s = sample.rx_ns * 1e-9
        if GAP_S[0] <= now_s < GAP_S[1]:
            return None
        if isinstance(sample, VelocitySample) and FAULT_S <= now_s < GAP_S[0]:
            sign = 1.0 if int(now_s * 5.0) % 2 else -1.0
            north, east, down = sample.v_ned
            return sample.with_velocity((north + sign * jump, east + jump, down))
        return sample

    return heard


@pytest.mark.parametrize("rate_hz", [4.0, 50.0])
def test_the_attitude_found_after_the_gap_stands(rate_hz):
    flight = fly(40.0, "velocity-aided", scenario="coordinated-turns", fast_rate_hz=rate_hz, heard=heard_with(6.0))
    contradicted = [e for e in flight.lane_events if e.kind == LaneEventKind.CONTRADICTED]
    assert contradicted, "else the gap hides nothing"
    late = [e for e in flight.lane_events if e.kind == LaneEventKind.EXPLAINED and e.rx_ns > GAP_S[1] * 1e9]
    assert not late, "an explanation of what was before the gap"
    for one in flight.estimates:
        if one.rx_ns > ALIGNED_S * 1e9:
            off = abs(degrees(heading_between(one.q_nb, flight.vehicle.truth(one.t_ns).q_nb)))
            assert off < max(3.0, 3.0 * degrees(one.heading_sigma))
