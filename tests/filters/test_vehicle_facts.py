"""What a filter takes from the autopilot, and what it does not."""

from math import isnan, nan

import pytest

from attest_mav.filters.base import VehicleFacts
from attest_mav.filters.registry import default_filter
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.types import Setting

FACTS = VehicleFacts(42.0, 0.25)


def test_facts_are_told_one_by_one_and_can_be_taken_back():
    facts = VehicleFacts().told(Setting.LOW_PASS_HZ, 42.0)
    assert facts.low_pass_hz == 42.0
    assert isnan(facts.fix_delay_s)
    facts = facts.told(Setting.FIX_DELAY_S, 0.25)
    assert facts == FACTS
    assert (facts.of(Setting.LOW_PASS_HZ), facts.of(Setting.FIX_DELAY_S)) == (42.0, 0.25)
    assert isnan(facts.told(Setting.FIX_DELAY_S, nan).fix_delay_s)


@pytest.mark.parametrize("name", ["gradient-descent", "robust-adaptive", "leveling"])
def test_most_filters_want_to_know_nothing(name):
    one = default_filter(name)
    assert one.informed(FACTS) == one
    assert isnan(one.assumed.low_pass_hz)
    assert isnan(one.assumed.fix_delay_s)


def test_the_flight_filter_takes_what_is_known():
    default = VelocityAided()
    assert default.assumed == VehicleFacts(20.0, 0.1)
    told = default.informed(FACTS).parameters
    assert (told.low_pass_hz, told.fix_delay_s) == (42.0, 0.25)
    half = default.informed(VehicleFacts(nan, 0.25)).parameters
    assert (half.low_pass_hz, half.fix_delay_s) == (20.0, 0.25)
    assert default.informed(VehicleFacts()) == default


def test_what_the_user_fixed_is_not_overruled():
    fixed = VelocityAided(FlightParameters(low_pass_hz=80.0), low_pass_open=False)
    assert isnan(fixed.assumed.low_pass_hz)
    told = fixed.informed(FACTS).parameters
    assert (told.low_pass_hz, told.fix_delay_s) == (80.0, 0.25)
    both = VelocityAided(FlightParameters(fix_delay_s=0.03), low_pass_open=False, fix_delay_open=False)
    assert both.informed(FACTS) == both
