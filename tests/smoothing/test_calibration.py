"""Sensor errors of earlier flights in the smoother: used where they are right, and refuted where a flight shows it."""

import numpy as np
import pytest

from attest_mav import FlightParameters, Readings
from attest_mav.estimation.sequence_rows import Columns
from attest_mav.filters.calibration import SensorCalibration, UncertainVector
from attest_mav.library.running import sequence_of, stretches
from attest_mav.smoothing.recorder import Recorder
from attest_mav.smoothing.trajectory import SmoothedParts
from attest_mav.types import G_MPS2

PARAMETERS = FlightParameters()
BIAS = (0.08, -0.06, 0.05)
ACCEL_SIGMA, IRON_SIGMA = 0.03, 0.003  # m/s^2, gauss


def calibration(bias=BIAS, iron=(0.0, 0.0, 0.0)):
    def known(mean, sigma):
        return UncertainVector(mean, tuple(map(tuple, (sigma**2 * np.eye(3)).tolist())))

    return SensorCalibration(known(bias, ACCEL_SIGMA), known(iron, IRON_SIGMA))


def smoothed(columns, known=None):
    recorder = Recorder(PARAMETERS)
    readings = Readings(*columns, declination=0.0)
    for _ in stretches(sequence_of(recorder, readings), readings, Columns):
        pass
    return SmoothedParts(recorder.recording(), PARAMETERS, known)


@pytest.fixture
def hovering():
    """20 s at one place, level, to the north; the receiver says so, and the accelerometer has a bias."""
    t = np.arange(0.0, 20.0, 0.02)
    velocity = np.full((len(t), 3), np.nan)
    velocity[::10] = 0.0
    gyro = 1e-3 * np.random.default_rng(1).standard_normal((len(t), 3))
    return t, gyro, np.tile(BIAS, (len(t), 1)) - [0.0, 0.0, G_MPS2], np.tile([0.2, 0.0, 0.45], (len(t), 1)), velocity


@pytest.fixture(scope="module")
def manoeuvring(flown):
    return flown.t, flown.gyro, flown.accel + BIAS, flown.mag, flown.velocity


@pytest.fixture(scope="module")
def alone(manoeuvring):
    """The manoeuvring flight without a calibration."""
    return smoothed(manoeuvring).whole()


def tilt_deg(found):
    """Of the body's vertical against that of a level one."""
    _, x, y, _ = found.q_nb.T
    return np.degrees(2.0 * np.arcsin(np.hypot(x, y)))


def test_a_hovering_vehicle_has_the_tilt_that_its_calibration_shows(hovering):
    without, known = smoothed(hovering).whole(), smoothed(hovering, calibration())
    assert tilt_deg(without).min() > 0.5  # 0.1 m/s^2 of gravity are 0.58 degrees
    assert not known.has_refuted
    found = known.whole()
    assert tilt_deg(found).max() < 0.05
    assert found.tilt_sigma.max() < 0.5 * without.tilt_sigma.min()


def test_a_flight_agrees_with_its_calibration(manoeuvring, alone):
    known = smoothed(manoeuvring, calibration())
    assert not known.has_refuted
    assert (known.whole().tilt_sigma <= alone.tilt_sigma).all()


@pytest.mark.parametrize(
    "false",
    [calibration((0.38, -0.36, 0.35)), calibration(iron=(0.04, -0.04, 0.04))],
    ids=["accelerometer", "iron"],
)
def test_a_flight_that_contradicts_its_calibration_is_smoothed_without(manoeuvring, alone, false):
    refuted = smoothed(manoeuvring, false)
    assert refuted.has_refuted
    found = refuted.whole()
    np.testing.assert_array_equal(found.q_nb, alone.q_nb)
    np.testing.assert_array_equal(found.tilt_sigma, alone.tilt_sigma)


def test_in_place_the_readings_alone_tell_the_iron(hovering):
    """The iron was taken off by the strength; taken off once more it would turn the heading by 17 degrees."""
    t, gyro, accel, mag, _ = hovering
    columns = (t, gyro, accel, mag, None)
    found = smoothed(columns, calibration(iron=(0.0, 0.06, 0.0))).whole()
    np.testing.assert_array_equal(found.q_nb, smoothed(columns, calibration()).whole().q_nb)
