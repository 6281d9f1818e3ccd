"""A flight that begins without a heading is not smoothed; a sensor in place needs none."""

import pytest

from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.smoothing.recorder import Recorder
from attest_mav.types import G_MPS2, North, VelocityOrigin

ZERO = (0.0, 0.0, 0.0)
NORTH_AND_DOWN = (0.22, 0.0, 0.42)


def recording(field, has_fixes):
    """Twenty seconds at rest, with a magnetometer that shows this field, or none."""
    recorder = Recorder(FlightParameters())
    state = recorder.initial(Start((1.0, 0.0, 0.0, 0.0), ZERO, North.RELATIVE, ZERO, None))
    for k in range(1, 1001):
        t_ns = 20_000_000 * k
        shown = None if field is None else (field[0], 1e-4 * (k % 7), field[2])
        sample = ImuSample("RAW_IMU", 1, 1, t_ns, t_ns, ZERO, (0.3, 0.1, -G_MPS2), shown)
        fix = VelocitySample("GPS_RAW_INT", 1, 1, t_ns, t_ns, ZERO, False, VelocityOrigin.RECEIVER)
        inputs = FilterInputs(velocity=fix if has_fixes and k % 10 == 0 else None, zero_mean_velocity=not has_fixes)
        state = recorder.step(state, 0.02, sample, inputs)
    return recorder.recording()


@pytest.mark.parametrize(
    ("field", "has_fixes", "is_there"),
    [(None, True, False), (None, False, True), (NORTH_AND_DOWN, True, True), (NORTH_AND_DOWN, False, True)],
)
def test_a_flight_needs_a_heading_to_begin_with(field, has_fixes, is_there):
    assert (recording(field, has_fixes) is not None) == is_there
