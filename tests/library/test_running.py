"""Filters over arrays."""

import pickle
import subprocess
import sys
from math import degrees, nan, radians
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import attest_mav
from attest_mav import (
    Aid,
    ArgumentError,
    FlightParameters,
    GradientDescent,
    Leveling,
    LiveAttitude,
    North,
    Readings,
    RobustAdaptive,
    VelocityAided,
    read_log,
    run,
    run_readings,
)

LOG = Path(__file__).parents[1] / "data" / "plane_circles_turn.tlog"
FILTERS = (GradientDescent(), RobustAdaptive(), Leveling(), VelocityAided())
IDS = [one.name for one in FILTERS]
G = 9.80665


def still(roll, pitch, yaw, seconds=20.0, rate=50.0):
    """Readings of a sensor at rest: times, gyro, accelerometer, magnetometer, made by scipy."""
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    t = np.arange(round(seconds * rate)) / rate
    force = turn.inv().apply([0.0, 0.0, -G])
    field = turn.inv().apply([0.2, 0.0, 0.44])
    return t, np.zeros((len(t), 3)), np.tile(force, (len(t), 1)), np.tile(field, (len(t), 1))


def wobbling(seconds=30.0, rate=100.0):
    """Times, true attitudes (scipy's rotations, FRD to NED) and readings of a sensor that is turned in the hand."""
    t = np.arange(round(seconds * rate)) / rate
    angles = np.column_stack((0.8 * np.sin(0.9 * t), 0.5 * np.sin(0.7 * t), 0.4 * np.sin(1.3 * t)))
    truth = Rotation.from_euler("ZYX", angles)
    rates = (truth[:-1].inv() * truth[1:]).as_rotvec() * rate
    gyro = np.vstack((rates[:1], rates))
    return t, truth, gyro, truth.inv().apply([0.0, 0.0, -G]), truth.inv().apply([0.2, 0.0, 0.44])


def angle_between(attitudes, truth):
    """Degrees, one a row."""
    found = Rotation.from_quat(attitudes, scalar_first=True)
    return np.degrees((found.inv() * truth).magnitude())


@pytest.mark.parametrize("one", FILTERS, ids=IDS)
def test_a_sensor_at_rest_shows_the_attitude_that_scipy_made(one):
    solution = run(one, *still(0.3, -0.2, 1.1))
    assert np.allclose(solution.euler[-1], (0.3, -0.2, 1.1), atol=radians(0.2))
    assert solution.north == North.MAGNETIC
    assert solution.aligned[-1]


@pytest.mark.parametrize("one", FILTERS[:1] + FILTERS[3:], ids=IDS[:1] + IDS[3:])
def test_a_sensor_in_the_hand_is_followed(one):
    t, truth, gyro, accel, mag = wobbling()
    found = run(one, t, gyro, accel, mag)
    late = np.flatnonzero(found.aligned & (t > 10.0))
    assert len(late) == np.count_nonzero(t > 10.0)
    assert angle_between(found.attitudes[late], truth[late]).max() < 1.5


@pytest.mark.parametrize("frames", ["FLU/ENU", "FLU/NWU"])
def test_other_frames_give_the_same_attitude_in_their_own_axes(frames):
    t, gyro, accel, mag = still(0.3, -0.2, 1.1)
    flip = np.array([1.0, -1.0, -1.0])
    own = run(GradientDescent(), t, gyro, accel, mag)
    other = run(GradientDescent(), t, gyro * flip, accel * flip, mag * flip, frames=frames)
    nose = Rotation.from_quat(own.attitudes[-1], scalar_first=True).apply([1.0, 0.0, 0.0])
    turned = Rotation.from_quat(other.attitudes[-1], scalar_first=True)
    north, east, down = nose
    expected = (east, north, -down) if frames == "FLU/ENU" else (north, -east, -down)
    assert np.allclose(turned.apply([1.0, 0.0, 0.0]), expected, atol=1e-9)
    up_in_body = turned.inv().apply([0.0, 0.0, 1.0])
    assert np.allclose(up_in_body, accel[-1] * flip / G, atol=radians(0.2))


def test_velocity_in_enu_gives_the_same_flight():
    log = read_log(LOG).readings
    one = VelocityAided()
    ned = run_readings(one, log)
    flip = np.array([1.0, -1.0, -1.0])
    north, east, down = log.velocity.T
    turned = Readings(
        log.t,
        log.gyro * flip,
        log.accel * flip,
        log.mag * flip,
        np.column_stack((east, north, -down)),
        velocity_t=log.velocity_t,
        velocity_sigma=log.velocity_sigma,
        declination=log.field.declination,
        inclination=log.field.inclination,
        frames="FLU/ENU",
    )
    enu = run_readings(one, turned)
    assert np.array_equal(ned.tilt_sigma, enu.tilt_sigma, equal_nan=True)
    assert np.allclose(ned.gyro_biases * flip, enu.gyro_biases)


