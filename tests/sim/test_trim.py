"""ArduPilot's trim in the messages of the fake autopilot, each in its own form, made with scipy of the truth."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from scipy.spatial.transform import Rotation

from attest_mav.mavlink.dialect import load_dialect
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.settings import SimSettings

S = 1_000_000_000
TRIM = (0.10, -0.12, 0.05)
ASKED = (mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION, mavlink.MAVLINK_MSG_ID_AHRS2)


def vehicle_with(companion, **settings):
    """A tumbling vehicle that sends ATTITUDE_QUATERNION and AHRS2 too, five times a second."""
    chosen = {"scenario": "tumbling", "fast_rate_hz": 5.0, "attitude_error": (0.0, 0.0, 0.0)} | settings
    vehicle = FakeAutopilot(SimSettings(**chosen), 1, load_dialect())
    for message in ASKED:
        interval = (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0, message, 200_000, 0, 0, 0, 0, 0)
        vehicle.handle(mavlink.MAVLink_command_long_message(1, 1, *interval).pack(companion), 0)
    return vehicle


def truth_of(vehicle, t_ms):
    w, x, y, z = vehicle.truth(t_ms * 1_000_000).q_nb
    return Rotation.from_quat((x, y, z, w))


def angles(rotation):
    return tuple(rotation.as_euler("ZYX")[::-1])


def test_each_attitude_has_its_own_form(decode, companion):
    vehicle = vehicle_with(companion, trim=TRIM)
    messages = decode(vehicle.frames_until(20 * S))
    assert len(messages["ATTITUDE"]) == len(messages["AHRS2"]) == len(messages["ATTITUDE_QUATERNION"]) == 100
    for euler, matrix, vector in zip(
        messages["ATTITUDE"], messages["AHRS2"], messages["ATTITUDE_QUATERNION"], strict=True
    ):
        truth = truth_of(vehicle, euler.time_boot_ms)
        expected = [a - t for a, t in zip(angles(truth), TRIM, strict=True)]
        assert (euler.roll, euler.pitch, euler.yaw) == pytest.approx(expected, abs=1e-6)
        turned = truth * Rotation.from_euler("ZYX", TRIM[::-1]).inv()
        assert (matrix.roll, matrix.pitch, matrix.yaw) == pytest.approx(angles(turned), abs=1e-5)
        sent = Rotation.from_quat((vector.q2, vector.q3, vector.q4, vector.q1))
        assert (sent.inv() * truth * Rotation.from_rotvec(TRIM).inv()).magnitude() < 1e-6


@pytest.mark.parametrize("personality", ["ardupilot", "px4"])
def test_readings_rates_and_truth_are_without_it(decode, companion, personality):
    plain, trimmed = (
        decode(vehicle_with(companion, personality=personality, trim=trim).frames_until(10 * S))
        for trim in ((0.0, 0.0, 0.0), TRIM)
    )
    for name in plain:
        if name in {"ATTITUDE", "ATTITUDE_QUATERNION", "AHRS2"} and personality == "ardupilot":
            continue
        assert [m.get_payload() for m in plain[name]] == [m.get_payload() for m in trimmed[name]], name
    assert [m.rollspeed for m in plain["ATTITUDE"]] == [m.rollspeed for m in trimmed["ATTITUDE"]]
    assert {"SIM_STATE", "ATTITUDE"} < plain.keys()


def say(vehicle, companion, message, now_s, decode):
    vehicle.handle(message.pack(companion), now_s * S)
    return decode(vehicle.frames_until((now_s + 1) * S))


def test_the_trim_is_read_set_and_announced(decode, companion):
    vehicle = vehicle_with(companion, scenario="still", trim=TRIM)
    vehicle.frames_until(S)
    read = mavlink.MAVLink_param_request_read_message(1, 1, b"AHRS_TRIM_Y", -1)
    (told,) = say(vehicle, companion, read, 1, decode)["PARAM_VALUE"]
    assert (told.param_id, told.param_type) == ("AHRS_TRIM_Y", mavlink.MAV_PARAM_TYPE_REAL32)
    assert told.param_value == pytest.approx(-0.12)
    change = mavlink.MAVLink_param_set_message(1, 1, b"AHRS_TRIM_X", 0.5, mavlink.MAV_PARAM_TYPE_REAL32)
    messages = say(vehicle, companion, change, 2, decode)
    (told,) = messages["PARAM_VALUE"]
    assert (told.param_id, told.param_value, told.param_index) == ("AHRS_TRIM_X", 0.5, 65535)
    (roll, _, _), attitude = angles(truth_of(vehicle, 0)), messages["ATTITUDE"][-1]
    assert attitude.roll == pytest.approx(roll - 0.5, abs=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        mavlink.MAVLink_param_set_message(2, 1, b"AHRS_TRIM_X", 0.5, 9),
        mavlink.MAVLink_param_set_message(1, 1, b"AHRS_TRIM_X", float("nan"), 9),
        mavlink.MAVLink_param_set_message(1, 1, b"NO_SUCH", 0.5, 9),
    ],
)
def test_other_settings_change_nothing(decode, companion, change):
    vehicle = vehicle_with(companion, scenario="still", trim=TRIM)
    vehicle.frames_until(S)
    assert "PARAM_VALUE" not in say(vehicle, companion, change, 1, decode)
    assert vehicle.messages.parameters.trim == TRIM


@pytest.mark.parametrize(("personality", "version"), [("ardupilot", (4, 6, 0)), ("px4", (1, 15, 0))])
def test_the_version_is_told_on_request(decode, companion, personality, version):
    vehicle = vehicle_with(companion, scenario="still", personality=personality)
    vehicle.frames_until(S)
    command = (mavlink.MAV_CMD_REQUEST_MESSAGE, 0, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, 0, 0, 0, 0, 0, 0)
    messages = say(vehicle, companion, mavlink.MAVLink_command_long_message(1, 1, *command), 1, decode)
    (told,) = messages["AUTOPILOT_VERSION"]
    assert told.flight_sw_version.to_bytes(4, "big")[:3] == bytes(version)
    assert messages["COMMAND_ACK"][-1].result == mavlink.MAV_RESULT_ACCEPTED
