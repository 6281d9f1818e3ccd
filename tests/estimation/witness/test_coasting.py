"""The receiver while no lane uses it: steady again, late, or still without sense."""

from math import cos, pi, sin

import numpy as np
import pytest

from attest_mav.estimation.witness import coasting
from attest_mav.estimation.witness.coasting import Coasting
from attest_mav.estimation.witness.flight_state import FixRecord
from attest_mav.estimation.witness.moments import Moments

S = 1_000_000_000


def velocity(t_s):
    """A circle of 8 s at 6 m/s."""
    return 6.0 * cos(2.0 * pi * t_s / 8.0), 6.0 * sin(2.0 * pi * t_s / 8.0)


@pytest.fixture
def fly(monkeypatch):
    """fly(innovation): fixes at 5 Hz beside a lane that knows its velocity."""
    monkeypatch.setattr(coasting, "velocity_at", lambda _, t_ns: (*velocity(t_ns / S), 0.0))
    monkeypatch.setattr(coasting, "fix_delay_of", lambda _: 0.0)
    monkeypatch.setattr(Moments, "newest", property(lambda self: self))
    monkeypatch.setattr(Moments, "state", None, raising=False)

    def make(innovation, present_s=0.0, count=25):
        watched = Coasting(0, 0.05, by_sensors=False, shift_s=present_s)
        for k in range(count):
            north, east = innovation(0.2 * k)
            watched.take(FixRecord(k * S // 5, (north, east, 0.0), 10.0), Moments())
        return watched

    return make


def late_by(delay_s):
    def innovation(t_s):
        (a, b), (c, d) = velocity(t_s - delay_s), velocity(t_s)
        return a - c, b - d

    return innovation


def test_a_constant_offset_is_steady_and_not_late(fly):
    watched = fly(lambda _: (5.0, -2.0))
    assert watched.is_steady(field_fits=False)
    assert not watched.lateness().is_suspected


def test_a_huge_offset_is_steady_only_while_the_field_fits(fly):
    watched = fly(lambda _: (50.0, 0.0))
    assert watched.is_steady(field_fits=True)
    assert not watched.is_steady(field_fits=False)


def test_noise_is_not_steady(fly):
    rng = np.random.default_rng(1)
    watched = fly(lambda _: tuple(rng.normal(0.0, 1.0, 2)))
    assert not watched.is_steady(field_fits=True)
    assert not watched.lateness().is_proven


@pytest.mark.parametrize(("present_s", "delay_s"), [(0.0, 0.4), (0.0, 0.25), (0.4, 0.0)])
def test_a_late_receiver_is_found_with_its_delay(fly, present_s, delay_s):
    """With fixes shifted already, the innovations show the delay beside that."""
    found = fly(late_by(delay_s - present_s), present_s).lateness()
    assert found.is_proven
    assert found.shift_s == pytest.approx(delay_s, abs=0.01)


def test_too_few_fixes_say_nothing(fly):
    watched = fly(late_by(0.4), count=9)
    assert watched.lateness() is None
    assert not watched.is_steady(field_fits=True)
