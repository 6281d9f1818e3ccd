"""What a filter takes from the autopilot, and what it does not."""

from math import isnan, nan

import pytest

from attest_mav.filters.registry import default_filter
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.vehicle_settings import Setting, VehicleSettings

FACTS = VehicleSettings(42.0, 0.25)


def test_facts_are_told_one_by_one_and_can_be_taken_back():
    facts = VehicleSettings().updated(Setting.LOW_PASS_HZ, 42.0)
    assert facts.low_pass_hz == 42.0
    assert isnan(facts.fix_delay_s)
    facts = facts.updated(Setting.FIX_DELAY_S, 0.25)
    assert facts == FACTS
    assert (facts.get(Setting.LOW_PASS_HZ), facts.get(Setting.FIX_DELAY_S)) == (42.0, 0.25)
    assert isnan(facts.updated(Setting.FIX_DELAY_S, nan).fix_delay_s)


@pytest.mark.parametrize("name", ["gradient-descent", "robust-adaptive", "leveling"])
def test_most_filters_want_to_know_nothing(name):
    one = default_filter(name)
    assert one.with_vehicle_settings(FACTS) == one
    assert isnan(one.default_settings.low_pass_hz)
    assert isnan(one.default_settings.fix_delay_s)


def test_the_flight_filter_takes_what_is_known():
    default = VelocityAided()
    assert default.default_settings == VehicleSettings(20.0, 0.1)
    told = default.with_vehicle_settings(FACTS).parameters
    assert (told.low_pass_hz, told.fix_delay_s) == (42.0, 0.25)
    half = default.with_vehicle_settings(VehicleSettings(nan, 0.25)).parameters
    assert (half.low_pass_hz, half.fix_delay_s) == (20.0, 0.25)
    assert default.with_vehicle_settings(VehicleSettings()) == default


def test_what_the_user_fixed_is_not_overruled():
    fixed = VelocityAided(FlightParameters(low_pass_hz=80.0), low_pass_from_vehicle=False)
    assert isnan(fixed.default_settings.low_pass_hz)
    told = fixed.with_vehicle_settings(FACTS).parameters
    assert (told.low_pass_hz, told.fix_delay_s) == (80.0, 0.25)
    both = VelocityAided(FlightParameters(fix_delay_s=0.03), low_pass_from_vehicle=False, fix_delay_from_vehicle=False)
    assert both.with_vehicle_settings(FACTS) == both
