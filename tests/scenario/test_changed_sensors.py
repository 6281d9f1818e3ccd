"""A sensor that was exchanged, or calibrated anew, since earlier flights have shown its errors."""

import pytest

from attest_mav.algebra import add
from attest_mav.estimation.events import LaneEventKind
from attest_mav.filters.calibration import SensorCalibration, SensorIdentity, UncertainVector
from attest_mav.matrices import diagonal
from attest_mav.samples import ImuSample
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import ACCELEROMETERS, MAGNETOMETERS, Setting

from .flying import fly

LANE = "RAW_IMU"
ZERO = (0.0, 0.0, 0.0)
BIAS = (0.2, -0.2, 0.2)
IRON = (0.0, 0.03, 0.0)
ACCEL, MAG = SensorIdentity(5, 0, ZERO), SensorIdentity(6, 0, ZERO)
CALIBRATIONS = {
    LANE: SensorCalibration(
        UncertainVector(BIAS, diagonal(1e-4)), UncertainVector(IRON, diagonal(1e-6)), 0.0, ACCEL, MAG
    )
}
KINDS = (LaneEventKind.CALIBRATED, LaneEventKind.UNCALIBRATED, LaneEventKind.RECALIBRATED)


def told(accel=ACCEL, mag=MAG):
    """The parameters of these two sensors."""
    values = {}
    for sensor, device, offset, settings in (
        (accel, "INS_ACC_ID", "INS_ACCOFFS", ACCELEROMETERS[0]),
        (mag, "COMPASS_DEV_ID", "COMPASS_OFS", MAGNETOMETERS[0]),
    ):
        values[device] = (settings.device, sensor.device)
        values["AHRS_ORIENTATION"] = (Setting.BOARD_ORIENTATION, sensor.orientation)
        for axis, setting, value in zip("XYZ", settings.offset, sensor.offset, strict=True):
            values[f"{offset}_{axis}"] = (setting, value)
    return values


def with_errors(bias=ZERO, iron=ZERO, from_s=0.0):
    """What a sample reads in place of the simulator's."""

    def reads(sample):
        if not isinstance(sample, ImuSample) or sample.rx_ns < from_s * 1e9:
            return sample
        mag = None if sample.mag is None else add(sample.mag, iron)
        return sample.with_readings(sample.gyro, add(sample.accel, bias), mag)

    return reads


def flown(parameters, at_s, heard, until_s=9.0, calibrations=CALIBRATIONS, at_first=None, **choices):
    """A flight with one sensor, whose autopilot tells these parameters then, and others at first."""
    waiting = [(0.0, one) for one in (at_first or {}).items()] + [(at_s, one) for one in parameters.items()]

    def tell(pipeline, now_ns):
        while waiting and now_ns >= waiting[0][0] * 1e9:
            _, (name, (setting, value)) = waiting.pop(0)
            pipeline.handle(ParameterSample("PARAM_VALUE", 1, 1, now_ns, name, setting, value))

    choices = {"scenario": "still", "fast_rate_hz": 25.0} | choices
    return fly(until_s, "velocity-aided", heard=heard, meddle=tell, calibrations=calibrations, **choices)


def lines(flight):
    return [(event.kind, event.text) for event in flight.lane_events if event.kind in KINDS]


def begins(errors):
    return LaneEventKind.CALIBRATED, f"begins with the {errors} of earlier flights"


LESS = "of before is taken less that change"
BOTH = "accelerometer bias and hard iron"
CHANGES = [
    (
        {"accel": SensorIdentity(7, 0, ZERO)},
        with_errors(iron=IRON),
        (
            LaneEventKind.UNCALIBRATED,
            "INS_ACC_ID is 7 instead of 5: the accelerometer bias of before counts as unknown",
        ),
        "hard iron",
    ),
    (
        {"mag": SensorIdentity(9, 0, ZERO)},
        with_errors(bias=BIAS),
        (LaneEventKind.UNCALIBRATED, "COMPASS_DEV_ID is 9 instead of 6: the hard iron of before counts as unknown"),
        "accelerometer bias",
    ),
    (
        {"accel": SensorIdentity(5, 0, BIAS)},
        with_errors(iron=IRON),
        (
            LaneEventKind.RECALIBRATED,
            f"INS_ACCOFFS_X subtracts 0.2 m/s^2 instead of 0: the accelerometer bias {LESS}",
        ),
        BOTH,
    ),
    (
        {"mag": SensorIdentity(6, 0, IRON)},
        with_errors(bias=BIAS),
        (
            LaneEventKind.RECALIBRATED,
            f"COMPASS_OFS_Y subtracts 0.03 gauss instead of 0: the hard iron {LESS}",
        ),
        BOTH,
    ),
]
"""The sensors that are there now, what they read, the line that says so, and the errors that are still known."""


