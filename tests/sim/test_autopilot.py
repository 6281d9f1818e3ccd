from itertools import pairwise
from math import inf, nan, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.algebra import heading_between, q_from_euler, tilt_between
from attest_mav.errors import UsageError
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

S = 1_000_000_000
END_NS = 3 * S


def run(cuts, seed=1, **choices):
    """All frames up to END_NS, asked for at the cuts, with a command on the way."""
    vehicle = FakeAutopilot(SimSettings(**choices), seed)
    companion = mavlink.MAVLink(None, srcSystem=1, srcComponent=193)
    ask = mavlink.MAVLink_command_long_message(1, 1, 511, 0, mavlink.MAVLINK_MSG_ID_ATTITUDE, 7_000, 0, 0, 0, 0, 0)
    asked_ns = 1_234_567_890
    frames = []
    for now_ns in sorted({*cuts, asked_ns, END_NS}):
        frames += vehicle.frames_until(now_ns)
        if now_ns == asked_ns:
            vehicle.handle(ask.pack(companion), now_ns)
    return frames


@pytest.mark.parametrize(
    "choices",
    [
        {"scenario": "hover"},
        {"scenario": "coordinated-turns"},
        {"personality": "px4", "loop_rate_hz": 250},
        {"faults": parse_faults(["reboot@1.5"])},
        {"faults": parse_faults(["gyro1-stop@1.1", "attitude-frozen@2+0.5"])},
    ],
)
@given(cuts=st.lists(st.integers(0, END_NS), max_size=12))
@settings(derandomize=True, max_examples=6, deadline=None)
def test_the_frames_do_not_depend_on_when_they_are_asked_for(choices, cuts):
    assert run(cuts, **choices) == run([], **choices)


def test_equal_seeds_give_equal_flights_and_others_do_not():
    assert run([], seed=5) == run([], seed=5)
    assert run([], seed=5) != run([], seed=6)


@pytest.mark.parametrize(
    ("personality", "scenario"), [("ardupilot", "hover"), ("ardupilot", "coordinated-turns"), ("px4", "still")]
)
def test_waking_at_the_deadlines_alone_misses_nothing_and_wakes_in_vain_never(personality, scenario):
    choices = SimSettings(personality=personality, scenario=scenario, faults=parse_faults(["reboot@1.5"]))
    vehicle = FakeAutopilot(choices, 1)
    frames, now_ns, in_vain = [], 0, 0
    while (now_ns := vehicle.next_deadline_ns) <= END_NS:
        assert vehicle.frames_until(now_ns - 1) == []
        found = vehicle.frames_until(now_ns)
        in_vain += not found
        frames += found
    frames += vehicle.frames_until(END_NS)
    assert frames == FakeAutopilot(choices, 1).frames_until(END_NS)
    assert in_vain <= 1  # at the reboot


def test_the_deadline_comes_forward_when_something_arrives(companion):
    vehicle = FakeAutopilot(SimSettings(), 1)
    vehicle.frames_until(2 * S)
    assert vehicle.next_deadline_ns == 2 * S + S // 4
    vehicle.handle(mavlink.MAVLink_timesync_message(0, 1).pack(companion), 2 * S + 1000)
    assert vehicle.next_deadline_ns == 2 * S + 2_500_000
    assert len(vehicle.frames_until(2 * S + 2_500_000)) == 1


def test_sequence_numbers_count_up(decode):
    frames = FakeAutopilot(SimSettings(fast_rate_hz=50.0), 1).frames_until(3 * S)
    assert len(frames) > 512
    sequence = [message.get_seq() for frame in frames for kind in decode([frame]).values() for message in kind]
    assert sequence == [k % 256 for k in range(len(frames))]


@pytest.mark.parametrize(
    ("choices", "text"),
    [
        ({"fast_rate_hz": 0.0}, "rate 0 Hz.*1 to 1000"),
        ({"fast_rate_hz": 1001.0}, "rate 1001 Hz.*1 to 1000"),
        ({"fast_rate_hz": nan}, "rate nan Hz"),
        ({"fast_rate_hz": inf}, "rate inf Hz"),
        ({"loop_rate_hz": 5}, "loop rate 5 Hz.*10 to 1000"),
        ({"personality": "betaflight"}, "'betaflight'.*ardupilot, px4"),
        ({"scenario": "loop"}, "'loop'.*still"),
    ],
)
def test_settings_that_make_no_sense_are_one_clear_error(choices, text):
    with pytest.raises(UsageError, match=text):
        FakeAutopilot(SimSettings(**choices), 1)


def fly(decode, fault, until_s, **choices):
    """Messages of a flight with a fault, and the vehicle."""
    vehicle = FakeAutopilot(SimSettings(faults=parse_faults([fault]), **({"fast_rate_hz": 50.0} | choices)), 1)
    return decode(vehicle.frames_until(round(until_s * S))), vehicle


def test_fault_the_reported_attitude_jumps(decode):
    messages, vehicle = fly(decode, "attitude-offset-north=6@5", 8.0, scenario="still")
    for attitude in messages["ATTITUDE"]:
        truth = vehicle.truth(attitude.time_boot_ms * 1_000_000).q_nb
        tilt = tilt_between(q_from_euler(attitude.roll, attitude.pitch, attitude.yaw), truth)
        assert tilt == pytest.approx(radians(6.0) if attitude.time_boot_ms >= 5000 else 0.0, abs=0.003)
    state = messages["SIM_STATE"][-1]
    assert tilt_between((state.q1, state.q2, state.q3, state.q4), vehicle.truth(0).q_nb) < 1e-6


