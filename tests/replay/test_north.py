"""The declination, where it comes from, and headings that are compared or not for want of one."""

from math import radians

import pytest

from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window

ARDUPILOT, PX4 = 3, 12
REAL32 = 9


def flight(log, parameters, yaw_deg, autopilot=ARDUPILOT, imu="RAW_IMU"):
    """A vehicle that stands with its nose to magnetic north, and a truth that says so of another direction."""
    log.heartbeat(autopilot=autopilot)
    for name, value in parameters.items():
        values = {"param_id": name.encode(), "param_value": value, "param_type": REAL32, "param_count": 900}
        log.add("PARAM_VALUE", 0, values)
    for k in range(250):
        log.imu(1000 + 20 * k, imu)
        log.attitude(1000 + 20 * k, yaw_deg=yaw_deg)


def report(log, **options):
    request = Request((GradientDescent(),), window=Window(skip_s=1.0), **options)
    return as_json("log", replay(TlogSource(log.data, log.dialect), request, Outputs()))


TOLD = {
    "ardupilot": (ARDUPILOT, {"COMPASS_DEC": radians(-20.0), "COMPASS_AUTODEC": 1.0}, -20.0),
    "ardupilot, by hand": (ARDUPILOT, {"COMPASS_DEC": radians(12.5), "COMPASS_AUTODEC": 0.0}, 12.5),
    "ardupilot, none by hand": (ARDUPILOT, {"COMPASS_DEC": 0.0, "COMPASS_AUTODEC": 0.0}, 0.0),
    "px4": (PX4, {"EKF2_MAG_DECL": 7.0}, 7.0),
}


@pytest.mark.parametrize(("autopilot", "parameters", "declination_deg"), TOLD.values(), ids=TOLD)
def test_without_a_position_the_autopilots_declination_makes_headings_true(log, autopilot, parameters, declination_deg):
    flight(log, parameters, declination_deg, autopilot, "HIGHRES_IMU")
    result = report(log)
    assert result["north"]["reference"] == "true"
    assert result["north"]["declination_deg"] == pytest.approx(declination_deg, abs=1e-4)
    assert result["filters"][0]["heading_deg"]["max"] < 0.1
    assert any("gives the declination" in note for note in result["notes"])


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({}, "neither a position nor a parameter"),
        ({"COMPASS_DEC": 0.0}, "its COMPASS_DEC is 0: not looked up yet"),
        ({"COMPASS_DEC": 0.0, "COMPASS_AUTODEC": 1.0}, "its COMPASS_DEC is 0: not looked up yet"),
    ],
)
def test_a_magnetic_heading_is_never_compared_with_a_true_one(log, parameters, reason):
    flight(log, parameters, 20.0)
    result = report(log)
    assert result["filters"][0]["heading_deg"] is None
    assert result["filters"][0]["tilt_deg"]["max"] < 0.1
    assert any("headings are not compared" in note and reason in note for note in result["notes"])


def test_a_position_and_a_given_declination_come_before_the_autopilots(log):
    log.place()
    flight(log, {"COMPASS_DEC": radians(-20.0)}, 0.0)
    assert report(log)["north"]["declination_deg"] == pytest.approx(1.3, abs=0.2)
    assert report(log, declination_deg=5.0)["north"] == {
        "reference": "true",
        "declination_deg": 5.0,
        "source": "given",
    }
