"""What reaches the filters besides inertial samples, shown through a lane's aiding on virtual time."""

from math import isnan, pi, radians

import pytest

from attest_mav.algebra import q_from_euler
from attest_mav.estimation.vehicle import Aiding, AidSettings
from attest_mav.types import AirDataSample, HeartbeatSample, North, PositionSample, VelocitySample

S = 1_000_000_000
PLANE, COPTER, ROVER = 1, 2, 10
EAST = q_from_euler(0.0, 0.0, pi / 2)


def heartbeat(vehicle_type, armed=True):
    return HeartbeatSample("HEARTBEAT", 1, 1, 0, vehicle_type, 3, armed, 4)


def hud(rx_s, airspeed=20.0, groundspeed=15.0):
    return AirDataSample("VFR_HUD", 1, 1, round(rx_s * S), airspeed, groundspeed, 0.0)


def velocity(rx_s, v_ned, source="GPS_RAW_INT"):
    return VelocitySample(source, 1, 1, round(rx_s * S), round(rx_s * S), v_ned, vertical_known=False)


@pytest.mark.parametrize(
    ("vehicle_type", "source", "speed"),
    [(PLANE, "airspeed", 20.0), (ROVER, "groundspeed", 15.0), (COPTER, "GPS_RAW_INT", 7.0)],
)
def test_auto_takes_the_speed_that_suits_the_vehicle(imu, vehicle_type, source, speed):
    aiding = Aiding(AidSettings())
    for sample in (heartbeat(vehicle_type), hud(1.0), velocity(1.0, (3.0, 7.0, 0.0))):
        aiding.take(sample)
    aids = aiding.aids(imu(1.0), EAST, North.TRUE)
    assert aiding.speed_source == source
    assert aids.forward_speed == pytest.approx(speed)


@pytest.mark.parametrize("message", ["GPS_RAW_INT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"])
def test_a_named_message_is_resolved_along_the_nose(imu, message):
    aiding = Aiding(AidSettings(forward_speed=message))
    aiding.take(heartbeat(PLANE))
    aiding.take(velocity(1.0, (3.0, 4.0, 1.0), message))
    pitched = q_from_euler(0.0, radians(30.0), 0.0)
    assert aiding.aids(imu(1.0), pitched, North.TRUE).forward_speed == pytest.approx(
        3.0 * 0.8660254 - 1.0 * 0.5, abs=1e-6
    )
    assert isnan(aiding.aids(imu(1.0), pitched, North.RELATIVE).forward_speed)


def test_none_means_none(imu):
    aiding = Aiding(AidSettings(forward_speed="none", velocity="none"))
    aiding.take(hud(1.0))
    aiding.take(velocity(1.0, (3.0, 4.0, 1.0)))
    aids = aiding.aids(imu(1.0), EAST, North.TRUE)
    assert isnan(aids.forward_speed)
    assert not aids.forward_speed_fresh
    assert aids.velocity is None


def test_a_value_is_fresh_once_for_all_filters_of_the_lane(imu):
    aiding = Aiding(AidSettings())
    aiding.take(heartbeat(PLANE))
    aiding.take(hud(1.0))
    aiding.take(velocity(1.0, (3.0, 4.0, 0.0)))
    first, second = (aiding.aids(imu(1.0), EAST, North.TRUE) for _ in range(2))
    for aids in (first, second):
        assert (aids.forward_speed_fresh, aids.velocity_fresh, aids.airspeed_fresh) == (True, True, True)
    aiding.given()
    later = aiding.aids(imu(1.02), EAST, North.TRUE)
    assert (later.forward_speed_fresh, later.velocity_fresh, later.airspeed_fresh) == (False, False, False)
    assert later.forward_speed == pytest.approx(20.0)
    aiding.take(hud(1.1))
    assert aiding.aids(imu(1.12), EAST, North.TRUE).forward_speed_fresh


def test_old_values_are_not_used(imu):
    aiding = Aiding(AidSettings())
    aiding.take(heartbeat(PLANE))
    aiding.take(hud(1.0))
    aiding.take(velocity(1.0, (3.0, 4.0, 0.0)))
    aids = aiding.aids(imu(3.01), EAST, North.TRUE)
    assert isnan(aids.forward_speed)
    assert isnan(aids.airspeed)
    assert aids.velocity is None