def test_fault_the_reported_heading_jumps(decode):
    messages, vehicle = fly(decode, "attitude-offset-down=20@5", 6.0, scenario="still")
    last = messages["ATTITUDE"][-1]
    reported = q_from_euler(last.roll, last.pitch, last.yaw)
    assert tilt_between(reported, vehicle.truth(0).q_nb) < 0.003
    assert heading_between(reported, vehicle.truth(0).q_nb) == pytest.approx(radians(20.0), abs=0.005)


def test_fault_the_reported_attitude_freezes(decode):
    messages, _ = fly(decode, "attitude-frozen@12+2", 16.0)

    def distinct(start_ms, end_ms):
        span = [m for m in messages["ATTITUDE"] if start_ms <= m.time_boot_ms < end_ms]
        return len(span), len({(m.roll, m.pitch, m.yaw, m.rollspeed) for m in span})

    assert distinct(10_000, 12_000) == (100, 100)
    assert distinct(12_000, 14_000) == (100, 1)
    assert distinct(14_000, 16_000) == (100, 100)


def test_fault_a_gap_in_all_imu_messages_and_in_nothing_else(decode, companion):
    vehicle = FakeAutopilot(SimSettings(fast_rate_hz=50.0, faults=parse_faults(["imu-silent@3+1"])), 1)
    ask = mavlink.MAVLink_command_long_message(1, 1, 512, 0, mavlink.MAVLINK_MSG_ID_RAW_IMU, 0, 0, 0, 0, 0, 0)
    early = vehicle.frames_until(round(3.5 * S))
    vehicle.handle(ask.pack(companion), round(3.5 * S))
    messages = decode(early + vehicle.frames_until(5 * S))
    for name in ("RAW_IMU", "SCALED_IMU2"):
        times = [getattr(m, "time_usec", 0) or m.time_boot_ms * 1000 for m in messages[name]]
        assert max(np.diff(times)) == 1_020_000
        assert not any(3_000_000 <= t < 4_000_000 for t in times)
    assert len(messages["ATTITUDE"]) == 250
    assert len(messages["COMMAND_ACK"]) == 1


def test_fault_the_imu_stops_for_good(decode):
    messages, _ = fly(decode, "imu-silent@3", 10.0)
    assert messages["RAW_IMU"][-1].time_usec == 2_980_000
    assert messages["HEARTBEAT"][-1] is messages["HEARTBEAT"][10]


def test_fault_highres_imu_is_not_a_number(decode):
    messages, _ = fly(decode, "imu-nan@3+1", 5.0, personality="px4")
    bad = [m for m in messages["HIGHRES_IMU"] if np.isnan(m.xacc)]
    assert {3_000_000 <= m.time_usec < 4_000_000 for m in bad} == {True}
    assert len(bad) == 50
    assert all(np.isnan(m.zgyro) and not np.isnan(m.xmag) for m in bad)
    scaled = [m for m in messages["SCALED_IMU"] if 3000 <= m.time_boot_ms < 4000]
    assert {(m.zacc, m.xgyro) for m in scaled} == {(0, 0)}


def test_fault_the_sensors_are_at_the_end_of_their_range(decode):
    messages, _ = fly(decode, "imu-saturated@3+1", 5.0)
    inside = [m for m in messages["RAW_IMU"] if 3_200_000 <= m.time_usec < 4_000_000]
    outside = [m for m in messages["RAW_IMU"] if not 3_000_000 <= m.time_usec < 4_200_000]
    assert {m.xgyro for m in inside} == {32767}  # 34.9 rad/s do not fit into int16 milliradians
    assert {m.zacc for m in inside} <= {-16000, -15999}
    assert max(abs(m.xgyro) for m in outside) < 20


def test_fault_a_reboot_in_flight(decode, companion):
    vehicle = FakeAutopilot(SimSettings(faults=parse_faults(["reboot@12"])), 1)
    ask = mavlink.MAVLink_command_long_message(1, 1, 511, 0, mavlink.MAVLINK_MSG_ID_RAW_IMU, 20_000, 0, 0, 0, 0, 0)
    vehicle.handle(ask.pack(companion), S)
    before = vehicle.frames_until(12 * S - 1)
    assert vehicle.frames_until(13 * S) == []
    vehicle.handle(ask.pack(companion), 13 * S)  # nobody is there to hear it
    assert vehicle.frames_until(14 * S - 1) == []
    after = vehicle.frames_until(20 * S)
    assert after[0][4] == 0  # sequence number
    imu = decode(after)["RAW_IMU"]
    assert imu[0].time_usec == pytest.approx(2_250_000, abs=250_000)
    assert {round((b.time_usec - a.time_usec) * 1e-4) for a, b in pairwise(imu)} == {25}
    assert decode(before)["RAW_IMU"][-1].time_usec > 11_900_000
    fix = decode(after)["GPS_RAW_INT"][-1]
    assert fix.time_usec == pytest.approx(7_900_000, abs=200_000)  # the GPS tells time by the new clock
    answers = decode(after)
    assert "COMMAND_ACK" not in answers
    state = answers["SIM_STATE"][-1]
    truth = vehicle.truth(20 * S).q_nb
    assert (state.q1, state.q2, state.q3, state.q4) == pytest.approx(truth, abs=1e-6)  # the motion went on
