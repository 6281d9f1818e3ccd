"""Files with the errors of sensors."""

import json

import pytest

from attest_mav.config.calibration import (
    MAX_SENSORS,
    calibrations_of,
    calibrations_text,
    kept_calibration,
    newest,
    parse_calibrations,
    with_learned,
)
from attest_mav.filters.calibration import SensorCalibration, SensorIdentity, UncertainVector

BIAS = UncertainVector((0.1, -0.2, 0.3), ((4e-4, 1e-5, 0.0), (1e-5, 5e-4, 0.0), (0.0, 0.0, 6e-4)))
IRON = UncertainVector((0.01, -0.02, 0.03), ((1e-6, 0.0, 0.0), (0.0, 1e-6, 0.0), (0.0, 0.0, 1e-6)))
KNOWN = SensorCalibration(BIAS, IRON)


def text_of(**changes):
    vector = {"mean": [0, 0, 0], "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    sensor = {"accel_bias": vector, "hard_iron": vector, "learned_unix_s": 1.0} | changes
    return json.dumps({"calibrations": {"1/RAW_IMU": sensor}}).encode()


def test_the_sensors_of_the_errors_are_kept_where_they_were_told():
    accel, mag = SensorIdentity(2753028, 4, (0.1, -0.2, 0.0)), SensorIdentity(97539)
    kept = {"1/RAW_IMU": kept_calibration(SensorCalibration(BIAS, IRON, 0.0, accel, mag), 0.0)}
    found = calibrations_of(parse_calibrations(calibrations_text(kept)), 1, 0.0)["RAW_IMU"]
    told = (found.accelerometer.device, found.accelerometer.orientation, found.accelerometer.offset)
    assert told == (2753028, 4, (0.1, -0.2, 0.0))
    assert (found.magnetometer.device, found.magnetometer.orientation, found.magnetometer.offset) == (97539, None, None)


def test_a_file_of_before_sensors_were_told_reads_and_is_written_as_it_was():
    text = calibrations_text({"1/RAW_IMU": kept_calibration(KNOWN, 0.0)})
    assert set(json.loads(text)["calibrations"]["1/RAW_IMU"]) == {"accel_bias", "hard_iron", "learned_unix_s"}
    found = calibrations_of(parse_calibrations(text), 1, 0.0)["RAW_IMU"]
    assert (found.accelerometer.device, found.magnetometer.offset) == (None, None)


def test_what_is_written_is_read_again_to_the_last_digit():
    kept = {"1/RAW_IMU": kept_calibration(KNOWN, 1000.0)}
    found = calibrations_of(parse_calibrations(calibrations_text(kept)), 1, 1000.0 + 3.5 * 86400.0)["RAW_IMU"]
    assert found.accel_bias.mean == BIAS.mean
    assert found.accel_bias.covariance == BIAS.covariance
    assert found.hard_iron.mean == IRON.mean
    assert found.hard_iron.covariance == IRON.covariance
    assert found.age_s == 3.0 * 86400.0, "whole days"


def test_each_vehicle_has_its_own_sensors():
    kept = {f"{system}/RAW_IMU": kept_calibration(KNOWN, 0.0) for system in (1, 11)}
    assert calibrations_of(kept, 1, 0.0).keys() == {"RAW_IMU"}
    assert calibrations_of(kept, 2, 0.0) == {}


def test_a_clock_that_is_behind_makes_nothing_younger_than_new():
    assert calibrations_of({"1/RAW_IMU": kept_calibration(KNOWN, 2000.0)}, 1, 5.0)["RAW_IMU"].age_s == 0.0


def test_the_sensors_that_were_learned_last_are_kept_whatever_the_clock_said():
    kept = {f"{n}/RAW_IMU": kept_calibration(KNOWN, 1000.0 - n) for n in range(1, 2 * MAX_SENSORS)}
    assert set(newest(kept)) == {f"{n}/RAW_IMU" for n in range(MAX_SENSORS, 2 * MAX_SENSORS)}


def test_a_sensor_that_is_learned_again_is_the_last_one():
    kept = {f"{n}/RAW_IMU": kept_calibration(KNOWN, 0.0) for n in range(1, MAX_SENSORS + 1)}
    again = with_learned(kept, {"1/RAW_IMU": kept_calibration(KNOWN, 0.0)})
    assert [*again][-1] == "1/RAW_IMU"
    assert with_learned(again, {"99/RAW_IMU": again["1/RAW_IMU"]}).keys() == {
        *(f"{n}/RAW_IMU" for n in range(3, MAX_SENSORS + 1)),
        "1/RAW_IMU",
        "99/RAW_IMU",
    }


@pytest.mark.parametrize("name", ["RAW_IMU", "IMU2", "sensor_combined", "vehicle_imu_1"])
def test_the_streams_of_every_kind_of_log_can_be_kept(name):
    text = calibrations_text({f"255/{name}": kept_calibration(KNOWN, None)})
    found = calibrations_of(parse_calibrations(text), 255, 1e9)
    assert found[name].age_s == 0.0, "nobody knew the time"


@pytest.mark.parametrize("mean", [(float("nan"), 0.0, 0.0), (0.0, float("inf"), 0.0), (0.0, 0.0, 1e3)])
def test_an_estimate_that_is_no_number_is_not_kept(mean):
    with pytest.raises(ValueError, match="expected numbers up to 100"):
        kept_calibration(SensorCalibration(UncertainVector(mean, BIAS.covariance), IRON), 0.0)


def test_a_state_file_of_a_service_is_such_a_file():
    state = json.loads(text_of()) | {"signing_timestamp": 5, "parameters": {}}
    assert parse_calibrations(json.dumps(state).encode()).keys() == {"1/RAW_IMU"}


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"[]",
        b"{}",
        b"\xff\xfe",
        text_of(learned_unix_s=-1.0),
        text_of(learned_unix_s="now"),
        text_of(accel_bias={"mean": [0, 0], "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}),
        text_of(accel_bias={"mean": [0, 0, 1e9], "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}),
        text_of(hard_iron={"mean": [0, 0, 0], "covariance": [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]}),
        text_of(hard_iron={"mean": [0, 0, 0], "covariance": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}),
        text_of(hard_iron={"mean": [0, 0, 0], "covariance": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}),
        text_of().replace(b"RAW_IMU", b"../RAW"),
        text_of().replace(b"1/RAW_IMU", b"01/RAW_IMU"),
        b'{"x":' + b"[" * 100_000,
    ],
)
def test_a_file_that_makes_no_sense_is_refused(text):
    with pytest.raises(ValueError, match=r"."):
        parse_calibrations(text)
