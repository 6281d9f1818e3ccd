from math import pi, radians

import pytest

from attest_mav.algebra import heading_between, q_conj, q_from_euler, rotate, tilt_between
from attest_mav.estimation.alignment import PATIENCE_S, WINDOW_S, Aligner, ecompass
from attest_mav.types import G_MPS2, North

FIELD_NED = (0.24, 0.0, -0.5)

ATTITUDES = [(0.0, 0.0, 0.0), (0.3, -0.2, 1.0), (-1.2, 0.9, -2.8), (3.0, 0.1, pi - 0.01), (0.1, 1.5, 0.5)]


@pytest.mark.parametrize("euler", ATTITUDES)
def test_ecompass_finds_the_attitude_that_made_the_readings(euler):
    truth = q_from_euler(*euler)
    accel = rotate(q_conj(truth), (0.0, 0.0, -G_MPS2))
    q_nb, north = ecompass(accel, rotate(q_conj(truth), FIELD_NED))
    assert north == North.MAGNETIC
    assert tilt_between(q_nb, truth) < 1e-9
    assert abs(heading_between(q_nb, truth)) < 1e-9


def test_ecompass_agrees_with_the_published_vector():
    q_nb, _ = ecompass((1.5, 1.0, -9.6), (0.45, -0.1, 0.85))
    assert q_nb == pytest.approx((0.995599686798, -0.052476922953, 0.076392628402, 0.013842056636), abs=1e-9)


@pytest.mark.parametrize("mag", [None, (0.0, 0.0, 0.0), (0.0, 0.0, 0.5), (float("nan"), 0.1, 0.2)])
@pytest.mark.parametrize("euler", [(0.3, -0.2, 0.0), (0.0, pi / 2, 0.0), (0.0, -pi / 2, 0.0)])
def test_ecompass_without_a_horizontal_field_keeps_tilt_and_says_relative(mag, euler):
    truth = q_from_euler(*euler)
    accel = rotate(q_conj(truth), (0.0, 0.0, -G_MPS2))
    if mag == (0.0, 0.0, 0.5):
        mag = rotate(q_conj(truth), mag)
    q_nb, north = ecompass(accel, mag)
    assert north == North.RELATIVE
    assert tilt_between(q_nb, truth) < 1e-7


def test_at_rest_the_start_is_the_mean_with_the_gyro_bias(imu):
    aligner = Aligner()
    start = None
    steps = 0
    while start is None:
        start = aligner.add(imu(0.02 * steps, rate=0.002, gyro=(0.001 * (-1) ** steps, 0.004, 0.002)), 0.02, None)
        steps += 1
    assert (steps - 1) * 0.02 == pytest.approx(WINDOW_S, abs=0.021)
    assert start.at_rest
    assert start.north == North.MAGNETIC
    assert start.gyro_bias == pytest.approx((0.0, 0.004, 0.002), abs=1e-4)


def test_a_steady_turn_is_not_taken_for_a_bias(imu):
    aligner = Aligner()
    start = None
    steps = 0
    while start is None:
        start = aligner.add(imu(0.02 * steps, yaw=0.1 * 0.02 * steps, rate=0.1), 0.02, None)
        steps += 1
    assert start.gyro_bias == (0.0, 0.0, 0.0)


def test_a_vehicle_that_never_rests_is_aligned_after_a_while(imu):
    aligner = Aligner()
    start = None
    steps = 0
    while start is None:
        start = aligner.add(imu(0.02 * steps, gyro=(0.5 * (-1) ** steps, 0.0, 0.0)), 0.02, None)
        steps += 1
    assert not start.at_rest
    assert (steps - 1) * 0.02 == pytest.approx(PATIENCE_S, abs=0.021)


def test_a_late_magnetometer_is_waited_for_but_not_for_ever(imu):
    aligner = Aligner()
    for k in range(50):
        assert aligner.add(imu(0.02 * k, field=False), 0.02, None) is None
    start = aligner.add(imu(1.0, yaw=radians(30.0)), 0.02, None)
    assert start is not None
    assert start.north == North.MAGNETIC
    aligner = Aligner()
    starts = [aligner.add(imu(0.02 * k, field=False), 0.02, None) for k in range(102)]
    first = next(s for s in starts if s is not None)
    assert first.north == North.RELATIVE


def test_free_fall_and_hard_manoeuvres_do_not_align(imu):
    aligner = Aligner()
    for k in range(500):
        assert aligner.add(imu(0.02 * k, accel=(0.0, 0.0, -0.2 * G_MPS2)), 0.02, None) is None
        assert aligner.add(imu(0.02 * k, accel=(0.0, 0.0, -1.8 * G_MPS2)), 0.02, None) is None
