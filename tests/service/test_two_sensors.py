"""Two inertial sensors in the whole service: a faulty one is named, and no sensor that stops is a trap."""

from itertools import pairwise

import pytest

from attest_mav.estimation.events import Agreement
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

RAW_IMU, SCALED_IMU2 = 27, 116


def sim(*faults, **settings):
    return SimSettings(scenario="square", faults=parse_faults(faults), **settings)


def sensors(flight):
    """The status line's part about the sensors."""
    (part,) = [part for part in flight.status().split(" | ") if part.startswith(("sensors ", "one sensor"))]
    return part


def test_a_faulty_sensor_is_named_with_axis_and_size_while_the_other_is_published(flight):
    f = flight("", sim("gyro1-bias-x=5@20+15"))
    f.run_until(24.0)
    assert sensors(f).startswith("sensors RAW_IMU set aside (gyro x +")
    assert sensors(f).endswith("), SCALED_IMU2")
    assert f.snapshot().published_lane.source == "SCALED_IMU2"
    assert f.of_type("ATTITUDE_QUATERNION", 23.5)
    tilt, heading = f.errors_deg(20.0)
    assert tilt < 1.0
    assert heading < 4.0


def test_a_sensor_that_is_well_again_is_taken_back(flight):
    f = flight("", sim("gyro1-bias-x=5@20+5"))
    f.run_until(24.0)
    assert "RAW_IMU set aside" in sensors(f)
    f.run_until(40.0)
    assert sensors(f) == "sensors RAW_IMU, SCALED_IMU2"


@pytest.mark.parametrize(("silent", "left"), [("imu1-silent", "SCALED_IMU2"), ("imu2-silent", "RAW_IMU")])
def test_while_one_sensor_is_silent_the_other_is_published_without_an_alignment(flight, silent, left):
    f = flight("", sim(f"{silent}@20+30"))
    f.run_until(49.0)
    assert f.snapshot().published_lane.source == left
    sent = [t_s for t_s, one in f.heard if one.get_type() == "ATTITUDE_QUATERNION" and t_s > 19.0]
    assert max(after - before for before, after in pairwise(sent)) < 0.5
    assert f.snapshot().verdict.verdict.agreement == Agreement.AGREE


def test_a_sensor_that_was_set_aside_serves_again_when_the_other_stops(flight):
    """The first is faulty for 5 s; before it is trusted again, the second falls silent for good."""
    f = flight("", sim("gyro1-bias-x=5@20+5", "imu2-silent@26"))
    f.run_until(25.9)
    assert "RAW_IMU set aside" in sensors(f)
    f.run_until(60.0)
    assert f.snapshot().published_lane.source == "RAW_IMU"
    assert f.of_type("ATTITUDE_QUATERNION", 59.5)
    tilt, _ = f.errors_deg(50.0)
    assert tilt < 2.0


def test_a_vehicle_with_one_sensor_is_served_and_the_status_says_why_there_is_one(flight):
    f = flight("", sim())
    f.deaf_to.add(SCALED_IMU2)
    f.run_until(20.0)
    assert sensors(f) == "one sensor: no SCALED_IMU2 or SCALED_IMU3 comes with readings"
    assert f.of_type("ATTITUDE_QUATERNION", 19.5)
