"""UNIX time in a message becomes time since boot, by what SYSTEM_TIME told."""

import pytest
from pymavlink.dialects.v20 import all as mavlink

from attest_mav.mavlink.decode.boot_clock import IMPOSSIBLE, UNKNOWN, BootClock
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.samples import ImuSample
from attest_mav.vehicle_reports import ClockSample

BOOT_US = 1_790_000_000_000_000
"""A day in 2026."""


def test_time_since_boot_stays_as_it_is():
    assert BootClock().since_boot_ns(1, 123_456_789) == 123_456_789_000


def test_unix_time_waits_for_system_time():
    clock = BootClock()
    assert clock.since_boot_ns(1, BOOT_US + 5_000_000) == UNKNOWN
    clock.learn(1, 0, 4_000)
    assert clock.since_boot_ns(1, BOOT_US + 5_000_000) == UNKNOWN, "a wall clock that is not set tells nothing"
    clock.learn(1, BOOT_US + 4_000_000, 4_000)
    assert clock.since_boot_ns(1, BOOT_US + 5_000_000) == 5_000_000_000
    assert clock.since_boot_ns(2, BOOT_US + 5_000_000) == UNKNOWN, "another system has another clock"


def test_a_simulators_boot_in_1970_shows_in_the_last_32_bits():
    boot_ms = (BOOT_US // 1000) % (1 << 32)
    clock = BootClock()
    clock.learn(1, 0, boot_ms)
    assert clock.since_boot_ns(1, BOOT_US + 5_000_001) == (boot_ms * 1000 + 5_000_001) * 1000
    assert clock.since_boot_ns(1, BOOT_US + 900_000_000) == (boot_ms * 1000 + 900_000_000) * 1000, "once seen, it holds"
    assert clock.since_boot_ns(2, BOOT_US) == UNKNOWN, "another system has another clock"
    wrapping = BootClock()
    wrapping.learn(1, 0, (1 << 32) - 1000)
    near_us = 400 * (1000 << 32)
    assert wrapping.since_boot_ns(1, near_us + 500_000) == 500_000_000, "the counter begins again between the two"


def test_rounding_of_system_time_does_not_move_the_samples_and_a_reboot_does():
    clock = BootClock()
    clock.learn(1, BOOT_US + 4_000_700, 4_000)
    first = clock.since_boot_ns(1, BOOT_US + 5_000_000)
    clock.learn(1, BOOT_US + 5_000_100, 5_000)
    assert clock.since_boot_ns(1, BOOT_US + 5_000_000) == first
    clock.learn(1, BOOT_US + 62_000_000, 2_000)
    assert clock.since_boot_ns(1, BOOT_US + 62_500_000) == 2_500_000_000


@pytest.mark.parametrize("time_us", [1 << 53, (1 << 64) - 1, BOOT_US - 10_000_000])
def test_times_that_cannot_be_are_told(time_us):
    clock = BootClock()
    clock.learn(1, BOOT_US, 0)
    assert clock.since_boot_ns(1, time_us) == IMPOSSIBLE


def test_an_imu_that_carries_unix_time_gives_samples_in_the_autopilots_time():
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    dialect = load_dialect()
    decoder = Decoder(dialect)
    framer = Framer(dialect, decoder.wanted)

    def samples(message):
        return [one for frame in framer.feed(message.pack(sender), 0) for one in decoder.decode(frame)]

    def raw_imu(t_us):
        return mavlink.MAVLink_raw_imu_message(BOOT_US + t_us, 0, 0, -1000, 1, 2, 3, 200, 0, -400)

    samples(mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))
    assert samples(raw_imu(1_000_000)) == []
    assert "UNIX time" in decoder.refusals["RAW_IMU"]
    assert isinstance(samples(mavlink.MAVLink_system_time_message(BOOT_US + 1_500_000, 1_500))[0], ClockSample)
    taken = [one for k in range(10) for one in samples(raw_imu(2_000_000 + 20_000 * k))]
    assert all(isinstance(one, ImuSample) for one in taken)
    assert [one.t_ns for one in taken] == [2_000_000_000 + 20_000_000 * k for k in range(10)]
    assert decoder.refusals == {}