def test_the_latitude_comes_from_a_position(imu):
    aiding = Aiding(AidSettings())
    assert isnan(aiding.aids(imu(0.0), EAST, North.TRUE).latitude)
    aiding.take(PositionSample("GPS_RAW_INT", 1, 1, 0, 0, -35.36, 149.17, 584.0))
    assert aiding.aids(imu(0.0), EAST, North.TRUE).latitude == pytest.approx(radians(-35.36))


def stands(aiding, imu, start_s, stop_s, **reading):
    """Run the lane over that time; whether it stands at the end."""
    for k in range(round((stop_s - start_s) * 50)):
        aiding.advance(imu(start_s + 0.02 * k, **reading), 0.02)
    return aiding.aids(imu(stop_s), EAST, North.TRUE).stationary


def test_a_disarmed_vehicle_with_quiet_sensors_stands_after_a_second(imu):
    aiding = Aiding(AidSettings())
    aiding.take(heartbeat(COPTER, armed=False))
    assert not stands(aiding, imu, 0.0, 0.9)
    assert stands(aiding, imu, 0.9, 1.1)
    assert stands(aiding, imu, 1.1, 1.2, rate=0.07), "hysteresis: below twice the limit it still stands"
    assert not stands(aiding, imu, 1.2, 1.22, rate=0.2)
    assert not stands(aiding, imu, 1.22, 2.0)


@pytest.mark.parametrize(("speed", "expected"), [(None, False), (0.1, True), (20.0, False)])
def test_an_armed_vehicle_stands_only_if_its_speed_says_so(imu, speed, expected):
    aiding = Aiding(AidSettings())
    aiding.take(heartbeat(PLANE))
    if speed is not None:
        aiding.take(velocity(0.0, (speed, 0.0, 0.0)))
    assert stands(aiding, imu, 0.0, 2.0) is expected


def test_wings_and_wheels_go_where_they_point(imu):
    for vehicle_type in (PLANE, ROVER):
        aiding = Aiding(AidSettings())
        aiding.take(heartbeat(vehicle_type))
        aiding.take(hud(1.0))
        aids = aiding.aids(imu(1.0), EAST, North.TRUE)
        assert (aids.side_speed, aids.down_speed) == (0.0, 0.0)


def test_a_copter_with_only_a_speed_has_no_known_side_motion(imu):
    aiding = Aiding(AidSettings(forward_speed="groundspeed"))
    aiding.take(heartbeat(COPTER))
    aiding.take(hud(1.0))
    aids = aiding.aids(imu(1.0), EAST, North.TRUE)
    assert isnan(aids.side_speed)
    assert isnan(aids.down_speed)


def test_a_velocity_is_resolved_in_all_body_axes_and_climb_fills_what_gps_lacks(imu):
    aiding = Aiding(AidSettings())
    aiding.take(heartbeat(COPTER))
    aiding.take(AirDataSample("VFR_HUD", 1, 1, S, 0.0, 5.0, 2.0))
    aiding.take(velocity(1.0, (3.0, 7.0, 0.0)))
    aids = aiding.aids(imu(1.0), EAST, North.TRUE)
    # Nose east: forward is east, right is south, and climbing is up.
    assert (aids.forward_speed, aids.side_speed, aids.down_speed) == pytest.approx((7.0, -3.0, -2.0))


def test_an_airspeed_that_is_not_known_is_never_fresh(imu):
    aiding = Aiding(AidSettings())
    aiding.take(heartbeat(PLANE))
    aiding.take(hud(1.0, airspeed=float("nan")))
    aids = aiding.aids(imu(1.0), EAST, North.TRUE)
    assert (aids.forward_speed_fresh, aids.airspeed_fresh) == (False, False)


def test_a_climb_that_is_not_known_leaves_the_horizontal_velocity(imu):
    aiding = Aiding(AidSettings())
    aiding.take(heartbeat(COPTER))
    aiding.take(AirDataSample("VFR_HUD", 1, 1, S, 0.0, 5.0, float("nan")))
    aiding.take(velocity(1.0, (3.0, 7.0, 0.0)))
    assert aiding.aids(imu(1.0), EAST, North.TRUE).forward_speed == pytest.approx(7.0)
