"""Rates and answers, against what ArduPilot and PX4 do."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.personality import ARDUPILOT, PX4
from attest_mav.sim.settings import SimSettings
from attest_mav.sim.streams import Streams

S = 1_000_000_000
RAW_IMU, HIGHRES_IMU = mavlink.MAVLINK_MSG_ID_RAW_IMU, mavlink.MAVLINK_MSG_ID_HIGHRES_IMU
QUATERNION = mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION


class Bench:
    """A still vehicle, commanded at 1 s and listened to for ``seconds`` after."""

    def __init__(self, decode, companion, **settings):
        self.decode = decode
        self.companion = companion
        self.vehicle = FakeAutopilot(SimSettings(**({"scenario": "still"} | settings)), seed=1)
        self.now = S
        self.vehicle.frames_until(S)

    def say(self, message, seconds=2.0):
        """Messages that come within so many seconds of saying something."""
        self.vehicle.handle(message.pack(self.companion), self.now)
        self.now += round(seconds * S)
        return self.decode(self.vehicle.frames_until(self.now))

    def command(self, command, param1=0.0, param2=0.0, system=1, component=1, seconds=2.0):
        """The same for a COMMAND_LONG."""
        message = mavlink.MAVLink_command_long_message(system, component, command, 0, param1, param2, 0, 0, 0, 0, 0)
        return self.say(message, seconds)

    def set_interval(self, message_id, interval_us, seconds=2.0):
        """The same for SET_MESSAGE_INTERVAL."""
        return self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, interval_us, seconds=seconds)


@pytest.fixture
def bench(decode, companion):
    return lambda **settings: Bench(decode, companion, **settings)


def result(messages):
    """The one acknowledgement's result."""
    (ack,) = messages["COMMAND_ACK"]
    return ack.result


def test_each_personality_is_its_firmwares():
    assert ARDUPILOT.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    assert PX4.autopilot == mavlink.MAV_AUTOPILOT_PX4


def test_ardupilot_streams_at_4_hz_and_no_quaternion(decode):
    messages = decode(FakeAutopilot(SimSettings(), 1).frames_until(10 * S))
    counts = {name: len(found) for name, found in messages.items()}
    assert counts.pop("HEARTBEAT") == 11
    assert set(counts.values()) == {40}
    assert {"RAW_IMU", "SCALED_IMU2", "SCALED_IMU3", "ATTITUDE", "SIM_STATE"} <= set(counts)
    assert not {"ATTITUDE_QUATERNION", "HIGHRES_IMU", "SCALED_IMU"} & set(counts)


def test_px4_streams_its_onboard_rates(decode):
    messages = decode(FakeAutopilot(SimSettings(personality="px4"), 1).frames_until(10 * S))
    for name in ("HIGHRES_IMU", "SCALED_IMU", "ATTITUDE", "ATTITUDE_QUATERNION", "SIM_STATE"):
        assert len(messages[name]) == 500
    assert "RAW_IMU" not in messages


def test_the_fast_rate_is_for_imu_attitude_and_truth_only(decode):
    messages = decode(FakeAutopilot(SimSettings(fast_rate_hz=100.0), 1).frames_until(10 * S))
    for name in ("RAW_IMU", "SCALED_IMU2", "ATTITUDE", "SIM_STATE"):
        assert len(messages[name]) == 1000
    assert len(messages["GPS_RAW_INT"]) == 40


@pytest.mark.parametrize(
    ("loop_hz", "asked_us", "achieved_hz"),
    [
        (400, 20_000, 50.0),
        (400, 2_500, 1000 / 3),  # 80 % of 400 Hz in whole milliseconds
        (400, 100, 1000 / 3),
        (400, 3_999, 1000 / 3),
        (50, 20_000, 40.0),  # a plane never sends more than 40 Hz
        (50, 33_333, 1000 / 33),
        (300, 1_000, 250.0),
        (1000, 1_000, 1000.0),
    ],
)
def test_ardupilot_honours_an_interval_up_to_its_ceiling(bench, loop_hz, asked_us, achieved_hz):
    messages = bench(loop_rate_hz=loop_hz).set_interval(RAW_IMU, asked_us, seconds=4.0)
    assert result(messages) == mavlink.MAV_RESULT_ACCEPTED
    assert len(messages["RAW_IMU"]) / 4.0 == pytest.approx(achieved_hz, rel=0.01)


def test_the_plane_has_a_slow_loop_unless_it_is_asked_for_more(bench, decode):
    messages = bench(scenario="coordinated-turns").set_interval(RAW_IMU, 5_000, seconds=5.0)
    assert len(messages["RAW_IMU"]) == pytest.approx(200, abs=1)
    faster = FakeAutopilot(SimSettings(scenario="coordinated-turns", fast_rate_hz=50.0), 1)
    assert str(faster) == "ardupilot vehicle, scenario coordinated-turns, RAW_IMU at 50 Hz"
    times = [m.time_usec for m in decode(faster.frames_until(3 * S))["RAW_IMU"]]
    assert times == [20_000 * (k + 1) for k in range(150)]


