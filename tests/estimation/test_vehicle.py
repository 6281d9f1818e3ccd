"""What is known of the vehicle, and what of it reaches a filter, on virtual time."""

from math import isnan, nan, pi, radians

import pytest

from attest_mav.algebra import q_from_euler
from attest_mav.estimation.lane_inputs import LaneInputs
from attest_mav.estimation.vehicle import AidSettings, Vehicle
from attest_mav.samples import AirDataSample, PositionSample, VelocitySample
from attest_mav.types import North, VehicleKind, VelocityOrigin
from attest_mav.vehicle_reports import HeartbeatSample, LandedSample

S = 1_000_000_000
EAST = q_from_euler(0.0, 0.0, pi / 2)
WING, COPTER, ROVER = VehicleKind.WING, VehicleKind.ROTARY, VehicleKind.SURFACE


def heartbeat(kind, armed=True):
    return HeartbeatSample("HEARTBEAT", 1, 1, 0, 0, 3, armed, 4, kind)


def hud(rx_s, airspeed=20.0, groundspeed=15.0, climb=0.0):
    return AirDataSample("VFR_HUD", 1, 1, round(rx_s * S), airspeed, groundspeed, climb)


def velocity(rx_s, v_ned, source="GPS_RAW_INT"):
    origin = VelocityOrigin.RECEIVER if source in ("GPS_RAW_INT", "GPS") else VelocityOrigin.ESTIMATOR
    return VelocitySample(source, 1, 1, round(rx_s * S), round(rx_s * S), v_ned, False, origin)


def vehicle(*samples, **settings):
    known = Vehicle(AidSettings(**settings))
    for sample in samples:
        known.take(sample)
    return known


def body_velocity(known, rx_s=1.0, q_nb=EAST, north=North.TRUE):
    moving = known.body_velocity(round(rx_s * S), q_nb, north)
    return None if moving is None else moving.velocity


@pytest.mark.parametrize(
    ("kind", "source", "speed"), [(WING, "airspeed", 20.0), (ROVER, "groundspeed", 15.0), (COPTER, "GPS_RAW_INT", 7.0)]
)
def test_auto_takes_the_speed_that_suits_the_vehicle(kind, source, speed):
    known = vehicle(heartbeat(kind), hud(1.0), velocity(1.0, (3.0, 7.0, 0.0)))
    assert known.speed_source == source
    assert body_velocity(known).forward == pytest.approx(speed)


@pytest.mark.parametrize("message", ["GPS_RAW_INT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"])
def test_a_named_message_is_resolved_along_the_nose(message):
    known = vehicle(heartbeat(WING), velocity(1.0, (3.0, 4.0, 1.0), message), forward_speed=message)
    pitched = q_from_euler(0.0, radians(30.0), 0.0)
    assert body_velocity(known, q_nb=pitched).forward == pytest.approx(3.0 * 0.8660254 - 1.0 * 0.5, abs=1e-6)
    assert body_velocity(known, q_nb=pitched, north=North.RELATIVE) is None


def test_none_means_none():
    known = vehicle(hud(1.0), velocity(1.0, (3.0, 4.0, 1.0)), forward_speed="none", velocity="none")
    assert body_velocity(known) is None
    assert known.velocity(S) is None


def test_the_receivers_velocity_counts_whatever_its_message_is_called():
    known = vehicle(velocity(1.0, (3.0, 4.0, 0.0), "GPS"), velocity(1.0, (9.0, 9.0, 0.0), "GLOBAL_POSITION_INT"))
    assert known.velocity(S).v_ned == (3.0, 4.0, 0.0)


def test_a_speed_is_new_once(imu):
    known = vehicle(heartbeat(WING), hud(1.0))
    inputs = LaneInputs(known)
    assert inputs.give(imu(1.0), EAST, North.TRUE).body_velocity.is_new
    later = inputs.give(imu(1.02), EAST, North.TRUE).body_velocity
    assert (later.is_new, later.forward) == (False, 20.0)
    known.take(hud(1.1))
    assert inputs.give(imu(1.12), EAST, North.TRUE).body_velocity.is_new


def test_a_speed_is_new_once_to_each_lane(imu):
    known = vehicle(heartbeat(WING), hud(1.0))
    lanes = [LaneInputs(known), LaneInputs(known)]
    assert [one.give(imu(1.0), EAST, North.TRUE).body_velocity.is_new for one in lanes] == [True, True]


def test_old_values_are_not_used(imu):
    known = vehicle(heartbeat(WING), hud(1.0), velocity(1.0, (3.0, 4.0, 0.0)))
    given = LaneInputs(known).give(imu(3.01), EAST, North.TRUE)
    assert (given.body_velocity, given.airspeed, given.velocity) == (None, None, None)


def test_the_latitude_comes_from_a_position():
    known = vehicle()
    assert isnan(known.latitude)
    known.take(PositionSample("GPS_RAW_INT", 1, 1, 0, 0, -35.36, 149.17, 584.0))
    assert known.latitude == pytest.approx(radians(-35.36))


