"""What the encoder sends, read back by pymavlink (which checks the checksum)."""

import hashlib
import math
import struct

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.component.encoder import Encoder


@pytest.fixture
def encoder(dialect):
    return Encoder(dialect, 7, 193)


def parsed(raw):
    mav = pymav.MAVLink(None)
    (message,) = mav.parse_buffer(raw)
    assert (message.get_srcSystem(), message.get_srcComponent()) == (7, 193)
    assert raw[0] == 0xFD
    return message


def f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def test_heartbeat(encoder):
    message = parsed(encoder.heartbeat(18, 8, 0, 4))
    assert message.to_dict() == {
        "mavpackettype": "HEARTBEAT",
        "type": pymav.MAV_TYPE_ONBOARD_CONTROLLER,
        "autopilot": pymav.MAV_AUTOPILOT_INVALID,
        "base_mode": 0,
        "custom_mode": 0,
        "system_status": pymav.MAV_STATE_ACTIVE,
        "mavlink_version": 3,
    }


@pytest.mark.parametrize("name", ["GPS_DELAY_MS", "SIXTEEN_LETTERS_"])
def test_param_request_read(encoder, name):
    message = parsed(encoder.param_request_read(9, 1, name))
    assert message.to_dict() == {
        "mavpackettype": "PARAM_REQUEST_READ",
        "target_system": 9,
        "target_component": 1,
        "param_id": name,
        "param_index": -1,
    }


def test_attitude_quaternion(encoder):
    message = parsed(encoder.attitude_quaternion(4_000_000_000, (0.5, -0.5, 0.1, 0.7), (0.1, -0.2, 0.3)))
    assert message.get_type() == "ATTITUDE_QUATERNION"
    assert message.time_boot_ms == 4_000_000_000
    assert (message.q1, message.q2, message.q3, message.q4) == (0.5, -0.5, f32(0.1), f32(0.7))
    assert (message.rollspeed, message.pitchspeed, message.yawspeed) == (f32(0.1), f32(-0.2), f32(0.3))
    assert message.repr_offset_q == [0.0] * 4


