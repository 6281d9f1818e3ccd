"""The accelerometers of two sensors that stand side by side before a flight show the scale of their biases."""

import pytest

from attest_mav.algebra import add, scale
from attest_mav.estimation.events import LaneEventKind
from attest_mav.filters.calibration import SensorCalibration, UncertainVector
from attest_mav.filters.registry import default_filter
from attest_mav.matrices import diagonal
from attest_mav.samples import ImuSample

from .flying import fly

FIRST, SECOND = "RAW_IMU", "SCALED_IMU2"
ZERO = (0.0, 0.0, 0.0)
BIAS = (0.2, -0.2, 0.2)
KNOWN = SensorCalibration(UncertainVector(ZERO, diagonal(1e-4)), UncertainVector(ZERO, diagonal(1e-6)))


def biased(first, second):
    """Samples whose accelerometers read more by so many times ``BIAS``."""
    more = {FIRST: scale(BIAS, first), SECOND: scale(BIAS, second)}

    def heard(sample):
        if isinstance(sample, ImuSample):
            return sample.with_readings(sample.gyro, add(sample.accel, more[sample.source]), sample.mag)
        return sample

    return heard


def stands(heard, calibrations):
    """Twelve seconds on the ground."""
    others = {"others": (SECOND,), "calibrations": calibrations}
    return fly(12.0, "velocity-aided", scenario="still", heard=heard, fast_rate_hz=25.0, **others)


def kinds(flight, kind):
    return {event.lane for event in flight.lane_events if event.kind == kind}


@pytest.mark.parametrize("errors", [(0.0, 1.0), (1.0, 0.0)])
def test_one_of_two_calibrations_that_does_not_hold_any_more_refutes_both_on_the_ground(errors):
    """An accelerometer was calibrated anew, and reads 0.35 m/s^2 more than it did."""
    flight = stands(biased(*errors), {FIRST: KNOWN, SECOND: KNOWN})
    assert kinds(flight, LaneEventKind.CALIBRATED) == {FIRST, SECOND}
    assert kinds(flight, LaneEventKind.UNCALIBRATED) == {FIRST, SECOND}
    # 0.28 m/s^2 are 1.7 degrees.
    worst, _ = max(flight.normalised(from_s=8.0))
    assert worst < 2.5


@pytest.mark.parametrize("errors", [(0.0, 0.0), (1.0, 1.0)])
def test_two_calibrations_that_explain_the_difference_hold(errors):
    flight = stands(biased(*errors), {FIRST: KNOWN, SECOND: KNOWN})
    assert kinds(flight, LaneEventKind.CALIBRATED) == {FIRST, SECOND}
    assert kinds(flight, LaneEventKind.UNCALIBRATED) == set()


@pytest.mark.parametrize("size", [1.0, 1.75, 3.0])
def test_a_stale_calibration_is_no_fault_of_the_sensor(size):
    """Up to 0.6 m/s^2 an axis: beyond what two sensors in good order may differ by, had the calibration been right."""
    wrong = SensorCalibration(UncertainVector(scale(BIAS, size), diagonal(1e-4)), UncertainVector(ZERO, diagonal(1e-6)))
    flight = stands(biased(0.0, 0.0), {FIRST: wrong, SECOND: KNOWN})
    assert kinds(flight, LaneEventKind.UNCALIBRATED) == {FIRST, SECOND}
    assert kinds(flight, LaneEventKind.FAULTY) == set()
    worst, _ = max(flight.normalised(from_s=8.0))
    assert worst < 1.0


def test_a_refuted_calibration_does_not_come_back_with_a_reboot():
    flight = fly(
        45.0,
        "velocity-aided",
        ["reboot@20"],
        scenario="still",
        heard=biased(0.0, 1.0),
        others=(SECOND,),
        calibrations={FIRST: KNOWN, SECOND: KNOWN},
        fast_rate_hz=25.0,
    )
    assert kinds(flight, LaneEventKind.REBOOTED)
    begun = [event for event in flight.lane_events if event.kind == LaneEventKind.CALIBRATED]
    assert len(begun) == 2, "before the reboot"


def test_what_the_flight_itself_has_shown_holds_after_the_next_reboot():
    """As a service gives it: the filters take it while they run, and begin with it."""
    shown = SensorCalibration(UncertainVector(BIAS, diagonal(1e-4)), KNOWN.hard_iron)
    given = []

    def give(pipeline, now_ns):
        if now_ns > 15e9 and not given:
            given.append(now_ns)
            pipeline.vehicle.calibrations = {FIRST: KNOWN, SECOND: shown}
            pipeline.use_filter(default_filter("velocity-aided"))

    flight = fly(
        30.0,
        "velocity-aided",
        ["reboot@20"],
        scenario="still",
        heard=biased(0.0, 1.0),
        others=(SECOND,),
        calibrations={FIRST: KNOWN, SECOND: KNOWN},
        meddle=give,
        fast_rate_hz=25.0,
    )
    begun = [event.lane for event in flight.lane_events if event.kind == LaneEventKind.CALIBRATED]
    assert sorted(begun) == [FIRST, FIRST, SECOND, SECOND]
    assert [event.kind for event in flight.lane_events].count(LaneEventKind.UNCALIBRATED) == 2


def test_a_sensor_that_returns_has_learned_nothing_from_the_other_and_contradicts_nothing():
    learned = {}

    def look(pipeline, now_ns):
        if now_ns > 25e9:
            learned.update(pipeline.learned)

    flight = fly(
        26.0,
        "velocity-aided",
        ["gyro1-bias-x=5@8+5"],
        scenario="still",
        others=(SECOND,),
        calibrations={FIRST: KNOWN, SECOND: KNOWN},
        meddle=look,
    )
    assert kinds(flight, LaneEventKind.RETURNED) == {FIRST}
    assert kinds(flight, LaneEventKind.UNCALIBRATED) == set()
    assert learned == {}
