import numpy as np
import pytest

from attest_mav.sim.receiver import GPS_DELAY_S, Gps
from attest_mav.sim.scenarios import make_trajectory


def test_gps_tells_of_a_tenth_of_a_second_before_its_time():
    trajectory = make_trajectory("coordinated-turns", 1)
    gps = Gps(trajectory, 3.0, 1)
    late, now = [], []
    for tick in range(400 * 60):
        before = gps.fix_ns
        gps.update(tick * 2_500_000)
        if gps.fix_ns != before and tick > 400 * 26:
            t = gps.fix_ns * 1e-9
            late.append(np.subtract(gps.velocity, trajectory.at(t - GPS_DELAY_S).v_ned))
            now.append(np.subtract(gps.velocity, trajectory.at(t).v_ned))
    assert len(late) == pytest.approx(170, abs=1)  # five a second
    assert np.std(late) == pytest.approx(0.04, rel=0.15)
    assert np.std(now) > 5.0 * np.std(late)
