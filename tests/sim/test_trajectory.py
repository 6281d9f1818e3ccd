"""The motions are checked against mechanics by finite differences, with rotation matrices built in the test."""

from math import cos, degrees, pi, radians, sin, sqrt

import numpy as np
import pytest

from attest_mav.algebra import angle_of, q_conj, q_exp, q_mul, q_to_matrix, scale, tilt_between
from attest_mav.errors import UsageError
from attest_mav.sim.copters import Square
from attest_mav.sim.plane import CoordinatedTurns
from attest_mav.sim.scenarios import SCENARIOS, make_trajectory
from attest_mav.sim.trajectory import STILL_S
from attest_mav.types import G_MPS2

LEVEL = (1.0, 0.0, 0.0, 0.0)
STEP = 1e-3
DURATION_S = 90.0


def instants(count):
    """Times spread over the flight, never on a round number."""
    return [DURATION_S * (k + 0.37) / count for k in range(count)]


@pytest.mark.parametrize("name", SCENARIOS)
def test_integrating_the_body_rates_gives_the_attitude(name):
    trajectory = make_trajectory(name, 1)
    step = 0.004
    q = trajectory.at(0.0).q_nb
    worst = 0.0
    for k in range(round(DURATION_S / step)):
        middle = trajectory.at((k + 0.5) * step)
        q = q_mul(q, q_exp(scale(middle.rates, 0.5 * step)))
        if k % 50 == 49:
            worst = max(worst, angle_of(q_mul(q_conj(q), trajectory.at((k + 1) * step).q_nb)))
    # The midpoint rule leaves h^2 |w| |w'| T / 12 or so; 90 s of tumbling come to 0.001 degrees.
    assert degrees(worst) < 0.002


@pytest.mark.parametrize("name", SCENARIOS)
def test_differentiating_the_velocity_gives_the_specific_force(name):
    trajectory = make_trajectory(name, 1)
    for t in instants(200):
        before, after = trajectory.at(t - STEP), trajectory.at(t + STEP)
        acceleration = (np.array(after.v_ned) - np.array(before.v_ned)) / (2.0 * STEP)
        expected = np.array(q_to_matrix(trajectory.at(t).q_nb)).T @ (acceleration - (0.0, 0.0, G_MPS2))
        assert trajectory.at(t).specific_force() == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("name", SCENARIOS)
def test_differentiating_the_position_gives_the_velocity(name):
    trajectory = make_trajectory(name, 1)
    for t in instants(200):
        moved = np.array(trajectory.position(t + STEP)) - np.array(trajectory.position(t - STEP))
        assert moved / (2.0 * STEP) == pytest.approx(trajectory.at(t).v_ned, abs=2e-4)


def test_the_position_of_the_plane_is_the_integral_of_its_velocity():
    trajectory = CoordinatedTurns()
    step, north, east = 0.01, 0.0, 0.0
    for k in range(round(100.0 / step)):
        v = trajectory.at((k + 0.5) * step).v_ned
        north, east = north + v[0] * step, east + v[1] * step
    assert trajectory.position(100.0)[:2] == pytest.approx((north, east), abs=0.005)
    # Asked for in another order, on an object that remembers nothing yet.
    assert CoordinatedTurns().position(100.0) == trajectory.position(100.0)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_motion_begins_still(name):
    trajectory = make_trajectory(name, 1)
    start = trajectory.at(0.0)
    for t in (0.0, 2.0, STILL_S):
        motion = trajectory.at(t)
        assert motion.q_nb == start.q_nb
        assert motion.rates == (0.0, 0.0, 0.0)
        assert motion.v_ned == (0.0, 0.0, 0.0)
        assert motion.a_ned == (0.0, 0.0, 0.0)
        assert trajectory.position(t) == pytest.approx((0.0, 0.0, 0.0))