@pytest.mark.parametrize(("sensors", "heard", "line", "left"), CHANGES)
def test_a_change_that_is_known_at_the_start_is_in_the_first_attitude(sensors, heard, line, left):
    flight = flown(told(**sensors), 0.0, heard)
    assert lines(flight) == [line, begins(left)]
    assert max(max(pair) for pair in flight.normalised()) < 2.0
    assert max(flight.worst(4.0)) < 1.5


@pytest.mark.parametrize(("sensors", "heard", "line"), [one[:3] for one in CHANGES])
def test_a_change_that_is_told_later_takes_effect_then(sensors, heard, line):
    flight = flown(told(**sensors), 4.0, heard)
    assert lines(flight) == [begins(BOTH), line]
    assert max(max(pair) for pair in flight.normalised(6.0)) < 2.0
    assert max(flight.worst(6.0)) < 1.5
    assert LaneEventKind.RESTARTED not in flight.kinds()


def test_the_offset_of_another_device_that_is_told_later_is_no_change():
    parameters = told(accel=SensorIdentity(7, 0, BIAS))
    device = {"INS_ACC_ID": parameters["INS_ACC_ID"]}
    flight = flown(parameters, 4.0, with_errors(iron=IRON), at_first=device)
    assert lines(flight) == [CHANGES[0][2], begins("hard iron")]


def test_a_board_that_is_turned_is_another_sensor():
    turned = {"accel": SensorIdentity(5, 4, ZERO), "mag": SensorIdentity(6, 4, ZERO)}
    ((kind, text),) = lines(flown(told(**turned), 0.0, with_errors()))
    assert kind == LaneEventKind.UNCALIBRATED
    assert text == (
        "AHRS_ORIENTATION is 4 instead of 0: the accelerometer bias of before counts as unknown; "
        "AHRS_ORIENTATION is 4 instead of 0: the hard iron of before counts as unknown"
    )


@pytest.fixture(scope="module")
def untold():
    """The flight of an autopilot that tells nothing."""
    return flown({}, 0.0, with_errors(BIAS, IRON))


@pytest.mark.parametrize("at_s", [0.0, 4.0])
@pytest.mark.parametrize(
    "parameters",
    [
        told(),
        told(accel=SensorIdentity(5, 0, (0.02, 0.0, -0.02)), mag=SensorIdentity(6, 0, (0.002, 0.0, -0.002))),
        told(accel=SensorIdentity(0, 0, ZERO), mag=SensorIdentity(0, 0, ZERO)),
    ],
    ids=["same", "drift", "not found"],
)
def test_what_is_no_change_changes_nothing(parameters, at_s, untold):
    flight = flown(parameters, at_s, with_errors(BIAS, IRON))
    assert lines(flight) == [begins(BOTH)]
    assert [one.q_nb for one in flight.estimates] == [one.q_nb for one in untold.estimates]


def test_a_calibration_without_sensors_holds_for_any():
    of_any = {LANE: SensorCalibration(CALIBRATIONS[LANE].accel_bias, CALIBRATIONS[LANE].hard_iron)}
    assert lines(flown(told(), 5.0, with_errors(BIAS, IRON), calibrations=of_any)) == [begins(BOTH)]


def test_a_compass_that_learns_in_flight_leaves_the_heading_right():
    """The offset changes by 0.05 gauss, and the field with it; unknown to us, that makes 1.1 degrees of heading."""
    jumps = with_errors(iron=(0.03, -0.04, 0.0), from_s=20.0)
    learned = told(mag=SensorIdentity(6, 0, (-0.03, 0.04, 0.0)))
    choices = {"calibrations": {}, "at_first": told(), "scenario": "square", "fast_rate_hz": 50.0}
    flight = flown(learned, 20.0, jumps, 40.0, **choices)
    text = f"COMPASS_OFS_Y subtracts 0.04 gauss instead of 0: the hard iron {LESS}"
    assert lines(flight) == [(LaneEventKind.RECALIBRATED, text)]
    assert flight.worst(22.0)[1] < 0.8
