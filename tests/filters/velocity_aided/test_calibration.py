"""Sensor errors of earlier flights: learned, carried on to the next flight, refuted where they are another sensor's."""

from math import exp, sqrt

import numpy as np
import pytest

from attest_mav.filters.calibration import SensorCalibration, UncertainVector
from attest_mav.filters.velocity_aided.calibration import at_start, unknown
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import diagonal

from .conftest import ZERO, rms

BIAS = (0.15, -0.15, 0.15)
IRON = (0.012, -0.012, 0.012)
OTHER_BIAS = (-0.15, 0.15, -0.15)
OTHER_IRON = (-0.012, 0.012, -0.012)
DAY_S = 86400.0


@pytest.fixture(scope="module")
def earlier(copter, telemetry):
    """The errors as a flight of 90 s has shown them."""
    states = telemetry(copter, accel_bias=BIAS, hard_iron=IRON, seed=1).run()
    return VelocityAided().learned(states[-1])


@pytest.fixture(scope="module")
def later(copter, telemetry):
    """Another flight with the same sensor."""
    return telemetry(copter, accel_bias=BIAS, hard_iron=IRON, seed=2)


def sigmas(vector):
    return np.sqrt(np.diag(np.array(vector.covariance)))


def test_a_flight_shows_the_errors_within_their_sigmas(earlier):
    assert np.all(np.abs(np.array(earlier.accel_bias.mean) - BIAS) < 3.0 * sigmas(earlier.accel_bias))
    assert np.all(np.abs(np.array(earlier.hard_iron.mean) - IRON) < 3.0 * sigmas(earlier.hard_iron))
    assert np.all(sigmas(earlier.accel_bias)[:2] < 0.05)
    assert np.all(sigmas(earlier.hard_iron)[:2] < 0.005)


def test_a_vehicle_that_only_stood_has_shown_none(copter_log):
    states = copter_log.run(last=450)
    assert states[-1].aligned
    assert VelocityAided().learned(states[-1]) is None


def test_the_next_flight_is_nearer_to_the_truth_from_its_start(earlier, later):
    states = {known: later.run(one) for known, one in choices(earlier)}
    tilt = {known: rms(later.errors(found)[0][:1500]) for known, found in states.items()}
    heading = {known: rms(later.errors(found)[1][:1500]) for known, found in states.items()}
    assert tilt[True] < 0.5 * tilt[False]
    assert heading[True] < 0.6 * heading[False]
    assert states[True][-1].is_calibrated
    assert not states[False][-1].is_calibrated


def choices(known):
    one = VelocityAided()
    return (True, one.with_calibration(known)), (False, one)


def test_sigma_covers_the_error_of_the_next_flight(earlier, later):
    states = later.run(VelocityAided().with_calibration(earlier))
    tilt, heading = later.errors(states)
    sigma_deg = np.degrees([(one.tilt_sigma, one.heading_sigma) for one in states])
    aligned = np.isfinite(tilt)
    assert rms(tilt[aligned] / sigma_deg[aligned, 0]) < 1.25
    assert rms(heading[aligned] / sigma_deg[aligned, 1]) < 1.7


def test_the_errors_of_another_sensor_are_refuted_in_the_first_manoeuvre_and_learned_anew(earlier, copter, telemetry):
    flight = telemetry(copter, accel_bias=OTHER_BIAS, hard_iron=OTHER_IRON, seed=3)
    one = VelocityAided().with_calibration(earlier)
    states = flight.run(one)
    calibrated = [state.is_calibrated for state in states]
    assert any(calibrated)
    assert not any(calibrated[20 * 50 :]), "the copter has moved for ten seconds"
    tilt, heading = flight.errors(states)
    sigma_deg = np.degrees([(state.tilt_sigma, state.heading_sigma) for state in states])
    end = slice(-1500, None)
    assert rms(tilt[end] / sigma_deg[end, 0]) < 1.25
    assert rms(heading[end] / sigma_deg[end, 1]) < 1.7
    anew = one.learned(states[-1])
    assert np.all(np.abs(np.array(anew.accel_bias.mean) - OTHER_BIAS) < 3.0 * sigmas(anew.accel_bias))


@pytest.mark.parametrize("age_days", [0.0, 30.0, 360.0])
def test_errors_wander_between_flights_as_a_gauss_markov_process(age_days):
    """Nine tenths of the variance outlast a start, and half a year leaves 1/e of them."""
    share = 0.9 * exp(-age_days / 180.0)
    known = SensorCalibration(
        UncertainVector((0.1, 0.2, -0.3), ((4e-4, 1e-4, 0.0), (1e-4, 9e-4, 0.0), (0.0, 0.0, 1e-4))),
        UncertainVector((0.01, 0.0, 0.0), diagonal(1e-6)),
        age_days * DAY_S,
    )
    begun = at_start(known, FlightParameters(accel_bias_sigma=0.2, hard_iron=0.02))
    assert begun.accel_bias.mean == pytest.approx([sqrt(share) * x for x in known.accel_bias.mean])
    lost = (1.0 - share) * 0.04
    assert begun.accel_bias.covariance[0] == pytest.approx((share * 4e-4 + lost, share * 1e-4, 0.0))
    assert begun.accel_bias.covariance[1][1] == pytest.approx(share * 9e-4 + lost)
    assert begun.hard_iron.covariance[2][2] == pytest.approx(share * 1e-6 + (1.0 - share) * 4e-4)


def test_errors_of_long_ago_are_those_of_any_sensor(earlier):
    old = SensorCalibration(earlier.accel_bias, earlier.hard_iron, 1e10)
    parameters = FlightParameters()
    begun, usual = at_start(old, parameters), unknown(parameters)
    assert begun.accel_bias.mean == pytest.approx(ZERO, abs=1e-6)
    assert np.array(begun.accel_bias.covariance) == pytest.approx(np.array(usual.accel_bias.covariance))


def test_an_error_that_is_not_estimated_is_not_carried_on_either(earlier):
    begun = at_start(earlier, FlightParameters(hard_iron=0.0))
    assert begun.hard_iron.mean == ZERO
    assert np.all(np.array(begun.hard_iron.covariance) == 0.0)


def test_the_settings_of_the_vehicle_leave_the_errors_as_they_are(earlier):
    one = VelocityAided().with_calibration(earlier)
    assert one.with_vehicle_settings(one.default_settings).calibration is earlier