def test_the_plane_holds_both_banks_without_side_force():
    trajectory = CoordinatedTurns()
    banks = []
    for t in instants(900):
        motion = trajectory.at(t)
        if t > trajectory.FIRST_TURN_S:
            banks.append(degrees(motion.euler[0]))
            assert motion.specific_force()[1] == pytest.approx(0.0, abs=1e-9)
            assert np.hypot(*motion.v_ned[:2]) == pytest.approx(trajectory.SPEED)
    assert sum(abs(bank - 30.0) < 0.01 for bank in banks) > 200
    assert sum(abs(bank + 45.0) < 0.01 for bank in banks) > 100
    assert max(banks) < 30.01
    assert min(banks) > -45.01


def test_the_plane_flies_where_its_nose_points():
    trajectory = CoordinatedTurns()
    for t in instants(300):
        motion = trajectory.at(t)
        along = np.array(q_to_matrix(motion.q_nb)).T @ motion.v_ned
        assert along == pytest.approx((np.linalg.norm(motion.v_ned), 0.0, 0.0), abs=1e-9)


def test_the_plane_comes_back_to_the_heading_of_its_pattern():
    trajectory = CoordinatedTurns()
    t = trajectory.FIRST_TURN_S + 1.0
    later = trajectory.at(t + trajectory.period_s)
    assert tilt_between(trajectory.at(t).q_nb, later.q_nb) < 1e-9
    assert angle_of(q_mul(q_conj(trajectory.at(t).q_nb), later.q_nb)) < 1e-6


def test_the_square_passes_its_corners_on_track():
    trajectory = Square()
    period = trajectory.LEG_S + trajectory.CORNER_S
    start_s = STILL_S + 5.0
    corners = [trajectory.position(start_s + leg * period) for leg in range(5)]
    yaw, side = trajectory.YAW, trajectory.SIDE_M
    assert corners[1][:2] == pytest.approx((side * cos(yaw), side * sin(yaw)))
    assert np.linalg.norm(np.subtract(corners[2], corners[0])) == pytest.approx(side * sqrt(2.0))
    assert corners[4] == pytest.approx(corners[0], abs=1e-9)
    middle = trajectory.at(start_s + 2.5 * period - 0.5 * trajectory.CORNER_S)
    track = np.arctan2(middle.v_ned[1], middle.v_ned[0])
    assert cos(track - middle.euler[2]) == pytest.approx(1.0)
    assert (middle.euler[2] - yaw) % (2.0 * pi) == pytest.approx(pi)


def test_hover_tilts_by_degrees_and_stays_near():
    trajectory = make_trajectory("hover", 3)
    tilts = [degrees(tilt_between(LEVEL, trajectory.at(t).q_nb)) for t in instants(900) if t > 20.0]
    assert 2.0 < max(tilts) < 12.0
    assert all(abs(p) < 6.0 for t in instants(200) for p in trajectory.position(t)[:2])


def test_tumbling_goes_through_all_attitudes():
    trajectory = make_trajectory("tumbling", 1)
    motions = [trajectory.at(t) for t in instants(2000)]
    assert degrees(max(tilt_between(LEVEL, m.q_nb) for m in motions)) > 160.0
    assert max(abs(m.euler[1]) for m in motions) > radians(95.0)  # through the singularity of Euler angles
    assert 1.5 < max(np.linalg.norm(m.rates) for m in motions) < 4.0


def test_only_the_gusts_depend_on_the_seed():
    for name in SCENARIOS:
        same = make_trajectory(name, 1).at(30.0).q_nb == make_trajectory(name, 2).at(30.0).q_nb
        assert same == (name != "hover")
    assert make_trajectory("hover", 7).at(30.0).q_nb == make_trajectory("hover", 7).at(30.0).q_nb


def test_an_unknown_scenario_is_an_error_that_lists_the_known_ones():
    with pytest.raises(UsageError, match=r"'loop'.*still, hover, coordinated-turns, square, rover, tumbling"):
        make_trajectory("loop", 1)
