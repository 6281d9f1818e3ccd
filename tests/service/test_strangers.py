"""Strangers on the link change little, for a while, and not unseen: the whole service on virtual time."""

from math import radians

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.sim.settings import SimSettings

IMU_FILTER, GPS_DELAY = b"INS_GYRO_FILTER", b"GPS1_DELAY_MS"
HOVER = SimSettings(scenario="hover", fast_rate_hz=50.0)


class Stranger:
    """Sends whatever it likes under any ids, each with its own run of sequence numbers."""

    def __init__(self, flight, system=255, component=190):
        self.flight = flight
        self.mav = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)

    def say(self, message, link=0):
        data = message.pack(self.mav)
        self.mav.seq = (self.mav.seq + 1) % 256
        self.flight.service.receive(link, data, self.flight.now_ns)

    def command(self, number, p1, p2=0.0):
        self.say(mavlink.MAVLink_command_long_message(1, 193, number, 0, p1, p2, 0, 0, 0, 0, 0))

    def parameter(self, name, value):
        self.say(mavlink.MAVLink_param_value_message(name, value, mavlink.MAV_PARAM_TYPE_REAL32, 900, 65535))

    def beat(self, vehicle_type=6, autopilot=8):
        self.say(mavlink.MAVLink_heartbeat_message(vehicle_type, autopilot, 0, 0, 4, 3))


def repeat(flight, until_s, period_s, act):
    """Act every so often until then."""
    while flight.now_ns < until_s * 1e9:
        act()
        flight.run_until(min(flight.now_ns * 1e-9 + period_s, until_s))


def sent(flight, begin_s, end_s, name="ATTITUDE_QUATERNION"):
    return len(flight.of_type(name, begin_s, end_s)) / (end_s - begin_s)


def test_one_command_silences_the_output_for_a_while_with_its_sender_named(flight):
    f = flight("", HOVER)
    f.run_until(15.0)
    Stranger(f).command(511, 31.0, -1.0)
    f.run_until(40.0)
    assert sent(f, 15.1, 40.0) == 0.0
    assert "ATTITUDE_QUATERNION set to 0 Hz by 255/190 on udpin::0" in f.status()
    assert any("255/190 has set ATTITUDE_QUATERNION to 0 Hz" in text for text in f.texts)
    f.run_until(60.0)
    assert sent(f, 50.0, 60.0) == pytest.approx(20.0, abs=0.5), "that station is gone"
    assert "set to" not in f.status()
    assert any("is back at its own rate, 20 Hz: 255/190 is gone" in text for text in f.texts)


@pytest.mark.parametrize(("interval_us", "expected_hz"), [(1.0, 50.0), (1e7, 0.1)])
def test_an_interval_is_bounded(flight, interval_us, expected_hz):
    f = flight("", HOVER)
    f.run_until(15.0)
    Stranger(f).command(511, 31.0, interval_us)
    f.run_until(35.0)
    assert sent(f, 15.1, 35.0) == pytest.approx(expected_hz, abs=0.5)


def test_changes_a_hundred_times_a_second_are_one_line_a_minute(flight):
    f = flight("", HOVER)
    f.run_until(15.0)
    before, rate = len(f.texts), iter(range(1, 10**6))
    repeat(f, 35.0, 0.01, lambda: Stranger(f).command(511, 31.0, 20_000.0 + next(rate)))
    assert len(f.texts) - before <= 4


def test_commands_without_end_are_answered_at_twenty_a_second(flight):
    f = flight("", HOVER)
    f.run_until(15.0)
    before = len(f.texts)
    f.status()
    repeat(f, 20.0, 0.001, lambda: Stranger(f).command(512, 31.0))
    assert sent(f, 16.0, 20.0, "COMMAND_ACK") == pytest.approx(20.0, abs=1.0)
    assert sent(f, 16.0, 20.0) == pytest.approx(40.0, abs=2.0), "twenty of them are our own"
    assert f.status().split("sent ")[1].startswith("20.") or f.status().split("sent ")[1].startswith("19.")
    assert sum("more than 20 commands a second, the last from 255/190" in text for text in f.texts[before:]) == 1


