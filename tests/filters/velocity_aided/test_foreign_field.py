"""A field that is not the Earth's tells no heading; one that no compass confirms is stated with a wide sigma."""

from math import cos, degrees, nan, pi, radians, sin

import pytest

from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.velocity_aided.aids.field import foreign_share
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import ImuSample
from attest_mav.types import North

DIP = radians(70.0)
STANDING = (0.0, 0.0, -9.80665)


def stood(mag, seconds=6.0, inclination=DIP):
    """The state of a vehicle that has stood for so long, its nose to the north, with this field."""
    flight = VelocityAided()
    state = flight.initial(Start((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), North.RELATIVE, STANDING, mag))
    inputs = FilterInputs(stationary=True, declination=0.0, inclination=inclination)
    for k in range(int(50 * seconds)):
        field = None if mag is None else (mag[0] + 1e-5 * (k % 3), mag[1], mag[2])
        sample = ImuSample("IMU", 1, 1, 20_000_000 * k, 20_000_000 * k, (0.0, 0.0, 0.0), STANDING, field)
        state = flight.step(state, 0.02, sample, inputs)
    return state


def field(dip):
    return (0.5 * cos(dip), 0.0, 0.5 * sin(dip))


@pytest.mark.parametrize(("dip_deg", "is_foreign"), [(70.0, False), (50.0, False), (35.0, True), (-70.0, True)])
def test_a_field_far_from_the_earths_inclination_is_foreign(dip_deg, is_foreign):
    share = foreign_share(sin(radians(dip_deg)), DIP)
    assert share == (pytest.approx(abs(sin(radians(dip_deg)) - sin(DIP))) if is_foreign else 0.0)
    assert foreign_share(sin(radians(dip_deg)), nan) == 0.0


def test_the_earths_field_tells_the_heading():
    state = stood(field(DIP - radians(10.0)))
    assert state.referred_to == North.TRUE
    assert degrees(state.stated_heading_sigma) < 10.0


def test_a_foreign_field_tells_none():
    state = stood(field(0.0))
    assert state.aligned
    assert state.referred_to == North.RELATIVE
    assert degrees(state.stated_heading_sigma) > 90.0


def test_the_same_field_is_believed_where_the_earths_is_not_known():
    assert stood(field(0.0), inclination=nan).referred_to == North.TRUE


def test_without_a_compass_the_heading_is_stated_wide():
    state = stood(None)
    assert state.stated_heading_sigma == pytest.approx(min(pi, 5.0 * state.heading_sigma))