def test_messages_are_sent_on_the_loop(bench):
    messages = bench(loop_rate_hz=400).set_interval(RAW_IMU, 3_000)
    assert {m.time_usec % 2_500 for m in messages["RAW_IMU"]} == {0}


def test_px4_sends_at_any_interval_up_to_its_loop(bench):
    messages = bench(personality="px4").set_interval(HIGHRES_IMU, 7_777, seconds=4.0)
    assert len(messages["HIGHRES_IMU"]) / 4.0 == pytest.approx(1000 / 7.777, rel=0.01)
    messages = bench(personality="px4").set_interval(HIGHRES_IMU, 10, seconds=4.0)
    assert len(messages["HIGHRES_IMU"]) / 4.0 == pytest.approx(250.0, rel=0.01)


def test_the_quaternion_comes_on_request_stops_and_has_no_default(bench):
    table = bench()
    assert "ATTITUDE_QUATERNION" not in table.command(mavlink.MAV_CMD_DO_SET_MODE)
    assert len(table.set_interval(QUATERNION, 20_000)["ATTITUDE_QUATERNION"]) == 100
    assert result(table.set_interval(QUATERNION, 0)) == mavlink.MAV_RESULT_FAILED
    messages = table.set_interval(QUATERNION, -1)
    assert result(messages) == mavlink.MAV_RESULT_ACCEPTED
    assert "ATTITUDE_QUATERNION" not in messages


def test_zero_asks_for_the_default_rate_again(bench):
    table = bench()
    assert len(table.set_interval(RAW_IMU, 10_000)["RAW_IMU"]) == 200
    assert len(table.set_interval(RAW_IMU, 0)["RAW_IMU"]) == 8


@pytest.mark.parametrize(
    ("name", "message_id", "expected"),
    [
        ("ardupilot", HIGHRES_IMU, mavlink.MAV_RESULT_DENIED),
        ("ardupilot", 50_000, mavlink.MAV_RESULT_DENIED),
        ("ardupilot", -5, mavlink.MAV_RESULT_DENIED),
        ("ardupilot", float("nan"), mavlink.MAV_RESULT_DENIED),
        ("px4", RAW_IMU, mavlink.MAV_RESULT_FAILED),
    ],
)
def test_messages_it_does_not_have_are_refused(bench, name, message_id, expected):
    assert result(bench(personality=name).set_interval(message_id, 20_000)) == expected


@pytest.mark.parametrize("name", ["ardupilot", "px4"])
def test_an_interval_of_ages_is_taken_as_it_is_meant(bench, name):
    message_id = mavlink.MAVLINK_MSG_ID_SCALED_IMU
    messages = bench(personality=name).set_interval(message_id, 1e30)
    assert result(messages) == mavlink.MAV_RESULT_ACCEPTED
    assert "SCALED_IMU" not in messages


@pytest.mark.parametrize("interval", [float("nan"), float("inf")])
def test_an_interval_that_is_no_number_is_denied(bench, interval):
    assert result(bench().set_interval(RAW_IMU, interval)) == mavlink.MAV_RESULT_DENIED


def test_one_message_can_be_requested(bench):
    messages = bench().command(mavlink.MAV_CMD_REQUEST_MESSAGE, QUATERNION)
    assert result(messages) == mavlink.MAV_RESULT_ACCEPTED
    assert len(messages["ATTITUDE_QUATERNION"]) == 1
    refused = bench().command(mavlink.MAV_CMD_REQUEST_MESSAGE, HIGHRES_IMU)
    assert result(refused) == mavlink.MAV_RESULT_FAILED


def test_other_commands_are_unsupported_and_the_ack_names_who_asked(bench):
    (ack,) = bench().command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)["COMMAND_ACK"]
    assert ack.result == mavlink.MAV_RESULT_UNSUPPORTED
    assert (ack.command, ack.target_system, ack.target_component) == (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1, 193)


@pytest.mark.parametrize(
    ("system", "component", "answered"), [(1, 1, True), (0, 0, True), (1, 0, True), (2, 1, False), (1, 193, False)]
)
def test_only_what_is_addressed_to_it_is_answered(bench, system, component, answered):
    messages = bench().command(511, RAW_IMU, 20_000, system=system, component=component)
    assert ("COMMAND_ACK" in messages) == answered


def test_what_claims_to_come_from_the_autopilot_itself_is_dropped(decode):
    impostor = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    assert "COMMAND_ACK" not in Bench(decode, impostor).set_interval(RAW_IMU, 20_000)


