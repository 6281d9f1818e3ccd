"""ODOMETRY: the attitude alone, in the form that each autopilot takes, and never a number that nobody measured."""

from math import isnan, radians, sqrt

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.estimate import Estimate
from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.outputs import Confidence
from attest_mav.types import North

SECOND = 1_000_000_000
ODOMETRY = PortSettings(("odometry",))
ARDUPILOT, PX4, GENERIC = 3, 12, 0
HALF = sqrt(0.5)
TILT, HEADING = radians(0.5), radians(2.0)


def estimate(t_s=100.0, north=North.TRUE, lane="RAW_IMU", tilt=TILT, heading=HEADING):
    rx_ns, delay_s = 7_000_500_000, 0.25
    return Estimate(
        lane,
        "any",
        round(t_s * SECOND),
        rx_ns,
        (HALF, 0.0, 0.0, HALF),
        (0.1, 0.2, 0.3),
        north,
        tilt,
        heading,
        0.02,
        delay_s,
    )


@pytest.fixture
def flown(bench):
    """A bench with a vehicle of this autopilot."""

    def make(autopilot, links=None):
        b = bench(links=links or [ODOMETRY])
        b.vehicle_heartbeat(autopilot=autopilot)
        return b

    return make


@pytest.mark.parametrize(
    ("autopilot", "north", "frame", "time_usec"),
    [
        (ARDUPILOT, North.TRUE, mavlink.MAV_FRAME_LOCAL_FRD, 100_000_000),
        (PX4, North.TRUE, mavlink.MAV_FRAME_LOCAL_NED, 6_750_500),
        (PX4, North.MAGNETIC, mavlink.MAV_FRAME_LOCAL_FRD, 6_750_500),
        (PX4, North.RELATIVE, mavlink.MAV_FRAME_LOCAL_FRD, 6_750_500),
    ],
)
def test_it_has_the_form_of_the_autopilot(flown, autopilot, north, frame, time_usec):
    b = flown(autopilot)
    b.publish(estimate(north=north))
    (one,) = b.of_type("ODOMETRY")
    assert (one.frame_id, one.child_frame_id) == (frame, mavlink.MAV_FRAME_BODY_FRD)
    assert one.time_usec == time_usec
    assert list(one.q) == pytest.approx([HALF, 0.0, 0.0, HALF])
    assert [one.rollspeed, one.pitchspeed, one.yawspeed] == pytest.approx([0.1, 0.2, 0.3])
    assert one.estimator_type == mavlink.MAV_ESTIMATOR_TYPE_UNKNOWN


def test_what_is_not_measured_is_unknown_and_never_zero(flown):
    b = flown(ARDUPILOT)
    b.publish(estimate())
    (one,) = b.of_type("ODOMETRY")
    assert all(isnan(value) for value in (one.x, one.y, one.z, one.vx, one.vy, one.vz))
    assert all(isnan(value) for value in one.velocity_covariance)
    known = {place: value for place, value in enumerate(one.pose_covariance) if not isnan(value)}
    assert known == pytest.approx({15: TILT**2, 18: TILT**2, 20: HEADING**2})
    assert one.quality == 0, "unknown"


def test_a_filter_without_sigma_has_no_covariance(flown):
    b = flown(PX4)
    b.publish(estimate(tilt=float("nan"), heading=float("nan")))
    assert all(isnan(value) for value in b.of_type("ODOMETRY")[0].pose_covariance)


@pytest.mark.parametrize(
    ("autopilot", "north"),
    [(ARDUPILOT, North.MAGNETIC), (ARDUPILOT, North.RELATIVE), (GENERIC, North.TRUE)],
)
def test_without_a_form_nothing_is_sent_and_a_request_is_put_off(flown, autopilot, north):
    b = flown(autopilot)
    b.publish(estimate(north=north))
    b.hear(mavlink.MAVLink_command_long_message(1, 193, 512, 0, 331, 0, 0, 0, 0, 0, 0), 255, 190)
    assert b.of_type("ODOMETRY") == []
    assert [one.result for one in b.of_type("COMMAND_ACK")] == [mavlink.MAV_RESULT_TEMPORARILY_REJECTED]


@pytest.mark.parametrize("confidence", [Confidence.DOUBTED, Confidence.UNCERTAIN])
def test_it_is_sent_only_while_the_attitude_is_believed(flown, confidence):
    b = flown(ARDUPILOT)
    b.companion.publish(estimate(), confidence)
    b.run_until(1.0)
    assert b.of_type("ODOMETRY") == []


def test_no_command_can_turn_it_on(flown):
    b = flown(ARDUPILOT, [PortSettings()])
    for command, parameter in ((512, 0), (511, 100_000)):
        b.hear(mavlink.MAVLink_command_long_message(1, 193, command, 0, 331, parameter, 0, 0, 0, 0, 0), 255, 190)
    b.publish(estimate())
    assert b.of_type("ODOMETRY") == []
    assert {one.result for one in b.of_type("COMMAND_ACK")} == {mavlink.MAV_RESULT_UNSUPPORTED}


def test_it_is_held_back_beside_another_onboard_computer_and_nothing_replaces_it(flown):
    b = flown(ARDUPILOT)
    b.hear(mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), 1, 191)
    b.publish(estimate())
    assert b.of_type("ODOMETRY") == b.of_type("ATTITUDE_QUATERNION_COV") == []


def test_each_new_beginning_of_the_attitude_is_counted(flown):
    b = flown(ARDUPILOT)
    b.publish(estimate(100.0))
    b.publish(estimate(101.0))
    b.publish(estimate(102.0, lane="SCALED_IMU2"))
    b.companion.publish(estimate(103.0, lane="SCALED_IMU2"), Confidence.UNCERTAIN)
    b.publish(estimate(104.0, lane="SCALED_IMU2"))
    b.companion.withdraw()
    b.publish(estimate(105.0, lane="SCALED_IMU2"))
    first, *counts = [one.reset_counter for one in b.of_type("ODOMETRY")]
    assert [count - first for count in counts] == [0, 1, 2, 3]
