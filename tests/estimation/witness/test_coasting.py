"""The receiver while no lane uses it: steady again, late, or still without sense."""

from math import cos, pi, sin

import numpy as np
import pytest

from attest_mav.estimation.witness.coasting import Coasting


def velocity(t_s):
    """A circle of 8 s at 6 m/s."""
    return 6.0 * cos(2.0 * pi * t_s / 8.0), 6.0 * sin(2.0 * pi * t_s / 8.0)


def fly(innovation, present_s=0.0, count=25):
    """Fixes at 5 Hz beside a lane that knows its velocity."""
    watched = Coasting(0.05, present_s)
    for k in range(count):
        t_s = 0.2 * k
        north, east = innovation(t_s)
        then = velocity(t_s)
        earlier = [velocity(t_s - (shift_s - present_s)) for shift_s in watched.shifts_s]
        watched.add((north, east, 0.0), [(a - then[0], b - then[1], 0.0) for a, b in earlier])
    return watched


def late_by(delay_s):
    def innovation(t_s):
        (a, b), (c, d) = velocity(t_s - delay_s), velocity(t_s)
        return a - c, b - d

    return innovation


def test_a_constant_offset_is_steady_and_not_late():
    watched = fly(lambda _: (5.0, -2.0))
    assert watched.is_steady(field_fits=False)
    assert not watched.lateness().is_suspected


def test_a_huge_offset_is_steady_only_while_the_field_fits():
    watched = fly(lambda _: (50.0, 0.0))
    assert watched.is_steady(field_fits=True)
    assert not watched.is_steady(field_fits=False)


def test_noise_is_not_steady():
    rng = np.random.default_rng(1)
    watched = fly(lambda _: tuple(rng.normal(0.0, 1.0, 2)))
    assert not watched.is_steady(field_fits=True)
    assert not watched.lateness().is_proven


def unsteady_until(end_s):
    """An offset that jumps to and fro until then."""

    def innovation(t_s):
        return (2.0 + (1.0 if t_s < end_s and round(5.0 * t_s) % 2 else 0.0), 0.0)

    return innovation


@pytest.mark.parametrize(
    ("unsteady_s", "steady_s", "expected"),
    [
        (1.0, 3.2, True),
        (8.0, 3.2, False),  # half of the time before is needed: a velocity that wanders pauses for so long
        (8.0, 4.4, True),
        (60.0, 5.0, False),
        (60.0, 6.2, True),  # and no more than this
    ],
)
def test_a_pause_of_an_unsteady_receiver_is_no_return(unsteady_s, steady_s, expected):
    watched = fly(unsteady_until(unsteady_s), count=round(5.0 * (unsteady_s + steady_s)))
    assert watched.is_steady(field_fits=True) is expected


@pytest.mark.parametrize(("present_s", "delay_s"), [(0.0, 0.4), (0.0, 0.25), (0.4, 0.0)])
def test_a_late_receiver_is_found_with_its_delay(present_s, delay_s):
    """With fixes shifted already, the innovations show the delay beside that."""
    found = fly(late_by(delay_s - present_s), present_s).lateness()
    assert found.is_proven
    assert found.shift_s == pytest.approx(delay_s, abs=0.01)


def test_too_few_fixes_say_nothing():
    watched = fly(late_by(0.4), count=9)
    assert watched.lateness() is None
    assert not watched.is_steady(field_fits=True)