def test_attitude_quaternion_cov(encoder):
    covariance = tuple(0.25 * i for i in range(9))
    message = parsed(encoder.attitude_quaternion_cov(1 << 40, (1.0, 0.0, 0.0, 0.5), (1.0, 2.0, 3.0), covariance))
    assert message.get_type() == "ATTITUDE_QUATERNION_COV"
    assert (message.time_usec, message.q, message.covariance) == (1 << 40, [1.0, 0.0, 0.0, 0.5], list(covariance))
    assert (message.rollspeed, message.pitchspeed, message.yawspeed) == (1.0, 2.0, 3.0)
    unknown = parsed(encoder.attitude_quaternion_cov(0, (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    assert all(math.isnan(value) for value in unknown.covariance)


def test_set_message_interval(encoder):
    message = parsed(encoder.set_message_interval(1, 1, 27, 20000, 3))
    assert message.get_type() == "COMMAND_LONG"
    assert message.command == pymav.MAV_CMD_SET_MESSAGE_INTERVAL
    assert (message.target_system, message.target_component, message.confirmation) == (1, 1, 3)
    assert (message.param1, message.param2, message.param7) == (27.0, 20000.0, 0.0)
    assert parsed(encoder.set_message_interval(1, 1, 27, -1)).param2 == -1.0


def test_request_data_stream(encoder):
    message = parsed(encoder.request_data_stream(2, 3, 1, 50))
    assert message.get_type() == "REQUEST_DATA_STREAM"
    assert (message.target_system, message.target_component) == (2, 3)
    assert (message.req_stream_id, message.req_message_rate, message.start_stop) == (1, 50, 1)
    assert parsed(encoder.request_data_stream(2, 3, 1, 0, start=False)).start_stop == 0


def test_command_ack(encoder):
    message = parsed(encoder.command_ack(511, 3, 255, 190))
    assert message.get_type() == "COMMAND_ACK"
    assert (message.command, message.result, message.target_system, message.target_component) == (511, 3, 255, 190)


def test_named_value_float_cuts_long_names(encoder):
    message = parsed(encoder.named_value_float(12, "ATT_TILT", 0.5))
    assert (message.get_type(), message.time_boot_ms, message.name, message.value) == (
        "NAMED_VALUE_FLOAT",
        12,
        "ATT_TILT",
        0.5,
    )
    assert parsed(encoder.named_value_float(12, "ATT_MUCH_TOO_LONG", 0.5)).name == "ATT_MUCH_T"


def test_statustext_cuts_at_fifty_bytes(encoder):
    message = parsed(encoder.statustext(4, "attitude disagrees"))
    assert (message.get_type(), message.severity, message.text) == ("STATUSTEXT", 4, "attitude disagrees")
    assert (message.id, message.chunk_seq) == (0, 0)
    assert parsed(encoder.statustext(4, "x" * 80)).text == "x" * 50
    assert parsed(encoder.statustext(4, "5° off")).text == "5? off"


def test_timesync(encoder):
    message = parsed(encoder.timesync(-5, 1 << 60))
    assert (message.get_type(), message.tc1, message.ts1) == ("TIMESYNC", -5, 1 << 60)


def test_any_message_by_its_fields(encoder):
    message = parsed(encoder.message("RAW_IMU", {"time_usec": 5, "zacc": -1000, "id": 2, "temperature": 300}))
    assert (message.get_type(), message.time_usec, message.xacc, message.zacc) == ("RAW_IMU", 5, 0, -1000)
    assert (message.id, message.temperature) == (2, 300)
    with pytest.raises(KeyError):
        encoder.message("NO_SUCH_MESSAGE", {})


def test_bytes_equal_pymavlinks(encoder):
    mav = pymav.MAVLink(None, 7, 193)
    theirs = b""
    for sequence, message in enumerate(
        (
            pymav.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3),
            pymav.MAVLink_timesync_message(0, 0),
            pymav.MAVLink_statustext_message(6, b"hello"),
        )
    ):
        mav.seq = sequence
        theirs += bytes(message.pack(mav))
    assert encoder.heartbeat(18, 8, 0, 4) + encoder.timesync(0, 0) + encoder.statustext(6, "hello") == theirs


def test_the_sequence_number_counts_and_wraps(encoder):
    numbers = [parsed(encoder.timesync(0, 1)).get_seq() for _ in range(258)]
    assert numbers == [*range(256), 0, 1]


def test_a_value_that_does_not_fit_is_the_callers_error(encoder):
    with pytest.raises(struct.error):
        encoder.heartbeat(300, 8, 0, 4)


KEY = hashlib.sha256(b"a key of the test").digest()


def sha256_signer(frame):
    """MAVLink's signature for link 3 at time 1, by the guide: a double of a signer that keeps its clock."""
    stamped = struct.pack("<BIH", 3, 1, 0)
    return stamped + hashlib.sha256(KEY + frame + stamped).digest()[:6]


def test_signed_frames_pass_pymavlinks_signature_check(dialect):
    encoder = Encoder(dialect, 7, 193, sha256_signer)
    for key, accepted in ((KEY, True), (bytes(32), False)):
        mav = pymav.MAVLink(None)
        mav.signing.secret_key = key
        raw = encoder.heartbeat(18, 8, 0, 4)
        assert raw[2] == pymav.MAVLINK_IFLAG_SIGNED
        assert len(raw) == 10 + raw[1] + 2 + pymav.MAVLINK_SIGNATURE_BLOCK_LEN
        if accepted:
            message = mav.decode(bytearray(raw))
            assert (message.get_type(), message.get_signed(), message.get_link_id()) == ("HEARTBEAT", True, 3)
        else:
            with pytest.raises(pymav.MAVError, match="signature"):
                mav.decode(bytearray(raw))


def test_without_a_signer_nothing_is_flagged_or_appended(encoder):
    raw = encoder.heartbeat(18, 8, 0, 4)
    assert (raw[2], len(raw)) == (0, 10 + raw[1] + 2)
