"""Commands that others send us, with pymavlink as the sender."""

import math

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.mavlink.component.companion_settings import CompanionSettings

ACCEPTED, REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
REQUEST, INTERVAL, ARM = 512, 511, 400


def command_long(number, p1=0.0, p2=0.0, target=(1, 193)):
    return mavlink.MAVLink_command_long_message(*target, number, 0, p1, p2, 0, 0, 0, 0, 0)


def command_int(number, p1=0.0, p2=0.0, target=(1, 193)):
    return mavlink.MAVLink_command_int_message(*target, 0, number, 0, 0, p1, p2, 0, 0, 0, 0, 0)


@pytest.fixture
def ready(bench, estimate):
    """A bench with a vehicle and an estimate, and nothing sent yet."""
    b = bench(CompanionSettings(publish_hz=10.0))
    b.vehicle_heartbeat()
    b.publish(estimate(t_s=1.0))
    b.sent[0].clear()
    return b


def ask(b, message):
    """Send the message as a ground station; the ACK and everything else that came back."""
    before = len(b.sent[0])
    b.hear(message, system=255, component=190)
    back = b.sent[0][before:]
    acks = [one for one in back if one.get_type() == "COMMAND_ACK"]
    assert len(acks) <= 1
    for ack in acks:
        assert (ack.target_system, ack.target_component) == (255, 190)
    return (acks[0].command, acks[0].result) if acks else None, [one.get_type() for one in back if one not in acks]


@pytest.mark.parametrize("make", [command_long, command_int])
@pytest.mark.parametrize("target", [(0, 0), (1, 0), (1, 193)])
@pytest.mark.parametrize(
    ("message_id", "name"), [(0, "HEARTBEAT"), (31, "ATTITUDE_QUATERNION"), (61, "ATTITUDE_QUATERNION_COV")]
)
def test_what_we_send_can_be_requested(ready, make, target, message_id, name):
    assert ask(ready, make(REQUEST, message_id, target=target)) == ((REQUEST, ACCEPTED), [name])


@pytest.mark.parametrize("target", [(1, 1), (1, 191), (2, 0), (2, 193), (0, 193)])
def test_what_is_meant_for_others_is_left_alone(ready, target):
    assert ask(ready, command_long(REQUEST, 31, target=target)) == (None, [])


def test_an_attitude_that_is_not_there_is_rejected_for_the_moment(bench):
    b = bench()
    b.vehicle_heartbeat()
    b.sent[0].clear()
    assert ask(b, command_long(REQUEST, 31)) == ((REQUEST, REJECTED), [])


def test_a_withdrawn_estimate_is_not_sent(ready):
    ready.companion.withdraw()
    assert ask(ready, command_long(REQUEST, 31)) == ((REQUEST, REJECTED), [])


@pytest.mark.parametrize("message", [command_long(ARM, 1.0), command_int(ARM, 1.0), command_long(REQUEST, 148)])
def test_everything_else_is_unsupported(ready, message):
    (_, result), sent = ask(ready, message)
    assert (result, sent) == (UNSUPPORTED, [])


def test_a_command_to_all_is_not_ours_to_refuse(ready):
    assert ask(ready, command_long(ARM, 1.0, target=(1, 0))) == (None, [])


@pytest.mark.parametrize("interval_us", [math.nan, math.inf, -math.inf, 1e30])
def test_an_interval_that_is_no_interval_is_denied(ready, interval_us):
    assert ask(ready, command_long(INTERVAL, 31, interval_us))[0] == (INTERVAL, DENIED)


@pytest.mark.parametrize("message_id", [math.nan, 1e30, -1.0, 27.0, 31.5])
def test_an_interval_of_what_we_do_not_send_is_unsupported(ready, message_id):
    assert ask(ready, command_long(INTERVAL, message_id, 20_000))[0] == (INTERVAL, UNSUPPORTED)


@pytest.mark.parametrize(("interval_us", "expected"), [(500_000, 20), (-1, 0), (0, 100), (20_000, 500)])
def test_the_interval_sets_the_rate(ready, estimate, interval_us, expected):
    assert ask(ready, command_long(INTERVAL, 31, interval_us))[0] == (INTERVAL, ACCEPTED)
    ready.sent[0].clear()
    for number in range(1000):  # ten seconds at 100 Hz
        ready.publish(estimate(t_s=10.0 + number / 100))
    assert len(ready.of_type("ATTITUDE_QUATERNION")) == pytest.approx(expected, abs=1)