def stream_request(group, rate_hz, start=1):
    return mavlink.MAVLink_request_data_stream_message(1, 1, group, rate_hz, start)


def test_request_data_stream_sets_a_group_and_is_not_acknowledged(bench):
    messages = bench().say(stream_request(mavlink.MAV_DATA_STREAM_RAW_SENSORS, 50))
    assert "COMMAND_ACK" not in messages
    for name in ("RAW_IMU", "SCALED_IMU2", "SCALED_IMU3"):
        assert len(messages[name]) == 100
    assert len(messages["ATTITUDE"]) == 8


def test_request_data_stream_can_stop_a_group_and_set_all(bench):
    table = bench()
    assert "RAW_IMU" not in table.say(stream_request(mavlink.MAV_DATA_STREAM_RAW_SENSORS, 50, start=0))
    messages = table.say(stream_request(mavlink.MAV_DATA_STREAM_ALL, 10))
    assert len(messages["RAW_IMU"]) == len(messages["VFR_HUD"]) == 20
    assert len(messages["HEARTBEAT"]) == 2  # in no group
    assert "ATTITUDE_QUATERNION" not in messages


def test_px4_ignores_request_data_stream(bench):
    messages = bench(personality="px4").say(stream_request(mavlink.MAV_DATA_STREAM_ALL, 5))
    assert len(messages["HIGHRES_IMU"]) == 100


def read_parameter(name=b"", index=-1, system=1, component=1):
    return mavlink.MAVLink_param_request_read_message(system, component, name, index)


@pytest.mark.parametrize(
    ("firmware", "name", "value", "kind"),
    [
        ("ardupilot", b"INS_GYRO_FILTER", 20.0, mavlink.MAV_PARAM_TYPE_INT16),
        ("ardupilot", b"GPS1_DELAY_MS", 100.0, mavlink.MAV_PARAM_TYPE_INT16),
        ("px4", b"EKF2_GPS_DELAY", 100.0, mavlink.MAV_PARAM_TYPE_REAL32),
    ],
)
def test_parameters_that_are_true_of_the_sensors_can_be_read(bench, firmware, name, value, kind):
    (told,) = bench(personality=firmware).say(read_parameter(name))["PARAM_VALUE"]
    assert (told.param_id, told.param_value, told.param_type) == (name.decode(), value, kind)
    (again,) = bench(personality=firmware).say(read_parameter(index=told.param_index))["PARAM_VALUE"]
    assert again.param_id == told.param_id
    assert told.param_index < told.param_count


@pytest.mark.parametrize(
    "request_",
    [
        read_parameter(b"GPS_DELAY_MS"),
        read_parameter(b"INS_GYRO_FILTERS"),
        read_parameter(b"\xff" * 16),
        read_parameter(),
        read_parameter(index=100),
        read_parameter(b"INS_GYRO_FILTER", system=2),
        read_parameter(b"INS_GYRO_FILTER", component=100),
    ],
)
def test_other_parameters_and_other_targets_are_not_answered(bench, request_):
    assert "PARAM_VALUE" not in bench().say(request_)


def test_timesync_is_answered_with_the_time_of_arrival_and_without_a_target(bench):
    table = bench()
    table.now += 123_456
    arrived = table.now
    messages = table.say(mavlink.MAVLink_timesync_message(0, 987_654_321))
    (answer,) = messages["TIMESYNC"]
    assert (answer.tc1, answer.ts1) == (arrived, 987_654_321)
    assert "TIMESYNC" not in table.say(mavlink.MAVLink_timesync_message(5, 6))  # an answer, not a question


def test_garbage_and_frames_cut_anywhere_are_no_trouble(decode, companion):
    ask = mavlink.MAVLink_command_long_message(1, 1, 511, 0, RAW_IMU, 20_000, 0, 0, 0, 0, 0).pack(companion)
    vehicle = FakeAutopilot(SimSettings(scenario="still"), 1)
    noise = bytes(range(256))
    for position, byte in enumerate(noise + ask[:7] + ask + noise):
        vehicle.handle(bytes([byte]), position)
    messages = decode(vehicle.frames_until(2 * S))
    assert result(messages) == mavlink.MAV_RESULT_ACCEPTED
    assert len(messages["RAW_IMU"]) == 100


def test_streams_that_come_too_late_are_left_out_not_made_up_for():
    streams = Streams(ARDUPILOT, 400, None)
    assert streams.take_due(0) == ["HEARTBEAT"]
    assert streams.take_due(5 * S).count("RAW_IMU") == 1
    assert streams.take_due(5 * S + 1) == []
    assert streams.next_ns == 5 * S + S // 4