def stands(inputs, imu, start_s, stop_s, **reading):
    """Run the lane over that time; whether it stands at the end."""
    for k in range(round((stop_s - start_s) * 50)):
        inputs.advance(imu(start_s + 0.02 * k, **reading), 0.02)
    return inputs.stationary


def test_a_disarmed_vehicle_with_quiet_sensors_stands_after_a_second(imu):
    inputs = LaneInputs(vehicle(heartbeat(COPTER, armed=False)))
    assert not stands(inputs, imu, 0.0, 0.9)
    assert stands(inputs, imu, 0.9, 1.1)
    assert stands(inputs, imu, 1.1, 1.2, rate=0.07), "hysteresis: below twice the limit it still stands"
    assert not stands(inputs, imu, 1.2, 1.22, rate=0.2)
    assert not stands(inputs, imu, 1.22, 2.0)


@pytest.mark.parametrize(("speed", "expected"), [(None, False), (0.1, True), (20.0, False)])
def test_an_armed_vehicle_stands_only_if_its_speed_says_so(imu, speed, expected):
    known = vehicle(heartbeat(WING))
    if speed is not None:
        known.take(velocity(0.0, (speed, 0.0, 0.0)))
    assert stands(LaneInputs(known), imu, 0.0, 2.0) is expected


@pytest.mark.parametrize("kind", [WING, ROVER])
def test_wings_and_wheels_have_no_motion_across_the_nose(kind):
    moving = body_velocity(vehicle(heartbeat(kind), hud(1.0)))
    assert (moving.side, moving.down, moving.lateral_known) == (0.0, 0.0, True)


def test_a_copter_with_only_a_speed_has_no_known_side_motion():
    moving = body_velocity(vehicle(heartbeat(COPTER), hud(1.0), forward_speed="groundspeed"))
    assert not moving.lateral_known


def test_a_velocity_is_resolved_in_all_body_axes_and_climb_fills_what_gps_lacks():
    known = vehicle(heartbeat(COPTER), hud(1.0, climb=2.0), velocity(1.0, (3.0, 7.0, 0.0)))
    moving = body_velocity(known)
    # Nose east: forward is east, right is south, and climbing is up.
    assert (moving.forward, moving.side, moving.down) == pytest.approx((7.0, -3.0, -2.0))


def test_a_climb_that_is_not_known_leaves_the_horizontal_velocity():
    known = vehicle(heartbeat(COPTER), hud(1.0, climb=nan), velocity(1.0, (3.0, 7.0, 0.0)))
    assert body_velocity(known).forward == pytest.approx(7.0)


def test_an_airspeed_that_is_not_known_is_none():
    known = vehicle(heartbeat(WING), hud(1.0, airspeed=nan))
    assert known.airspeed(S) is None
    assert body_velocity(known) is None


@pytest.mark.parametrize("choice", ["auto", "none", "groundspeed", "airspeed"])
def test_the_choice_of_a_forward_speed_leaves_the_flight_filters_airspeed_alone(imu, choice):
    known = vehicle(heartbeat(WING), hud(1.0, airspeed=20.0, groundspeed=15.0), forward_speed=choice)
    given = LaneInputs(known).give(imu(1.0), EAST, North.TRUE)
    assert given.airspeed.speed == 20.0
    assert given.goes_where_it_points


@pytest.mark.parametrize("kind", [ROVER, COPTER, VehicleKind.UNKNOWN])
def test_only_a_wing_goes_through_the_air_where_it_points(imu, kind):
    given = LaneInputs(vehicle(heartbeat(kind), hud(1.0))).give(imu(1.0), EAST, North.TRUE)
    assert not given.goes_where_it_points


def given_velocity(known, imu, **reading):
    """The velocity that a filter gets after two seconds of such readings."""
    inputs = LaneInputs(known)
    stands(inputs, imu, 0.0, 2.0, **reading)
    return inputs.give(imu(2.0, **reading), EAST, North.TRUE).velocity


@pytest.mark.parametrize(
    ("word", "speed", "rate", "is_given"),
    [
        ("disarmed", 3.0, 0.0, False),  # indoors
        ("disarmed", 0.2, 0.0, True),
        ("disarmed", 3.0, 0.5, True),  # the sensors say that it moves
        ("disarmed", 20.0, 0.0, True),  # in a car
        ("armed", 3.0, 0.0, True),
        ("armed, landed", 3.0, 0.0, False),
    ],
)
def test_a_receiver_that_moves_is_not_believed_of_a_vehicle_that_stands(imu, word, speed, rate, is_given):
    known = vehicle(heartbeat(COPTER, armed=word != "disarmed"), velocity(1.9, (speed, 0.0, 0.0)))
    if word.endswith("landed"):
        known.take(LandedSample("EXTENDED_SYS_STATE", 1, 1, S, on_ground=True))
    assert (given_velocity(known, imu, rate=rate) is not None) is is_given
