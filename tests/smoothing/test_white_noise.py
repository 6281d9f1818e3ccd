"""White noise of the sensors of a whole recording."""

import numpy as np
import pytest

from attest_mav.filters.velocity_aided.white_noise import no_white_noise, observed
from attest_mav.smoothing.tables import Scratch
from attest_mav.smoothing.white_noise import white_variance as column_variance

TIMES = np.arange(0.0, 60.0, 0.02)[:, None]


def white_variance(readings):
    table = Scratch().table(np.dtype([("gyro", "<f8", 3)]))
    table.append(readings.tobytes())
    return column_variance(table, "gyro")


def test_white_noise_is_found_beside_motion_and_a_step():
    white = np.random.default_rng(1).normal(0.0, 0.5, (TIMES.size, 3))
    motion = np.sin(np.pi * TIMES) * np.array([3.0, -5.0, 2.0]) + np.where(TIMES > 30.0, 100.0, 0.0)
    assert white_variance(motion + white) == pytest.approx(0.25, rel=0.15)


def test_motion_alone_is_no_white_noise():
    assert white_variance(np.sin(10.0 * TIMES + np.array([0.0, 1.0, 2.0]))) == 0.0


def test_the_live_filter_finds_the_same():
    readings = np.random.default_rng(2).normal(0.0, 0.5, (TIMES.size, 3)) + np.sin(np.pi * TIMES)
    live = no_white_noise()
    for difference in np.diff(readings, n=2, axis=0).tolist():
        live = observed(live, tuple(difference), 0.02)
    assert white_variance(readings) == pytest.approx(live.variance, rel=0.3)
