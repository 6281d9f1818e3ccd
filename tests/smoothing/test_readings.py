"""The smoother over a motion that is known exactly."""

import numpy as np
import pytest

from attest_mav import ArgumentError, FlightParameters, North, Readings, smooth_readings

# Readings and fixes are of the instants that they name: no low-pass, no delay.
EXACT = FlightParameters(low_pass_hz=0.0, low_pass_delay_sigma=0.0, fix_delay_s=0.0, mag_delay_s=0.0)


def smooth(t, gyro, accel, mag, velocity, declination=0.0):
    return smooth_readings(Readings(t, gyro, accel, mag, velocity, declination=declination), EXACT)


def errors_deg(solution, q):
    """Tilt and heading errors of each instant but the first."""
    w, x, y, z = (solution.attitudes[1:] * q[1:]).sum(axis=1), *_difference(solution.attitudes[1:], q[1:])
    tilt = 2.0 * np.degrees(np.arcsin(np.minimum(1.0, np.hypot(x, y))))
    return tilt, 2.0 * np.degrees(np.arctan(z / w))


def _difference(q, true):
    """Vector part of q times the inverse of the true attitude: the error as seen in NED."""
    vector = -q[:, :1] * true[:, 1:] + true[:, :1] * q[:, 1:] - np.cross(q[:, 1:], true[:, 1:])
    return vector.T


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


def test_exact_readings_give_the_attitude_from_the_first_sample_on(flown):
    found = smooth(flown.t, flown.gyro, flown.accel, flown.mag, flown.velocity)
    tilt, heading = errors_deg(found, flown.q)
    assert rms(tilt) < 0.02
    assert rms(heading) < 0.02
    assert found.north == North.TRUE
    assert not found.aligned[0]
    assert found.aligned[1:].all()


def test_biases_are_found_and_do_not_stay_in_the_attitude(flown):
    gyro = flown.gyro + np.array([0.005, -0.004, 0.003])
    accel = flown.accel + np.array([0.05, -0.05, 0.05])
    found = smooth(flown.t, gyro, accel, flown.mag, flown.velocity)
    tilt, heading = errors_deg(found, flown.q)
    # An accelerometer that is off by 0.05 m/s^2 leans a filter without its bias by 0.3 degrees.
    assert rms(tilt) < 0.1
    assert rms(heading) < 0.1
    np.testing.assert_allclose(
        found.gyro_biases[1001:], np.tile([0.005, -0.004, 0.003], (len(flown.t) - 1001, 1)), atol=1e-3
    )


@pytest.mark.parametrize("wild", [100.0, 1e4])
def test_one_wild_fix_does_no_harm(flown, wild):
    velocity = flown.velocity.copy()
    velocity[1000] += wild
    found = smooth(flown.t, flown.gyro, flown.accel, flown.mag, velocity)
    tilt, heading = errors_deg(found, flown.q)
    assert tilt.max() < 0.1
    assert np.abs(heading).max() < 0.2


def test_a_gap_is_one_problem_with_the_rest(flown):
    kept = (flown.t < 18.0) | (flown.t >= 23.0)
    parts = [array[kept] for array in (flown.t, flown.gyro, flown.accel, flown.mag, flown.velocity)]
    found = smooth(*parts)
    tilt, heading = errors_deg(found, flown.q[kept])
    assert tilt.max() < 0.1
    assert np.abs(heading).max() < 0.2


def test_one_reading_behind_a_gap_has_an_attitude_of_its_own_and_a_large_sigma(flown):
    kept = (flown.t < 20.0) | (np.arange(len(flown.t)) == len(flown.t) - 1)
    parts = [array[kept] for array in (flown.t, flown.gyro, flown.accel, flown.mag, flown.velocity)]
    found = smooth(*parts)
    assert len(found.attitudes) == np.count_nonzero(kept)
    assert found.tilt_sigma[-1] > 0.1
    assert errors_deg(found, flown.q[kept])[0][:-1].max() < 0.1


def test_sigma_covers_the_errors_of_noisy_sensors(flown):
    rng = np.random.default_rng(3)
    gyro = flown.gyro + 0.003 * rng.standard_normal(flown.gyro.shape)
    accel = flown.accel + 0.2 * rng.standard_normal(flown.accel.shape)
    mag = flown.mag + 0.003 * rng.standard_normal(flown.mag.shape)
    velocity = flown.velocity + 0.1 * rng.standard_normal(flown.velocity.shape)
    found = smooth(flown.t, gyro, accel, mag, velocity)
    tilt, heading = errors_deg(found, flown.q)
    assert rms(tilt / np.degrees(found.tilt_sigma[1:])) < 1.2
    assert rms(heading / np.degrees(found.heading_sigma[1:])) < 1.2
    assert np.degrees(found.tilt_sigma[1:]).max() < 2.0


def test_without_fixes_a_sensor_that_stays_in_place_keeps_its_tilt(flown):
    still = np.tile(flown.accel[:1] * 0.0 + [0.0, 0.0, -9.80665], (len(flown.t), 1))
    gyro = np.zeros_like(flown.gyro)
    found = smooth(flown.t, gyro, still, np.tile([0.2, 0.0, 0.45], (len(flown.t), 1)), None)
    level = np.tile([1.0, 0.0, 0.0, 0.0], (len(flown.t), 1))
    tilt, heading = errors_deg(found, level)
    assert tilt.max() < 0.05
    assert np.abs(heading).max() < 0.05


def test_without_a_declination_headings_are_magnetic(flown):
    found = smooth(flown.t, flown.gyro, flown.accel, flown.mag, flown.velocity, np.nan)
    assert found.north == North.MAGNETIC


def test_the_axes_of_the_readings_are_those_of_the_attitudes(flown):
    flip = np.array([1.0, -1.0, -1.0])
    arrays = [flown.t, flip * flown.gyro, flip * flown.accel, flip * flown.mag, flip * flown.velocity]
    found = smooth_readings(Readings(*arrays, declination=0.0, frames="FLU/NWU"), EXACT)
    expected = smooth(flown.t, flown.gyro, flown.accel, flown.mag, flown.velocity).attitudes * [1.0, 1.0, -1.0, -1.0]
    signs = np.sign((found.attitudes * expected).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(found.attitudes, signs * expected, atol=1e-12)


def test_rows_that_are_no_reading_stay_without_an_attitude(flown):
    gyro = flown.gyro.copy()
    gyro[700:703] = np.nan
    found = smooth(flown.t, gyro, flown.accel, flown.mag, flown.velocity)
    assert np.flatnonzero(~found.aligned).tolist() == [0, 700, 701, 702]
    assert np.isnan(found.attitudes[700:703]).all()
    assert len(found.innovations.reading) == 0
    known = found.aligned
    assert np.nanmax(errors_deg(found, flown.q)[0][known[1:]]) < 0.1


def test_readings_without_an_attitude_are_refused_in_words(flown):
    with pytest.raises(ArgumentError, match="no attitude to begin with"):
        smooth(flown.t, np.full_like(flown.gyro, np.nan), flown.accel, flown.mag, None)