def test_a_flight_from_a_log_is_near_the_simulators_truth():
    log = read_log(LOG)
    assert (log.inertial, log.reference) == ("RAW_IMU", "SIM_STATE")
    solution = run_readings(VelocityAided().with_vehicle_settings(log.settings), log.readings)
    rows = np.searchsorted(solution.t, log.reference_t).clip(0, len(solution.t) - 1)
    late = (log.reference_t > 8.0) & (np.abs(solution.t[rows] - log.reference_t) < 1e-3)
    assert np.count_nonzero(late) > 400
    truth = Rotation.from_quat(log.reference_attitudes[late], scalar_first=True)
    assert angle_between(solution.attitudes[rows[late]], truth).max() < 1.0
    nis = solution.innovations.of(Aid.VELOCITY).nis
    assert 0.0 < np.nanmean(nis) < 1.0
    assert np.nanmax(solution.tilt_sigma[late.nonzero()[0]]) < radians(3.0)


def test_rows_without_an_attitude_are_not_numbers():
    solution = run_readings(VelocityAided(), read_log(LOG).readings)
    assert not solution.aligned[0]
    assert np.isnan(solution.attitudes[0]).all()
    assert np.isnan(solution.tilt_sigma[0])


@pytest.mark.parametrize("one", FILTERS, ids=IDS)
def test_one_reading_at_a_time_equals_the_arrays(one):
    t, _, gyro, accel, mag = wobbling(seconds=5.0)
    whole = run(one, t, gyro, accel, mag)
    live = LiveAttitude(one)
    for k in range(len(t)):
        found = live.update(t[k], gyro[k], list(accel[k]), tuple(mag[k]))
        expected = whole.attitudes[k]
        assert (found is None) == bool(np.isnan(expected[0]))
        if found is not None:
            assert np.allclose(found, expected, atol=1e-12)
    assert np.allclose(live.gyro_bias, whole.gyro_biases[-1])


def test_stretches_do_not_show(monkeypatch):
    log = read_log(LOG).readings
    whole = run_readings(VelocityAided(), log)
    monkeypatch.setattr("attest_mav.library.running.STRETCH", 17)
    parts = run_readings(VelocityAided(), log)
    assert np.array_equal(whole.attitudes, parts.attitudes, equal_nan=True)
    assert np.array_equal(whole.innovations.reading, parts.innovations.reading)
    assert np.array_equal(whole.innovations.residual, parts.innovations.residual, equal_nan=True)


def test_missing_readings_are_survived():
    t, gyro, accel, mag = still(0.3, -0.2, 1.1)
    gyro[100:110] = nan
    accel[200:210, 1] = nan
    mag[300:350] = nan
    mag[400:410] = 0.0
    for one in FILTERS:
        assert np.allclose(run(one, t, gyro, accel, mag).euler[-1, :2], (0.3, -0.2), atol=radians(0.5))


def test_after_a_gap_the_filter_starts_again():
    t, gyro, accel, mag = still(0.3, 0.0, 0.0)
    upright = still(0.0, 0.0, 0.0)[2]
    times = np.concatenate((t, t + t[-1] + 5.0))
    accel = np.concatenate((accel, upright))
    found = run(GradientDescent(), times, np.tile(gyro, (2, 1)), accel, np.tile(mag, (2, 1)))
    assert abs(degrees(found.euler[len(t), 0])) < 0.01


def test_without_a_magnetometer_the_heading_is_relative():
    t, gyro, accel, _ = still(0.1, 0.2, 2.0)
    found = run(GradientDescent(), t, gyro, accel)
    assert found.north == North.RELATIVE
    assert np.allclose(found.euler[-1], (0.1, 0.2, 0.0), atol=1e-3)


def test_the_gyro_bias_is_shown_in_the_body_of_the_frames():
    t, gyro, accel, mag = still(0.0, 0.0, 0.0, seconds=60.0)
    bias = np.array([0.002, -0.004, 0.006])
    flip = np.array([1.0, -1.0, -1.0])
    found = run(VelocityAided(), t, gyro + bias, accel * flip, mag * flip, frames="FLU/NWU")
    assert np.allclose(found.gyro_biases[-1], bias, atol=0.001)


