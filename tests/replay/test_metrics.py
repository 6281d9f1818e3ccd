from array import array
from math import pi, radians, sqrt

import pytest

from attest_mav.replay.metrics import ErrorColumns, percentile, spread


def test_spread_of_three_four_and_minus_five_degrees():
    result = spread(array("d", [radians(3.0), radians(4.0), radians(-5.0)]))
    assert result is not None
    assert result.rms == pytest.approx(sqrt(50.0 / 3.0))
    assert result.max == pytest.approx(5.0)
    # Position 0.95 * 2 = 1.9 in (3, 4, 5): nine tenths of the way from 4 to 5.
    assert result.p95 == pytest.approx(4.9)


def test_spread_of_nothing_is_none():
    assert spread(array("d")) is None


def test_spread_of_one_value_is_that_value():
    result = spread(array("d", [-pi]))
    assert result is not None
    assert (result.rms, result.p95, result.max) == pytest.approx((180.0, 180.0, 180.0))


def test_percentile_of_a_ramp():
    ramp = [float(value) for value in range(101)]
    assert percentile(ramp, 0.95) == pytest.approx(95.0)
    assert percentile(ramp, 0.0) == 0.0
    assert percentile(ramp, 1.0) == 100.0


def test_heading_is_counted_apart_from_tilt():
    errors = ErrorColumns()
    errors.add(radians(1.0), None)
    errors.add(radians(1.0), radians(-2.0))
    assert (errors.samples, errors.heading_samples) == (2, 1)
    heading = errors.heading()
    assert heading is not None
    assert heading.rms == pytest.approx(2.0)