def test_forged_onboard_heartbeats_replace_one_message_and_silence_nothing_else(flight):
    f = flight('yield_to_onboard = true\npublish = ["attitude_quaternion", "named_values"]\n', HOVER)
    f.run_until(15.0)
    forger = Stranger(f, 1, 191)
    repeat(f, 45.0, 4.9, lambda: forger.beat(18))
    assert sent(f, 15.1, 45.0) == 0.0
    assert sent(f, 15.1, 45.0, "ATTITUDE_QUATERNION_COV") == pytest.approx(5.0, abs=0.3)
    assert sent(f, 15.1, 45.0, "NAMED_VALUE_FLOAT") >= 2.0
    assert "held back on udpin::0 for component 191" in f.status()
    f.run_until(65.0)
    assert sent(f, 51.0, 65.0) == pytest.approx(20.0, abs=0.5)
    assert sent(f, 51.0, 65.0, "ATTITUDE_QUATERNION_COV") == 0.0


def test_a_forged_heartbeat_of_the_vehicle_itself_is_no_onboard_computer(flight):
    f = flight("", HOVER)
    f.run_until(15.0)
    forger = Stranger(f, 1, 1)
    repeat(f, 25.0, 1.0, lambda: forger.beat(18))
    assert sent(f, 16.0, 25.0) == pytest.approx(20.0, abs=0.5)


def settings_of(flight):
    return flight.snapshot().vehicle.settings


@pytest.mark.parametrize("period_s", [10.0, 1.0, 0.02])
def test_a_parameter_that_nobody_asked_for_changes_nothing(flight, period_s):
    f = flight("", HOVER)
    f.run_until(15.0)
    before, lines = settings_of(f), len(f.texts)
    forger = Stranger(f, 1, 1)

    def forge():
        forger.parameter(IMU_FILTER, 1.0)
        forger.parameter(GPS_DELAY, 1000.0)
        forger.parameter(b"AHRS_TRIM_X", radians(8.0))

    repeat(f, 75.0, period_s, forge)
    assert settings_of(f) == before
    assert max(f.errors_deg(20.0)) < 3.0
    assert len(f.texts) - lines <= 3 * 2
    assert "INS_GYRO_FILTER" in f.status()
    assert sum(one.param_id == "INS_GYRO_FILTER" for one in f.of_type("PARAM_REQUEST_READ", 15.0)) <= 5


def test_values_that_alternate_write_no_log(flight):
    f = flight("", HOVER)
    f.run_until(15.0)
    lines, forger, value = len(f.texts), Stranger(f, 1, 1), iter(range(10, 10**6))
    repeat(f, 45.0, 0.02, lambda: forger.parameter(IMU_FILTER, 1.0 + next(value) % 900))
    assert len(f.texts) - lines <= 2


def test_a_change_that_the_autopilot_confirms_counts_within_a_second(flight):
    f = flight("", HOVER)
    f.run_until(15.0)
    station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    change = mavlink.MAVLink_param_set_message(1, 1, IMU_FILTER, 40.0, mavlink.MAV_PARAM_TYPE_REAL32)
    f.vehicle.handle(change.pack(station), f.now_ns)
    f.run_until(16.0)
    assert settings_of(f).low_pass_hz == 40.0


def test_positions_that_jump_are_looked_up_at_most_each_ten_seconds(flight):
    f = flight("", HOVER)
    f.run_until(15.0)
    lines, forger, number = len(f.texts), Stranger(f, 1, 1), iter(range(10**6))

    def forge():
        jump = next(number) * 7_000_000 % 900_000_000
        message = mavlink.MAVLink_gps_raw_int_message(f.now_ns // 1000, 3, jump, 2140000000, 0, 50, 50, 0, 0, 12)
        forger.say(message)

    repeat(f, 35.0, 0.02, forge)
    assert sum("headings are true" in text for text in f.texts[lines:]) <= 1