def test_fixes_of_their_own_times_equal_rows():
    log = read_log(LOG).readings
    rows = np.full((len(log), 3), nan)
    at = np.searchsorted(log.t, log.velocity_t)
    inside = at < len(log)
    rows[at[inside]] = log.velocity[inside]
    by_rows = Readings(log.t, log.gyro, log.accel, log.mag, rows)
    by_fixes = Readings(log.t, log.gyro, log.accel, log.mag, log.velocity[inside], velocity_t=log.t[at[inside]])
    one = run_readings(VelocityAided(), by_rows)
    other = run_readings(VelocityAided(), by_fixes)
    assert np.array_equal(one.attitudes, other.attitudes, equal_nan=True)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gyro": np.zeros((10, 2))}, r"gyro has shape \(10, 2\); expected \(10, 3\)"),
        ({"accel": [[1, 2]]}, r"accel has shape \(1, 2\); expected \(10, 3\)"),
        ({"mag": "north"}, "mag: expected numbers"),
        ({"t": np.zeros(10)}, r"t\[1\] = 0 does not follow 0"),
        ({"t": [nan] * 10}, r"t\[0\] is not finite"),
        ({"t": np.zeros((10, 1))}, r"t has shape \(10, 1\); expected \(n,\)"),
        ({"frames": "NED"}, "unknown frames 'NED'; expected one of FRD/NED, FLU/ENU, FLU/NWU"),
        ({"velocity_t": [1.0]}, "velocity_t and velocity_sigma belong to a velocity"),
        ({"velocity": np.zeros((9, 3))}, r"velocity has shape \(9, 3\); expected \(10, 3\)"),
        ({"velocity": np.zeros((10, 3)), "velocity_sigma": [1.0]}, r"velocity_sigma has shape \(1,\)"),
    ],
)
def test_an_argument_that_does_not_fit_is_named(change, words):
    given = {"t": np.arange(10) / 50.0, "gyro": np.zeros((10, 3)), "accel": np.zeros((10, 3))} | change
    with pytest.raises(ValueError, match=words):
        Readings(**given)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((1.0, (0, 0), (0, 0, -9.8)), "gyro: expected three numbers"),
        ((1.0, (0, 0, 0), (0, 0, "x")), "accel: expected three numbers"),
        ((nan, (0, 0, 0), (0, 0, -9.8)), "t = nan: expected seconds"),
        ((0.5, (0, 0, 0), (0, 0, -9.8)), "t = 0.5 s does not follow 0.5 s"),
    ],
)
def test_a_live_reading_that_does_not_fit_is_named_and_changes_nothing(arguments, words):
    live = LiveAttitude(GradientDescent())
    before = live.update(0.5, (0, 0, 0), (0, 0, -9.8))
    with pytest.raises(ArgumentError, match=words):
        live.update(*arguments)
    assert live.attitude == before
    assert live.update(0.6, (0, 0, 0), (0, 0, -9.8)) is not None


def test_a_live_velocity_counts_from_its_reading_on():
    live = LiveAttitude(VelocityAided(FlightParameters(low_pass_hz=0.0, fix_delay_s=0.0)), declination=0.0)
    for k in range(500):
        t = 0.02 * k
        live.update(t, (0, 0, 0), (0, 0, -G), (0.2, 0, 0.44), (1.0, 0.0, 0.0) if k % 10 == 0 else None)
    assert live.north == North.TRUE
    assert live.heading_sigma < radians(15.0)
    aids = {one.aid for one in live.innovations}
    live.update(10.0, (0, 0, 0), (0, 0, -G), (0.2, 0, 0.44), (1.0, 0.0, nan))
    assert Aid.VELOCITY in {one.aid for one in live.innovations} | aids


def test_every_exported_name_is_there_and_numpy_only_where_it_is_needed():
    for name in attest_mav.__all__:
        assert getattr(attest_mav, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        attest_mav.nothing  # noqa: B018 - the access is what is tested
    program = "import sys; from attest_mav import LiveAttitude, VelocityAided; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_a_solution_pickles_with_the_innovations_that_nobody_asked_for_yet():
    t, _, gyro, accel, mag = wobbling(seconds=2.0)
    solution = run(RobustAdaptive(), t, gyro, accel, mag)
    copied = pickle.loads(pickle.dumps(solution))  # noqa: S301 - made here
    assert np.array_equal(copied.innovations.residual, solution.innovations.residual, equal_nan=True)
    assert len(copied.innovations.reading) > 0


@pytest.mark.parametrize("one", FILTERS, ids=IDS)
def test_the_turn_during_missing_readings_is_not_lost(one):
    """Half a second without a gyro while the sensor turns at 0.5 rad/s about the vertical: 14 degrees."""
    t = np.arange(0.0, 20.0, 0.02)
    gyro = np.tile([0.0, 0.0, 0.5], (len(t), 1))
    gyro[500:525] = nan
    accel = np.tile([0.0, 0.0, -9.80665], (len(t), 1))
    found = run(one, t, gyro, accel).euler[:, 2]
    turned = degrees(found[530] - found[490]) % 360.0
    assert turned == pytest.approx(degrees(0.5 * 40 * 0.02), abs=0.5)
