"""What the status line says of the filter and of what its attitude rests on."""

from math import degrees, nan, radians

import pytest

from attest_mav.estimate import Estimate
from attest_mav.mavlink.constants import MAV_STATE_CALIBRATING
from attest_mav.service.status import attitude_text, filter_text
from attest_mav.sim.settings import SimSettings
from attest_mav.types import North

GPS_RAW_INT = 24
INERTIAL = (26, 27, 105, 116, 129)
NEVER = 1e6


def estimate(name, tilt_sigma, heading_sigma):
    level = (1.0, 0.0, 0.0, 0.0)
    return Estimate("RAW_IMU", name, 0, 0, level, (0.0, 0.0, 0.0), North.TRUE, tilt_sigma, heading_sigma, 0.02)


@pytest.mark.parametrize(
    ("name", "rests_on", "sigmas", "text"),
    [
        ("gradient-descent", "", (nan, nan), "gradient-descent"),
        ("leveling", "", (radians(0.5), radians(2.0)), "leveling, sigma tilt 0.50 heading 2.00 deg"),
        (
            "velocity-aided",
            "no velocity: coasting",
            (radians(1.234), radians(0.8)),
            "velocity-aided, no velocity: coasting, sigma tilt 1.23 heading 0.80 deg",
        ),
    ],
)
def test_the_filter_is_named_with_what_it_rests_on_and_how_sure_it_is(name, rests_on, sigmas, text):
    assert filter_text(estimate(name, *sigmas), rests_on) == text


def test_an_angle_that_rounds_to_zero_has_no_sign_and_a_yaw_is_below_360():
    north = (1.0, -1e-4, -1e-4, -1e-4)
    one = Estimate("RAW_IMU", "leveling", 0, 0, north, (0.0, 0.0, 0.0), North.TRUE, nan, nan, 0.02)
    assert attitude_text(one) == "roll +0.0 pitch +0.0 yaw 0.0 (true)"


def witness(flight):
    """The status line's part about the filter."""
    parts = flight.status().split(" | ")
    (part,) = [part for part in parts if part.startswith("velocity-aided")]
    return part.partition(", sigma")[0]


@pytest.mark.parametrize(
    ("scenario", "first_fix_s", "lost_s", "end_s", "text"),
    [
        ("hover", 3.0, NEVER, 0.45, "just aligned"),
        ("hover", 3.0, NEVER, 6.0, "velocity from GPS_RAW_INT"),
        ("hover", 3.0, 6.0, 10.0, "no velocity: coasting"),
        ("hover", 3.0, 6.0, 40.0, "no velocity: gravity only"),
        ("coordinated-turns", 3.0, 20.0, 24.0, "no velocity: airspeed"),
        ("still", NEVER, NEVER, 6.0, "no velocity: at rest"),
        ("tumbling", NEVER, NEVER, 15.0, "no velocity: gravity only"),
    ],
)
def test_what_the_attitude_rests_on_is_said(flight, scenario, first_fix_s, lost_s, end_s, text):
    f = flight("", SimSettings(scenario=scenario, fast_rate_hz=50.0, first_fix_s=first_fix_s))
    f.run_until(min(lost_s, end_s))
    f.deaf_to.add(GPS_RAW_INT)
    f.run_until(end_s)
    assert witness(f) == f"velocity-aided, {text}"


def test_a_guess_is_no_converged_filter(flight):
    """Deaf until it circles, and without a velocity, it takes its own axis for gravity, and doubts it."""
    f = flight("", SimSettings(scenario="coordinated-turns", fast_rate_hz=50.0, first_fix_s=NEVER))
    f.deaf_to.update(INERTIAL)
    f.run_until(25.0)
    f.deaf_to.clear()
    f.run_until(35.0)
    assert degrees(f.service.estimate.tilt_sigma) > 5.0
    assert f.states()[-1] == MAV_STATE_CALIBRATING
