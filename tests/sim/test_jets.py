import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.sim import jets

STEP = 1e-4


def finite_difference(function, t):
    """Derivatives of each jet entry, by central differences of the entry before it."""
    before, after = function(t - STEP), function(t + STEP)
    return [(b - a) / (2.0 * STEP) for a, b in zip(before, after, strict=True)]


JETS = {
    "sine": lambda t: jets.sine(t, 1.5, 2.0, 0.3),
    "smooth_step": lambda t: jets.smooth_step(t, 1.0, 3.0),
    "smooth_ramp": lambda t: jets.smooth_ramp(t, 1.0, 3.0),
    "times": lambda t: jets.times(jets.sine(t, 1.0, 1.1, 0.0), jets.smooth_step(t, 0.5, 2.0)),
    "plus": lambda t: jets.plus(jets.sine(t, 1.0, 1.1, 0.0), jets.smooth_ramp(t, 0.5, 2.0)),
    "scaled": lambda t: jets.scaled(jets.sine(t, 1.0, 1.1, 0.0), -2.5),
}


@pytest.mark.parametrize("name", JETS)
@given(t=st.floats(-1.0, 6.0))
@settings(derandomize=True, max_examples=60, deadline=None)
def test_each_entry_of_a_jet_is_the_derivative_of_the_one_before(name, t):
    jet = JETS[name]
    first, second, third, _ = finite_difference(jet, t)
    assert (first, second) == pytest.approx(jet(t)[1:3], abs=2e-6)
    # The fourth derivative jumps where a step begins: the difference across that place is half a jump off.
    assert third == pytest.approx(jet(t)[3], abs=2e-3)


@pytest.mark.parametrize(("t", "expected"), [(0.9, 0.0), (2.5, 0.5), (4.1, 1.0)])
def test_smooth_step_goes_from_zero_to_one(t, expected):
    assert jets.smooth_step(t, 1.0, 3.0)[0] == pytest.approx(expected)


def test_smooth_ramp_ends_with_slope_one_half_a_duration_late():
    assert jets.smooth_ramp(10.0, 1.0, 3.0) == pytest.approx((7.5, 1.0, 0.0, 0.0))
